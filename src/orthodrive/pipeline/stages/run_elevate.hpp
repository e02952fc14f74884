// SPDX-License-Identifier: Apache-2.0
#pragma once
// Stage "elevate": roads, terrain models, height control points and drive logs -> roads with heights, banking and
// roughness.

#include "orthodrive/elevate/elevate_roads.hpp"
#include "orthodrive/pipeline/stages/build_stage.hpp"

namespace orthodrive {

struct ElevateFiles {
  std::filesystem::path roads;                        ///< of refine
  std::vector<std::filesystem::path> dtm;             ///< best first
  std::vector<std::filesystem::path> drive_logs;      ///< may be empty
  std::vector<std::filesystem::path> control_points;  ///< may be empty
  std::filesystem::path elevated;                     ///< written; may be `roads`
  std::filesystem::path findings;                     ///< written unless empty
  std::vector<std::filesystem::path> osm;             ///< the map that the roads were before; for road_graph
  std::filesystem::path road_graph;  ///< written unless empty (io/vector/road_graph_io.hpp); wants osm and a site
};

struct RunElevateOptions {
  std::optional<SiteFrame> site;            ///< none: the hull of the roads
  std::optional<DrivingSide> driving_side;  ///< none: that of the country in which the site lies
  ElevateRoadsOptions elevate;              ///< its driving side is set here
};

StageOutcome run_elevate(const ElevateFiles& files, const RunElevateOptions& options, StageContext& context);

[[nodiscard]] BuildStage elevate_stage(SiteBuild& build);

}  // namespace orthodrive
