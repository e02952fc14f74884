// SPDX-License-Identifier: Apache-2.0
#pragma once
// Straight roads with a node every 2 m, for tests of kernels.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>

#include "orthodrive/model/rasters/rasters.hpp"
#include "orthodrive/model/roads/road_network.hpp"

namespace orthodrive::test {

inline const Crs road_crs{"EPSG:32633"};

inline RoadPath straight_road(std::int64_t osm_id, Vec2 a, Vec2 b, std::int64_t node_a = 0, std::int64_t node_b = 0) {
  RoadPath path{.osm_id = osm_id, .highway = "residential"};
  const int steps = std::max(1, static_cast<int>(std::lround(distance(a, b) / 2.0)));
  for (int i = 0; i <= steps; ++i) {
    const double f = static_cast<double>(i) / steps;
    path.nodes.push_back({.p = a + (b - a) * f, .s_m = f * distance(a, b), .width_m = 6.0});
  }
  path.nodes.front().osm_node = node_a, path.nodes.back().osm_node = node_b;
  return path;
}

/// The terrain at pixel centres, around (-50, -50) .. (size - 50, size - 50).
inline HeightGrid terrain_grid(const std::function<double(double x, double y)>& z, double gsd_m,
                               double size_m = 400.0) {
  const int n = static_cast<int>(size_m / gsd_m);
  HeightGrid grid{road_crs, {-50.0, size_m - 50.0, gsd_m, n, n}, Raster<float>(n, n)};
  for (int row = 0; row < n; ++row)
    for (int col = 0; col < n; ++col) {
      const Vec2 p = grid.frame.center_of(col, row);
      grid.height_m.at(col, row) = static_cast<float>(z(p.x, p.y));
    }
  return grid;
}

}  // namespace orthodrive::test
