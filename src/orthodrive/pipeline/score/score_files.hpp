// SPDX-License-Identifier: Apache-2.0
#pragma once
// What `evaluate` reads, in the many forms it accepts.

#include <filesystem>
#include <variant>

#include "orthodrive/evaluate/labels/evaluate_labels.hpp"
#include "orthodrive/evaluate/labels/scores.hpp"
#include "orthodrive/evaluate/roads/evaluate_roads.hpp"
#include "orthodrive/model/rasters/rasters.hpp"

namespace orthodrive {

/// Polygons in any CRS; empty paths: everywhere, nothing ignored.
struct RegionFiles {
  std::filesystem::path area, ignore;
};
[[nodiscard]] ScoreRegion read_region(const RegionFiles& files, const Crs& crs);

/// PATH itself, or PATH/name when PATH is a truth folder.
[[nodiscard]] std::filesystem::path inside_folder(const std::filesystem::path& path, const char* name);
/// By its extension: GeoJSON, GeoPackage, OSM, Shapefile.
[[nodiscard]] bool is_vector_file(const std::filesystem::path& path);

/// The true label of every pixel, and the pieces that are scored on their own as well (none for a raster).
struct LabelTruth {
  LabelMap map;
  TruthPieces pieces;
};
/// A label raster (class table of `prediction` when it has none), or polygons with the property `class` painted on the
/// prediction's grid, or road polygons that know no classes. Later features cover earlier ones; the class "unknown"
/// takes pixels out of the score again. The property `piece` names the piece that a polygon belongs to.
[[nodiscard]] std::variant<LabelTruth, MultiPolygon> read_label_truth(const std::filesystem::path& path,
                                                                      const LabelMap& prediction);

/// A TOML file of lines `old = "new"`: names of classes and of those that take them in.
[[nodiscard]] MergeTable read_merge_table(const std::filesystem::path& path);

/// A folder as `synth` writes it, a roads.gpkg, or polygons (id) and centre lines (of) in any CRS.
[[nodiscard]] RoadTruth read_road_truth(const std::filesystem::path& path, const Crs& crs);
/// roads.gpkg, or an OSM file as it is, with default widths, in the box around the truth.
[[nodiscard]] RoadNetwork read_scored_roads(const std::filesystem::path& path, const std::filesystem::path& truth);

}  // namespace orthodrive
