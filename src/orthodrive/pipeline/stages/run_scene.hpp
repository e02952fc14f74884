// SPDX-License-Identifier: Apache-2.0
#pragma once
// Stage "scene": roads, and if there are any photo, labels and terrain -> textured 3D Tiles.

#include "orthodrive/io/tiles/scene_io.hpp"
#include "orthodrive/pipeline/stages/build_stage.hpp"
#include "orthodrive/scene/build_scene.hpp"

namespace orthodrive {

struct SceneFiles {
  std::filesystem::path network;
  std::vector<std::filesystem::path> photos;        ///< best first; none: the ground is drawn
  std::filesystem::path labels;                     ///< may be empty: tiles then carry no classes
  std::vector<std::filesystem::path> dtm;           ///< best first; none: the ground follows the roads
  std::vector<std::filesystem::path> buildings;     ///< maps with building=*; may be empty
  std::vector<std::filesystem::path> trees;         ///< maps with natural=tree and tree_row; may be empty
  std::vector<std::filesystem::path> surroundings;  ///< maps with barrier=*, water, railways and lamps; may be empty
  /// Each as choose_roads() takes it: roads that are cut into the ground; the others stay as the photo shows them.
  /// None: all roads.
  std::vector<std::string> chosen_roads;
  double bare_width_m = 7.0;           ///< of roads that are a reference line alone
  std::filesystem::path folder;        ///< written: tileset.json and *.glb; replaced when all is done
  std::filesystem::path terrain_grid;  ///< written unless empty: the terrain for simulators, holes filled
  std::filesystem::path picture;       ///< written unless empty: PNG of the tile with most road triangles
};

struct RunSceneOptions {
  /// None: what the photos show, or without photos what lies around the roads; in the CRS of the roads.
  std::optional<SiteFrame> site;
  double margin_m = 200.0;  ///< around the roads, where there is no photo
  SceneOptions scene;
  io::TileFileOptions files;
};

StageOutcome run_scene(const SceneFiles& files, const RunSceneOptions& options, StageContext& context);

/// Makes cells for the process that runs run_scene() with the same files and options, through the context's exchange.
/// Their tiles lie in the folders of the cells.
void help_scene(const SceneFiles& files, const RunSceneOptions& options, StageContext& context);

struct ExportOptions {
  std::filesystem::path glb;   ///< written
  std::optional<Box2> bounds;  ///< site CRS; none: the whole area
  SceneOptions scene;
};
/// The scene of an area in one file with all in it. Of the files folder, terrain_grid and picture are not used.
StageOutcome run_export(const SceneFiles& files, const ExportOptions& options, StageContext& context);

[[nodiscard]] BuildStage scene_stage(SiteBuild& build);

}  // namespace orthodrive
