#include "orthodrive/segment/experiment.hpp"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <set>

#include "orthodrive/core/error.hpp"

namespace orthodrive {
namespace {

/// One table of the file: hands out its values and knows which keys nobody asked for.
class Section {
 public:
  Section(const toml::table& table, const std::filesystem::path& file) : table_(table), file_(file) {}

  template <typename T>
  void read(const char* key, T& value) {
    const toml::node* node = find(key);
    if (!node) return;
    if constexpr (std::is_same_v<T, std::filesystem::path>) {
      const auto text = node->value<std::string>();
      if (!text) fail(*node, fmt::format("'{}' must be a path", key));
      value = file_.parent_path() / *text;
    } else if constexpr (std::is_arithmetic_v<T> && !std::is_same_v<T, bool>) {
      const auto number = node->value<double>();
      if (!number) fail(*node, fmt::format("'{}' must be a number", key));
      value = static_cast<T>(*number);
    } else {
      const auto found = node->value<T>();
      if (!found) fail(*node, fmt::format("'{}' has the wrong type", key));
      value = *found;
    }
  }

  template <typename T>
  void read(const char* key, std::vector<T>& values) {
    const toml::node* node = find(key);
    if (!node) return;
    if (!node->is_array()) fail(*node, fmt::format("'{}' must be a list", key));
    values.clear();
    for (const toml::node& entry : *node->as_array()) {
      const auto value = entry.value<T>();
      if (!value) fail(entry, fmt::format("'{}' has an entry of the wrong type", key));
      values.push_back(*value);
    }
  }

  /// west, south, east, north
  template <typename Take>
  void read_box(const char* key, const Take& take) {
    std::vector<double> box;
    read(key, box);
    if (!table_.contains(key)) return;
    if (box.size() != 4) fail(*table_.get(key), fmt::format("'{}' must be [west, south, east, north]", key));
    take(Box2{box[0], box[1], box[2], box[3]});
  }

  template <typename Visit>
  void for_each_table(const char* key, const Visit& visit) {
    const toml::node* node = find(key);
    if (!node) return;
    if (!node->is_array_of_tables()) fail(*node, fmt::format("'{}' must be a list of tables", key));
    for (const toml::node& entry : *node->as_array()) {
      Section section(*entry.as_table(), file_);
      visit(section);
      section.finish();
    }
  }

  const toml::table* find_table(const char* key) {
    const toml::node* node = find(key);
    if (node && !node->is_table()) fail(*node, fmt::format("'{}' must be a table", key));
    return node ? node->as_table() : nullptr;
  }

  void require(const char* key) const {
    if (!table_.contains(key)) fail(table_, fmt::format("'{}' is missing here", key));
  }

  void finish() const {
    for (const auto& [key, node] : table_) {
      if (!used_.contains(std::string(key.str()))) fail(node, fmt::format("'{}' is not known here", key.str()));
    }
  }

  [[noreturn]] void fail(const toml::node& node, const std::string& what) const {
    throw InputError(fmt::format("{}:{}", file_.string(), node.source().begin.line), what);
  }

 private:
  const toml::node* find(const char* key) {
    used_.insert(key);
    return table_.get(key);
  }

