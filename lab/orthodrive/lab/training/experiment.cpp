// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/lab/training/experiment.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <ranges>

#include "orthodrive/core/error.hpp"
#include "orthodrive/core/plain_name.hpp"
#include "orthodrive/pipeline/files/toml_section.hpp"

namespace orthodrive {
namespace {

void read_use(TomlSection& section, SceneUse& use) {
  section.read("weight", use.weight);
  section.read("min_zoom", use.min_zoom);
  section.read("max_zoom", use.max_zoom);
  section.read("from_step", use.from_step);
}

PaintRule read_rule(TomlSection& section) {
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

/// Previews are files of this name.
void read_name(TomlSection& section, std::string& name) {
  section.read("name", name);
  if (!is_plain_name(name))
    section.fail_here("'name' is used as the name of a file: no '/', no '.' in front, at most 200 characters");
}

MapData read_map_table(TomlSection& section) {
  MapData map;
  for (const char* key : {"name", "photo", "bbox_wgs84", "background"}) section.require(key);
  read_name(section, map.name);
  section.read("photo", map.photo);
  section.read_box("bbox_wgs84", [&](const Box2& box) { map.area_lonlat = box; });
  section.read_box("held_out_bbox_wgs84", [&](const Box2& box) { map.held_out_lonlat = box; });
  section.read("background", map.background);
  read_use(section, map.use);
  section.for_each_table("paint", [&](TomlSection& rule) { map.rules.push_back(read_rule(rule)); });
  return map;
}

ImageData read_images(TomlSection& section) {
  ImageData data;
  for (const char* key : {"name", "images", "labels", "palette"}) section.require(key);
  read_name(section, data.name);
  section.read("images", data.images);
  section.read("labels", data.labels);
  section.read("gsd_m", data.gsd_m);
  section.read("held_out", data.held_out);
  section.for_each_table("palette", [&](TomlSection& entry) {
    std::array<std::uint8_t, 3> color{};
    std::vector<std::string> classes;
    entry.read_color("color", color);
    entry.read("classes", classes);
    data.palette[color] = classes;
  });
  section.read("crf_only", data.crf_only);
  read_use(section, data.use);
  return data;
}

RasterData read_raster(TomlSection& section) {
  RasterData data;
  section.require("name");
  read_name(section, data.name);
  std::filesystem::path folder;
  section.read("folder", folder);
  if (!folder.empty()) data.photo = folder / "ortho.tif", data.labels = folder / "truth" / "labels.tif";
  section.read("photo", data.photo);
  section.read("labels", data.labels);
  if (data.photo.empty() || data.labels.empty())
    section.fail_here("needs 'folder' (written by orthodrive synth), or 'photo' and 'labels'");
  if (const toml::table* mapping = section.find_table("mapping")) {
    for (const auto& [key, node] : *mapping) {
      auto& classes = data.mapping[std::string(key.str())];
      if (!node.is_array())
        section.fail(node, fmt::format("'{}' must be a list of classes, [] to ignore it", key.str()));
      for (const toml::node& entry : *node.as_array()) classes.push_back(entry.value_or<std::string>(""));
    }
  }
  section.read("held_out", data.held_out);
  section.read("crf_only", data.use.crf_only);
  read_use(section, data.use);
  return data;
}

PolygonData read_polygon_data(TomlSection& section) {
  PolygonData data;
  for (const char* key : {"name", "photo", "polygons"}) section.require(key);
  read_name(section, data.name);
  section.read("photo", data.photo);
  section.read("polygons", data.polygons);
  section.read("pieces", data.pieces);
  section.read("held_out", data.held_out);
  section.read("osm", data.osm);
  section.read("crf_only", data.use.crf_only);
  read_use(section, data.use);
  return data;
}

StageOptions read_stage(TomlSection& section) {
  StageOptions stage;
  for (const char* key : {"stride", "steps"}) section.require(key);
  section.read("stride", stage.stride);
  section.read("steps", stage.steps);
  return stage;
}

void read_train(TomlSection& section, TrainOptions& train) {
  std::string preset, solver, turn;
  section.read("preset", preset);
  if (preset == "reference") train = reference_train_options();
  if (!preset.empty() && preset != "reference") section.fail_here("'preset' must be \"reference\"");
  section.read("solver", solver);
  if (!solver.empty() && solver != "adamw" && solver != "sgd")
    section.fail_here("'solver' must be \"adamw\" or \"sgd\"");
  if (!solver.empty()) train.solver = solver == "sgd" ? Solver::sgd : Solver::adamw;
  section.read("steps", train.steps);
  section.read("warmup_steps", train.warmup_steps);
  section.read("decay_from_step", train.decay_from_step);
  section.read("learning_rate", train.learning_rate);
  section.read("momentum", train.momentum);
  section.read("trunk_rate_factor", train.trunk_rate_factor);
  section.read("weight_decay", train.weight_decay);
  section.read("sum_loss", train.sum_loss);
  section.read("freeze_norm_from_step", train.freeze_norm_from_step);
  section.read("batch", train.batch);
  section.read("crop_px", train.crop_px);
  section.read("label_px", train.label_px);
  section.read("turn", turn);
  if (turn == "any") train.augmentation.turn = Augmentation::Turn::any;
  if (turn == "quarters") train.augmentation.turn = Augmentation::Turn::quarters;
  if (turn == "none") train.augmentation.turn = Augmentation::Turn::none;
  if (!turn.empty() && turn != "any" && turn != "quarters" && turn != "none")
    section.fail_here("'turn' must be \"any\", \"quarters\" or \"none\"");
  section.read("mirror", train.augmentation.mirror);
  section.read("zoom", train.augmentation.zoom);
  section.read("colors", train.augmentation.colors);
  section.read("blur", train.augmentation.blur);
  section.read("noise", train.augmentation.noise);
  section.read("domain", train.augmentation.domain);
  section.read("average_from_step", train.average_from_step);
  section.read("class_weights", train.class_weights);
  section.read("balance_classes", train.balance_classes);
  section.read("set_weight", train.set_weight);
  section.read("jaccard_weight", train.jaccard_weight);
  section.read("map_only", train.map_only);
  section.read("seed", train.seed);
  section.read("validate_every", train.validate_every);
  section.read("early_stop_after", train.early_stop_after);
  if (train.steps < 1 || train.batch < 1 || train.crop_px < 1)
    section.fail_here("'steps', 'batch' and 'crop_px' must be above 0");
  if (!(train.augmentation.domain >= 0.0 && train.augmentation.domain <= 1.0))
    section.fail_here("'domain' must be from 0 to 1");
}

void read_crf_options(TomlSection& section, CrfExperiment& crf) {
  section.read("steps", crf.steps);
  section.read("network_learning_rate", crf.network_learning_rate);
  section.read("learning_rate", crf.learning_rate);
  section.read("shrinkage", crf.shrinkage);
  section.read("unary_compatibility", crf.unary_compatibility);
  section.read("batch", crf.batch);
  section.read("label_px", crf.label_px);
  section.read("search_crops", crf.search_crops);
  section.read("iterations", crf.search.iterations);
  section.read("theta_alpha_px", crf.search.theta_alpha_px);
  section.read("theta_beta", crf.search.theta_beta);
  section.read("appearance_weight", crf.search.appearance_weight);
  section.read("theta_gamma_px", crf.search.theta_gamma_px);
  section.read("smoothness_weight", crf.search.smoothness_weight);
  section.read("fewer_iterations", crf.search.fewer_iterations);
  for (const auto* widths : {&crf.search.theta_alpha_px, &crf.search.theta_beta, &crf.search.theta_gamma_px})
    if (widths->empty() || std::ranges::any_of(*widths, [](double w) { return !(w >= 0.1 && w <= 1000.0); }))
      section.fail_here("the CRF's widths must be from 0.1 to 1000, one at least of each kind");
  for (const auto* weights : {&crf.search.appearance_weight, &crf.search.smoothness_weight})
    if (std::ranges::any_of(*weights, [](float w) { return !(w >= 0.0F && w <= 1000.0F); }))
      section.fail_here("the CRF's weights must be from 0 to 1000");
  section.read("validate_every", crf.validate_every);
}

}  // namespace

Experiment parse_experiment(std::string_view text, const std::filesystem::path& file) {
  const toml::table table = parse_toml(text, file);
  Experiment experiment;
  TomlSection root(table, file);
  for (const char* key : {"network", "train"}) root.require(key);
  root.read("network", experiment.network);
  root.read("data_from", experiment.data_from);
  root.read("leave_out", experiment.leave_out);
  std::vector<std::string> weights;
  root.read("weights", weights);
  for (const std::string& path : weights) experiment.weights.push_back(file.parent_path() / path);
  if (const toml::table* train = root.find_table("train")) {
    TomlSection section(*train, file);
    read_train(section, experiment.train);
    section.finish();
  }
  if (const toml::table* crf = root.find_table("crf")) {
    TomlSection section(*crf, file);
    read_crf_options(section, experiment.crf);
    section.finish();
  }
  root.for_each_table("stage", [&](TomlSection& section) { experiment.stages.push_back(read_stage(section)); });
  root.for_each_table("map", [&](TomlSection& section) { experiment.maps.push_back(read_map_table(section)); });
  root.for_each_table("images", [&](TomlSection& section) { experiment.images.push_back(read_images(section)); });
  root.for_each_table("raster", [&](TomlSection& section) { experiment.rasters.push_back(read_raster(section)); });
  root.for_each_table("polygons",
                      [&](TomlSection& section) { experiment.polygons.push_back(read_polygon_data(section)); });
  root.finish();
  return experiment;
}

void add_data(Experiment& experiment, const Experiment& other) {
  const auto append = [](auto& to, const auto& from) { to.insert(to.end(), from.begin(), from.end()); };
  append(experiment.maps, other.maps);
  append(experiment.images, other.images);
  append(experiment.rasters, other.rasters);
  append(experiment.polygons, other.polygons);
}

void leave_out_data(Experiment& experiment, const std::string& source) {
  for (const std::string& name : experiment.leave_out) {
    std::size_t found = 0;
    const auto for_each = [&](auto& sets, const auto& leave) {
      for (auto& data : sets) {
        if (data.name != name) continue;
        ++found;
        leave(data);
      }
    };
    for_each(experiment.maps, [](MapData& data) { data.use.weight = 0.0; });
    for_each(experiment.images, [](ImageData& data) { data.held_out = {"*"}; });
    for_each(experiment.rasters, [](RasterData& data) { data.held_out = true; });
    for_each(experiment.polygons, [](PolygonData& data) { data.held_out = true; });
    if (found == 0) throw InputError(source, fmt::format("leave_out names '{}': there is no such data set", name));
  }
}

ClassSet class_set(const std::vector<std::string>& names, const ClassTable& table, const std::string& source) {
  ClassSet set = unknown_class;
  std::vector<std::string> missing;
  for (const std::string& name : names) {
    const auto found = std::ranges::find(table.classes, name, &ClassInfo::name);
    if (found == table.classes.end())
      missing.push_back(fmt::format("'{}'", name));
    else
      set = static_cast<ClassSet>(set | only(static_cast<int>(found - table.classes.begin())));
  }
  if (missing.empty()) return set;
  throw InputError(
      source, fmt::format("{} {} {} not in the table '{}', which has {}", missing.size() == 1 ? "class" : "classes",
                          fmt::join(missing, ", "), missing.size() == 1 ? "is" : "are", table.name,
                          fmt::join(table.classes | std::views::transform(&ClassInfo::name), ", ")));
}

}  // namespace orthodrive
