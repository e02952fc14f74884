// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/lab/training/packed_scenes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <limits>
#include <nlohmann/json.hpp>
#include <span>
#include <unordered_set>
#include <utility>

#include "orthodrive/core/error.hpp"
#include "orthodrive/io/models/safetensors_stream.hpp"

namespace orthodrive {
namespace {

constexpr const char* format_key = "packed_scenes";
constexpr const char* format_version = "1";
constexpr const char* scenes_key = "scenes";
constexpr std::size_t piece_pixels = 1 << 17;  // 1 MiB of sets
constexpr std::size_t most_indexed_sets = 256;

std::string tensor_name(std::size_t scene, const char* part) { return fmt::format("scene/{}/{}", scene, part); }

/// The rasters of a scene of either kind.
struct SceneView {
  const std::string* name;
  const Raster<std::uint8_t>* rgb;
  const Raster<ClassSet>* allowed;
  const Raster<std::uint8_t>* valid = nullptr;
};

std::vector<SceneView> views_of(const PackedScenes& data) {
  std::vector<SceneView> views;
  views.reserve(data.scenes.size());
  for (const TrainingScene& s : data.scenes) views.push_back({&s.name, &s.rgb, &s.allowed});
  for (const ValidationScene& s : data.validation) views.push_back({&s.name, &s.photo.rgb, &s.allowed, &s.photo.valid});
  for (const SceneView& v : views) {
    const auto fits = [&](const auto& raster, int channels) {
      return raster.width == v.rgb->width && raster.height == v.rgb->height && raster.channels == channels &&
             raster.data.size() == static_cast<std::size_t>(raster.width) * static_cast<std::size_t>(raster.height) *
                                       static_cast<std::size_t>(channels);
    };
    if (!fits(*v.rgb, 3) || !fits(*v.allowed, 1) || (v.valid && !fits(*v.valid, 1))) {
      throw Error(fmt::format("scene '{}': photo and labels differ in size or channels", *v.name));
    }
  }
  return views;
}

/// Each line: half its width, then x and y of its points.
nlohmann::json describe(const std::vector<RoadLine>& map) {
  nlohmann::json lines = nlohmann::json::array();
  for (const RoadLine& line : map) {
    std::vector<double> numbers{line.half_width};
    for (const Vec2 p : line.points) numbers.insert(numbers.end(), {p.x, p.y});
    lines.push_back(std::move(numbers));
  }
  return lines;
}

std::vector<RoadLine> read_map(const nlohmann::json& lines) {
  std::vector<RoadLine> map;
  for (const nlohmann::json& entry : lines) {
    const auto numbers = entry.get<std::vector<double>>();
    RoadLine& line = map.emplace_back(RoadLine{{}, numbers.empty() ? 0.0 : numbers.front()});
    for (std::size_t i = 1; i + 1 < numbers.size(); i += 2) line.points.push_back({numbers[i], numbers[i + 1]});
  }
  return map;
}

nlohmann::json describe(const PackedScenes& data) {
  nlohmann::json list = nlohmann::json::array();
  for (const TrainingScene& s : data.scenes) {
    list.push_back({{"part", "train"},
                    {"name", s.name},
                    {"gsd_m", s.gsd_m},
                    {"weight", s.weight},
                    {"min_zoom", s.min_zoom},
                    {"max_zoom", s.max_zoom},
                    {"from_step", s.from_step},
                    {"crf_only", s.crf_only},
                    {"map", describe(s.map)}});
  }
  for (const ValidationScene& s : data.validation) {
    list.push_back({{"part", "validation"},
                    {"name", s.name},
                    {"crs", s.photo.crs.definition},
                    {"west_m", s.photo.frame.west_m},
                    {"north_m", s.photo.frame.north_m},
                    {"gsd_m", s.photo.frame.gsd_m}});
    if (s.map) list.back()["map"] = describe(*s.map);
  }
  return list;
}

std::vector<ClassSet> distinct_sets(const Raster<ClassSet>& allowed) {
  std::unordered_set<ClassSet> seen;
  const ClassSet* last = nullptr;  // labels come in runs
  for (const ClassSet& set : allowed.data) {
    if (last && *last == set) continue;
    seen.insert(set);
    last = &set;
  }
  std::vector<ClassSet> sets(seen.begin(), seen.end());
  std::sort(sets.begin(), sets.end());
  return sets;
}

/// Calls `use(begin, end)` for pieces of [0, count).
template <typename Use>
void in_pieces(std::size_t count, const Use& use) {
  for (std::size_t begin = 0; begin < count; begin += piece_pixels) use(begin, std::min(count, begin + piece_pixels));
}

std::int64_t bits_of(ClassSet set) { return static_cast<std::int64_t>(static_cast<std::uint64_t>(set)); }

void write_allowed(SafetensorsWriter& writer, std::size_t scene, const Raster<ClassSet>& allowed,
                   const std::vector<ClassSet>& sets) {
  const std::string name = tensor_name(scene, "allowed");
  std::vector<std::uint8_t> indices;
  std::vector<std::int64_t> bits;
  in_pieces(allowed.data.size(), [&](std::size_t begin, std::size_t end) {
    if (sets.size() > most_indexed_sets) {
      bits.resize(end - begin);
      std::transform(&allowed.data[begin], &allowed.data[begin] + bits.size(), bits.begin(), bits_of);
      return writer.write(name, std::as_bytes(std::span(bits)));
    }
    indices.resize(end - begin);
    std::size_t last = 0;
    for (std::size_t i = begin; i < end; ++i) {
      const ClassSet set = allowed.data[i];
      if (sets[last] != set) {
        last = static_cast<std::size_t>(std::lower_bound(sets.begin(), sets.end(), set) - sets.begin());
      }
      indices[i - begin] = static_cast<std::uint8_t>(last);
    }
    writer.write(name, std::as_bytes(std::span(indices)));
  });
  bits.resize(sets.size());
  std::transform(sets.begin(), sets.end(), bits.begin(), bits_of);
  if (sets.size() <= most_indexed_sets) writer.write(tensor_name(scene, "sets"), std::as_bytes(std::span(bits)));
}

/// Reads the tensors of one file, with messages that name the scene.
class SceneReader {
 public:
  explicit SceneReader(const std::filesystem::path& file) : reader_(file) {}

