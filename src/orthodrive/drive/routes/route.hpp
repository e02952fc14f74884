// SPDX-License-Identifier: Apache-2.0
#pragma once
// Which roads to drive: a closed loop through the road graph, with the lanes' directions respected.

#include <string>
#include <vector>

#include "orthodrive/core/finding.hpp"
#include "orthodrive/geo/vec.hpp"
#include "roadquery/map/road_map.hpp"

namespace orthodrive {

/// A road in one direction.
struct RouteStep {
  int road = -1;        ///< index into RoadMap::roads
  bool forward = true;  ///< in the direction of its s
  friend bool operator==(const RouteStep&, const RouteStep&) = default;
};

struct Route {
  std::vector<RouteStep> steps;
  bool closed = false;  ///< the last step leads into the first
  std::string name;     ///< for people: "Circuit", "Ringvägen, Storgatan"
  double length_m = 0.0;
};

struct RouteOptions {
  std::string route = "auto";  ///< "auto", or names / OSM ids of ways separated by commas
  std::vector<Vec2> via;       ///< site CRS; when given the route leads past these in order and back to the first
};

/// auto: the longest loop of raceways, else the best loop of 0.5 to 5 km, where best means long, on important roads and
/// without driving a road twice. Names: the loop with the largest share of these ways. Where there is no loop, an open
/// route along the same roads.
/// Throws OptionError for a name that no road has and for places that no road leads to; Error for a map without any
/// lane to drive on. Deterministic: ties go to the lower road id, forward first.
[[nodiscard]] Route find_route(const roadquery::RoadMap& map, const RouteOptions& options = {});

/// Whether every lane section has a driving lane for traffic in that direction.
[[nodiscard]] bool is_drivable(const roadquery::Road& road, bool forward);

}  // namespace orthodrive
