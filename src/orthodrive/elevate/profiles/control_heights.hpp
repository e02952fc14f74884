// SPDX-License-Identifier: Apache-2.0
#pragma once
// Height control points on the roads that they are of.

#include <vector>

#include "orthodrive/core/finding.hpp"
#include "orthodrive/elevate/terrain/grade_separations.hpp"
#include "orthodrive/model/roads/height_control.hpp"
#include "orthodrive/model/roads/road_network.hpp"

namespace orthodrive::elevate {

/// A place between two nodes of a way.
struct RoadPlace {
  std::size_t path = 0, segment = 0;
  double fraction = 0.0;
};

struct HeightObservation {
  RoadPlace at;
  double z_m = 0.0, sigma_m = 0.0;
};
/// Height of the upper road over the lower one where they cross.
struct RiseObservation {
  RoadPlace upper, lower;
  double rise_m = 0.0, sigma_m = 0.0;
};
struct ControlHeights {
  std::vector<HeightObservation> heights;
  std::vector<RiseObservation> rises;
};

/// A height is that of the nearest road of which the point lies within the half width and 2 m, a clearance that of the
/// nearest crossing on two levels within 20 m; `osm_id` and `layer` restrict which. Left out are points that belong to
/// none ("elevate.control_point_off_road", "elevate.control_point_no_crossing") and those that roads of several levels
/// could mean ("elevate.control_point_ambiguous"). Marks the levels whose clearance is measured.
[[nodiscard]] ControlHeights match_control_points(const RoadNetwork& roads,
                                                  const std::vector<HeightControlPoint>& points,
                                                  std::vector<GradeSeparation>& levels, Findings& findings);

/// Points that the terrain contradicts by more than 5 sigma ("elevate.control_point_off_terrain"), and points that the
/// roads of the result miss by more than 3 ("elevate.control_point_missed").
void report_control_points(const RoadNetwork& elevated, const ControlHeights& control, const TerrainSamples& terrain,
                           const std::vector<double>& terrain_sigma_m, Findings& findings);

}  // namespace orthodrive::elevate