  [[nodiscard]] const std::map<std::string, std::string>& metadata() const { return reader_.metadata(); }

  /// The JSON array of "scenes".
  [[nodiscard]] nlohmann::json scenes() const {
    const auto version = metadata().find(format_key), list = metadata().find(scenes_key);
    if (version == metadata().end() || list == metadata().end()) {
      throw InputError(reader_.source(), "is no packed training data: use a file written by 'orthodrive train --pack'");
    }
    if (version->second != format_version) {
      throw InputError(reader_.source(), fmt::format("is packed in format {}, this program reads {}: pack it again",
                                                     version->second, format_version));
    }
    return nlohmann::json::parse(list->second);
  }

  [[nodiscard]] Raster<std::uint8_t> read_rgb(std::size_t scene) {
    const TensorPlace& place = reader_.place(tensor_name(scene, "rgb"), TensorType::u8);
    const auto& shape = place.shape;
    constexpr std::int64_t most = std::numeric_limits<int>::max();
    if (shape.size() != 3 || shape[2] != 3 || shape[0] > most || shape[1] > most) fail(scene, "rgb is not H x W x 3");
    return read_raster(place, static_cast<int>(shape[1]), static_cast<int>(shape[0]), 3);
  }

  [[nodiscard]] Raster<std::uint8_t> read_mask(std::size_t scene, const char* part, const Raster<std::uint8_t>& rgb) {
    const TensorPlace& place = reader_.place(tensor_name(scene, part), TensorType::u8);
    check_size(scene, place, part, rgb);
    return read_raster(place, rgb.width, rgb.height, 1);
  }

  [[nodiscard]] Raster<ClassSet> read_allowed(std::size_t scene, const Raster<std::uint8_t>& rgb) {
    const std::string name = tensor_name(scene, "allowed");
    const bool indexed = reader_.tensors().contains(tensor_name(scene, "sets"));
    const TensorPlace& place = reader_.place(name, indexed ? TensorType::u8 : TensorType::i64);
    check_size(scene, place, "allowed", rgb);
    std::vector<ClassSet> sets;
    if (indexed) {
      for (const std::int64_t bits : reader_.read_i64(tensor_name(scene, "sets"))) sets.push_back(set_of(scene, bits));
    }
    Raster<ClassSet> allowed(rgb.width, rgb.height);
    std::vector<std::uint8_t> indices;
    std::vector<std::int64_t> bits;
    in_pieces(allowed.data.size(), [&](std::size_t begin, std::size_t end) {
      if (indexed) {
        indices.resize(end - begin);
        reader_.read(place, begin, std::as_writable_bytes(std::span(indices)));
        if (*std::max_element(indices.begin(), indices.end()) >= sets.size()) {
          fail(scene, "a label points outside its table of sets");
        }
        std::transform(indices.begin(), indices.end(), &allowed.data[begin], [&](std::uint8_t i) { return sets[i]; });
      } else {
        bits.resize(end - begin);
        reader_.read(place, begin * sizeof(std::int64_t), std::as_writable_bytes(std::span(bits)));
        std::transform(bits.begin(), bits.end(), &allowed.data[begin],
                       [&](std::int64_t b) { return set_of(scene, b); });
      }
    });
    return allowed;
  }

  [[noreturn]] void fail(std::size_t scene, const std::string& what) const {
    throw InputError(reader_.source(), fmt::format("scene {}: {}: pack it again", scene, what));
  }

