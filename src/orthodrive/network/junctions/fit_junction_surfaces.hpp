// SPDX-License-Identifier: Apache-2.0
#pragma once
// One surface for the whole paved area of each junction. docs/junctions.md tells the method.

#include <map>
#include <vector>

#include "orthodrive/core/finding.hpp"
#include "orthodrive/core/shared_loop.hpp"
#include "orthodrive/geo/polygon.hpp"
#include "roadquery/map/road_map.hpp"

namespace orthodrive::network {

struct JunctionSurfaceOptions {
  int threads = 0;                      ///< 0 = all cores; the result does not depend on it
  LoopExchange* exchange = nullptr;     ///< with other processes that build the same network; nor on it
  std::map<int, double> kerb_radius_m;  ///< by junction, where it was seen; else by class
  std::map<int, Polygon> paved;         ///< by junction, what is paved besides its roads; coordinates of the map
};

struct JunctionSurfaceSummary {
  int junctions = 0;  ///< with a surface
  double area_m2 = 0.0;
  /// Largest difference in height of connecting roads of a junction over one place, before.
  double max_disagreement_m = 0.0;
  /// Largest difference between a connecting road and the surface in its lanes, before and after its profile was fitted
  /// anew.
  double max_road_off_before_m = 0.0, max_road_off_after_m = 0.0;
  std::size_t grid_nodes = 0;
};

/// Sets the surface of every junction of the map (boundary, grid, arms) and fits the profiles of its connecting roads
/// to it. `straight`: ids of the connecting roads that go straight on, cut from a chain (ascending). Boundaries in
/// multiples of 1 mm, heights of 0.1 mm, as files hold them.
JunctionSurfaceSummary add_junction_surfaces(roadquery::RoadMap& map, const std::vector<int>& straight,
                                             const JunctionSurfaceOptions& options = {});

}  // namespace orthodrive::network
