// SPDX-License-Identifier: Apache-2.0
#pragma once
// The experiment file of `orthodrive train`: what to train on and how (TOML, described in docs/train.md).

#include <array>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "orthodrive/geo/vec.hpp"
#include "orthodrive/model/rasters/class_table.hpp"
#include "orthodrive/train/search_crf.hpp"
#include "orthodrive/train/train_options.hpp"

namespace orthodrive {

/// A coat of paint from a vector file.
struct PaintRule {
  std::filesystem::path file;
  std::map<std::string, std::vector<std::string>> where;  ///< tag -> values that count; empty: every feature
  std::vector<std::string> highways;  ///< not empty: `file` is OSM, its roads of these kinds with their widths
  std::vector<std::string> classes;   ///< what may be there; empty: unknown
  std::vector<std::string> merge_over;
  double line_width_m = 0.0;  ///< of lines and points
  double unknown_inside_m = 0.0, unknown_outside_m = 0.0;
};

/// How the scenes of one data set enter the training.
struct SceneUse {
  double weight = 1.0, min_zoom = 0.8, max_zoom = 1.25;
  std::int64_t from_step = 0;
  /// The network does not learn from it, so that it is no better there than elsewhere; the CRF learns from nothing else
  /// when there is any such data.
  bool crf_only = false;
};

/// Photo with labels painted from maps.
struct MapData {
  std::string name;
  std::filesystem::path photo;
  Box2 area_lonlat;
  std::vector<std::string> background;  ///< classes of what no rule paints
  std::vector<PaintRule> rules;
  std::optional<Box2> held_out_lonlat;  ///< labelled by the same rules, measured, not trained on; outside area_lonlat
  SceneUse use;
};

/// Images with label images beside them (same stem), colours name the classes.
struct ImageData {
  std::string name;
  std::filesystem::path images, labels;
  double gsd_m = 0.5;
  /// Colour of the labels -> classes of ours: one, one of several, or none (ignored). Any other colour is an error.
  std::map<std::array<std::uint8_t, 3>, std::vector<std::string>> palette;
  std::vector<std::string> held_out;  ///< stems that begin so are for validation; "*" is all of them
  std::vector<std::string> crf_only;  ///< likewise for the CRF (SceneUse)
  SceneUse use;
};

/// A photo and a label map with its own class table: a folder written by `orthodrive synth`, or two files.
struct RasterData {
  std::string name;
  std::filesystem::path photo, labels;
  std::map<std::string, std::vector<std::string>> mapping;  ///< their class -> ours; not named: the class of that name
  bool held_out = false;                                    ///< measured, not trained on
  SceneUse use;
};

/// Photo with polygons painted by hand: GeoJSON features with `piece` and `class`, later ones on top, "unknown" where
/// nothing is known. Outside them nothing is learned and nothing scored.
struct PolygonData {
  std::string name;
  std::filesystem::path photo, polygons;
  std::vector<std::string> pieces;  ///< only features whose `piece` is one of these; none given: all
  bool held_out = false;            ///< measured, not trained on
  std::filesystem::path osm;        ///< the map beside the photo; none: drawn from the labels
  SceneUse use;
};

/// One of several trainings that follow each other, each starting from the network before: 32s, 16s, 8s. Where there is
/// held-out data, from its best snapshot.
struct StageOptions {
  int stride = 0;
  std::int64_t steps = 0;
};

/// `train --crf`: a search on a grid, then learning end to end. Replaces what it names of [train].
struct CrfExperiment {
  std::int64_t steps = 150;
  double network_learning_rate = 2e-5;
  double learning_rate = 0.02, shrinkage = 0.05;  ///< of the CRF (CrfTraining)
  bool unary_compatibility = false;               ///< learned, too
  int batch = 2, label_px = 0;
  int search_crops = 16;
  CrfSearchOptions search;  ///< its grid
  std::int64_t validate_every = 50;
};

struct Experiment {
  std::filesystem::path network;               ///< its description (network_spec.hpp)
  std::vector<std::filesystem::path> weights;  ///< to start from: safetensors or .caffemodel, asked in this order
  TrainOptions train;
  CrfExperiment crf;
  std::filesystem::path data_from;     ///< an experiment whose data sets are used as well
  std::vector<std::string> leave_out;  ///< data sets that are measured as a whole and not trained on
  std::vector<StageOptions> stages;    ///< none: the network as it is, train.steps long
  std::vector<MapData> maps;
  std::vector<ImageData> images;
  std::vector<RasterData> rasters;
  std::vector<PolygonData> polygons;
};

/// Paths in the file are relative to it. Throws InputError with the line for what is wrong or unknown.
[[nodiscard]] Experiment parse_experiment(std::string_view text, const std::filesystem::path& file);

/// Another experiment's data sets come to its own.
void add_data(Experiment& experiment, const Experiment& other);

/// Makes all of the data sets named by `leave_out` held out (leave one region out). A [[map]] has labels too coarse for
/// that: of it only what is held out anyway is measured. Throws InputError, naming `source`, where there is no such
/// set.
void leave_out_data(Experiment& experiment, const std::string& source);

/// Bits of the named classes. Throws InputError naming `source` and all unknown names.
[[nodiscard]] ClassSet class_set(const std::vector<std::string>& names, const ClassTable& table,
                                 const std::string& source);

}  // namespace orthodrive