 private:
  Raster<std::uint8_t> read_raster(const TensorPlace& place, int width, int height, int channels) {
    Raster<std::uint8_t> raster(width, height, channels);
    reader_.read(place, 0, std::as_writable_bytes(std::span(raster.data)));
    return raster;
  }
  void check_size(std::size_t scene, const TensorPlace& place, const char* part,
                  const Raster<std::uint8_t>& rgb) const {
    if (place.shape != std::vector<std::int64_t>{rgb.height, rgb.width}) {
      fail(scene, fmt::format("{} is not of the size of the photo", part));
    }
  }
  ClassSet set_of(std::size_t scene, std::int64_t bits) const {
    const auto set = static_cast<ClassSet>(static_cast<std::uint64_t>(bits));
    if (bits_of(set) != bits) fail(scene, fmt::format("labels of more than {} classes", 8 * sizeof(ClassSet)));
    return set;
  }

  SafetensorsReader reader_;
};

TrainingScene read_training_scene(SceneReader& reader, std::size_t i, const nlohmann::json& entry) {
  TrainingScene scene;
  entry.at("name").get_to(scene.name);
  entry.at("gsd_m").get_to(scene.gsd_m);
  entry.at("weight").get_to(scene.weight);
  entry.at("min_zoom").get_to(scene.min_zoom);
  entry.at("max_zoom").get_to(scene.max_zoom);
  entry.at("from_step").get_to(scene.from_step);
  scene.crf_only = entry.value("crf_only", false);
  if (entry.contains("map")) scene.map = read_map(entry.at("map"));
  scene.rgb = reader.read_rgb(i);
  scene.allowed = reader.read_allowed(i, scene.rgb);
  return scene;
}

ValidationScene read_validation_scene(SceneReader& reader, std::size_t i, const nlohmann::json& entry) {
  ValidationScene scene;
  Photo& photo = scene.photo;
  entry.at("name").get_to(scene.name);
  entry.at("crs").get_to(photo.crs.definition);
  entry.at("west_m").get_to(photo.frame.west_m);
  entry.at("north_m").get_to(photo.frame.north_m);
  entry.at("gsd_m").get_to(photo.frame.gsd_m);
  if (entry.contains("map")) scene.map = read_map(entry.at("map"));
  photo.rgb = reader.read_rgb(i);
  photo.frame.width = photo.rgb.width, photo.frame.height = photo.rgb.height;
  photo.valid = reader.read_mask(i, "valid", photo.rgb);
  scene.allowed = reader.read_allowed(i, photo.rgb);
  return scene;
}

}  // namespace

void write_packed_scenes(std::ostream& out, const PackedScenes& data) {
  const std::vector<SceneView> views = views_of(data);
  std::map<std::string, std::string> metadata = data.metadata;
  metadata[format_key] = format_version;
  metadata[scenes_key] = describe(data).dump();
  std::vector<TensorSpec> specs;
  std::vector<std::vector<ClassSet>> sets;
  for (std::size_t i = 0; i < views.size(); ++i) {
    const std::int64_t height = views[i].rgb->height, width = views[i].rgb->width;
    sets.push_back(distinct_sets(*views[i].allowed));
    const bool indexed = sets[i].size() <= most_indexed_sets;
    specs.push_back({tensor_name(i, "rgb"), TensorType::u8, {height, width, 3}});
    specs.push_back({tensor_name(i, "allowed"), indexed ? TensorType::u8 : TensorType::i64, {height, width}});
    if (indexed) {
      specs.push_back({tensor_name(i, "sets"), TensorType::i64, {static_cast<std::int64_t>(sets[i].size())}});
    }
    if (views[i].valid) specs.push_back({tensor_name(i, "valid"), TensorType::u8, {height, width}});
  }
  SafetensorsWriter writer(out, metadata, std::move(specs));
  for (std::size_t i = 0; i < views.size(); ++i) {
    writer.write(tensor_name(i, "rgb"), std::as_bytes(std::span(views[i].rgb->data)));
    write_allowed(writer, i, *views[i].allowed, sets[i]);
    if (views[i].valid) writer.write(tensor_name(i, "valid"), std::as_bytes(std::span(views[i].valid->data)));
  }
  writer.finish();
}

PackedScenes read_packed_scenes(const std::filesystem::path& file) {
  SceneReader reader(file);
  PackedScenes data;
  data.metadata = reader.metadata();
  try {
    const nlohmann::json entries = reader.scenes();
    for (std::size_t i = 0; i < entries.size(); ++i) {
      const auto part = entries.at(i).at("part").get<std::string>();
      if (part == "train") {
        data.scenes.push_back(read_training_scene(reader, i, entries.at(i)));
      } else if (part == "validation") {
        data.validation.push_back(read_validation_scene(reader, i, entries.at(i)));
      } else {
        reader.fail(i, fmt::format("unknown part '{}'", part));
      }
    }
  } catch (const nlohmann::json::exception& error) {
    throw InputError(file.string(),
                     fmt::format("the description of its scenes is damaged ({}): pack it again", error.what()));
  }
  data.metadata.erase(format_key);
  data.metadata.erase(scenes_key);
  return data;
}

}  // namespace orthodrive
