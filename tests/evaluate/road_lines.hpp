// SPDX-License-Identifier: Apache-2.0
#pragma once
// Roads along given lines, for the tests of this folder. Lines are in metres from `origin`.

#include "orthodrive/model/roads/road_network.hpp"

namespace orthodrive {

const Crs utm33{"EPSG:32633"};
const Vec2 origin{500000.0, 5540000.0};

inline RoadPath path_along(const Polyline& line, double width_m, std::int64_t id = 1) {
  RoadPath path{.osm_id = id, .highway = "residential"};
  const std::vector<double> s = arc_lengths_m(line);
  for (std::size_t i = 0; i < line.size(); ++i)
    path.nodes.push_back({.p = origin + line[i], .s_m = s[i], .width_m = width_m});
  return path;
}
inline Polyline straight(double x0, double y0, double x1, double y1, int pieces = 20) {
  Polyline line;
  for (int i = 0; i <= pieces; ++i) line.push_back({x0 + (x1 - x0) * i / pieces, y0 + (y1 - y0) * i / pieces});
  return line;
}

}  // namespace orthodrive