  const toml::table& table_;
  const std::filesystem::path& file_;
  std::set<std::string> used_;
};

void read_use(Section& section, SceneUse& use) {
  section.read("weight", use.weight);
  section.read("min_zoom", use.min_zoom);
  section.read("max_zoom", use.max_zoom);
  section.read("from_step", use.from_step);
}

PaintRule read_rule(Section& section) {
  PaintRule rule;
  section.require("file");
  section.read("file", rule.file);
  if (const toml::table* where = section.find_table("where")) {
    for (const auto& [key, node] : *where) {
      auto& values = rule.where[std::string(key.str())];
      if (!node.is_array()) section.fail(node, fmt::format("'{}' must be a list of values", key.str()));
      for (const toml::node& entry : *node.as_array()) values.push_back(entry.value_or<std::string>(""));
    }
  }
  section.read("highways", rule.highways);
  section.read("classes", rule.classes);
  section.read("merge_over", rule.merge_over);
  section.read("line_width_m", rule.line_width_m);
  section.read("unknown_inside_m", rule.unknown_inside_m);
  section.read("unknown_outside_m", rule.unknown_outside_m);
  return rule;
}

MapData read_map(Section& section) {
  MapData map;
  for (const char* key : {"name", "photo", "bbox_wgs84", "background"}) section.require(key);
  section.read("name", map.name);
  section.read("photo", map.photo);
  section.read_box("bbox_wgs84", [&](const Box2& box) { map.area_lonlat = box; });
  section.read_box("held_out_bbox_wgs84", [&](const Box2& box) { map.held_out_lonlat = box; });
  section.read("background", map.background);
  read_use(section, map.use);
  section.for_each_table("paint", [&](Section& rule) { map.rules.push_back(read_rule(rule)); });
  return map;
}

ImageData read_images(Section& section) {
  ImageData data;
  for (const char* key : {"name", "images", "labels", "palette"}) section.require(key);
  section.read("name", data.name);
  section.read("images", data.images);
  section.read("labels", data.labels);
  section.read("gsd_m", data.gsd_m);
  section.read("held_out", data.held_out);
  section.for_each_table("palette", [&](Section& entry) {
    std::vector<std::int64_t> color;
    std::vector<std::string> classes;
    entry.read("color", color);
    entry.read("classes", classes);
    color.resize(3);
    data.palette[{static_cast<std::uint8_t>(color[0]), static_cast<std::uint8_t>(color[1]),
                  static_cast<std::uint8_t>(color[2])}] = classes;
  });
  read_use(section, data.use);
  return data;
}

SyntheticData read_synthetic(Section& section) {
  SyntheticData data;
  for (const char* key : {"name", "folder"}) section.require(key);
  section.read("name", data.name);
  section.read("folder", data.folder);
  section.read("held_out", data.held_out);
  read_use(section, data.use);
  return data;
}

void read_train(Section& section, TrainOptions& train) {
  section.read("steps", train.steps);
  section.read("warmup_steps", train.warmup_steps);
  section.read("decay_from_step", train.decay_from_step);
  section.read("learning_rate", train.learning_rate);
  section.read("trunk_rate_factor", train.trunk_rate_factor);
  section.read("weight_decay", train.weight_decay);
  section.read("freeze_norm_from_step", train.freeze_norm_from_step);
  section.read("batch", train.batch);
  section.read("crop_px", train.crop_px);
  section.read("class_weights", train.class_weights);
  section.read("set_weight", train.set_weight);
  section.read("seed", train.seed);
  section.read("validate_every", train.validate_every);
}

}  // namespace

Experiment parse_experiment(std::string_view text, const std::filesystem::path& file) {
  toml::table table;
  try {
    table = toml::parse(text);
  } catch (const toml::parse_error& error) {
    throw InputError(fmt::format("{}:{}", file.string(), error.source().begin.line), std::string(error.description()));
  }
  Experiment experiment;
  Section root(table, file);
  for (const char* key : {"trunk", "train"}) root.require(key);
  root.read("trunk", experiment.trunk);
  root.read("gsd_m", experiment.gsd_m);
  if (const toml::table* train = root.find_table("train")) {
    Section section(*train, file);
    read_train(section, experiment.train);
    section.finish();
  }
  root.for_each_table("map", [&](Section& section) { experiment.maps.push_back(read_map(section)); });
  root.for_each_table("images", [&](Section& section) { experiment.images.push_back(read_images(section)); });
  root.for_each_table("synthetic", [&](Section& section) { experiment.synthetic.push_back(read_synthetic(section)); });
  root.finish();
  return experiment;
}

ClassSet class_set(const std::vector<std::string>& names, const ClassTable& table, const std::string& source) {
  ClassSet set = unknown_class;
  for (const std::string& name : names) {
    std::size_t label = 0;
    while (label < table.classes.size() && table.classes[label].name != name) ++label;
    if (label == table.classes.size())
      throw InputError(source, fmt::format("class '{}' is not in the table '{}'", name, table.name));
    set = static_cast<ClassSet>(set | only(static_cast<int>(label)));
  }
  return set;
}

}  // namespace orthodrive
