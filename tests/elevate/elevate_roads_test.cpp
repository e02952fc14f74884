// SPDX-License-Identifier: Apache-2.0
// All of stage elevate at once: what heights, banking and drive logs must agree on.

#include "orthodrive/elevate/elevate_roads.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "elevate/drive_simulator.hpp"
#include "orthodrive/roads/path_junctions.hpp"

namespace orthodrive {
namespace {

constexpr double main_fall = 0.05, half_width_m = 4.0;

/// A tertiary road along +x that falls by 5 % to the north; a street that leaves it to the north and climbs by 6 %
/// from the road's edge on.
double ground(double x, double y) {
  const double t = y - 200.0;
  const double street = std::abs(x - 300.0) < 5.0 && t > half_width_m ? 0.06 * (t - half_width_m) : 0.0;
  return 40.0 + 0.03 * x - main_fall * std::clamp(t, -half_width_m, half_width_m) + street;
}
HeightGrid grid_of(double gsd_m) {
  const int n = static_cast<int>(600.0 / gsd_m);
  HeightGrid grid{drive_crs, {0.0, 600.0, gsd_m, n, n}, Raster<float>(n, n)};
  for (int row = 0; row < n; ++row)
    for (int col = 0; col < n; ++col) {
      const Vec2 p = grid.frame.center_of(col, row);
      grid.height_m.at(col, row) = static_cast<float>(ground(p.x, p.y));
    }
  return grid;
}
RoadNetwork tee() {
  const auto way = [](std::int64_t id, const char* highway, Vec2 a, Vec2 b) {
    RoadPath path{.osm_id = id, .highway = highway};
    const int steps = static_cast<int>(distance(a, b) / 2.0);
    for (int i = 0; i <= steps; ++i)
      path.nodes.push_back(
          {.p = a + (b - a) * (static_cast<double>(i) / steps), .s_m = 2.0 * i, .width_m = 2.0 * half_width_m});
    return path;
  };
  RoadNetwork roads{drive_crs,
                    {way(1, "tertiary", {50, 200}, {550, 200}), way(2, "residential", {300, 200}, {300, 400})}};
  roads.paths[0].nodes[125].osm_node = roads.paths[1].nodes[0].osm_node = 9;
  return roads;
}

TEST(ElevateRoads, roads_of_a_junction_lie_in_one_plane) {
  for (const double gsd_m : {1.0, 10.0}) {
    const auto paths = elevate_roads(tee(), {grid_of(gsd_m)}, {}).roads.paths;
    const RoadNode &main = paths[0].nodes[125], &street = paths[1].nodes[0];
    EXPECT_NEAR(main.z_m, street.z_m, 1e-6) << gsd_m;
    EXPECT_NEAR(street.gradient, std::tan(main.banking), 0.004) << gsd_m;   // north is the main road's left
    EXPECT_NEAR(std::tan(street.banking), -main.gradient, 0.004) << gsd_m;  // west is the street's left
    if (gsd_m > 2.0) continue;
    EXPECT_NEAR(std::tan(main.banking), -main_fall, 0.01)
        << "measured banking has the say, not the street behind the edge";
    EXPECT_EQ(paths[0].nodes[60].banking_source, BankingSource::dtm);
  }
}

TEST(ElevateRoads, drive_logs_come_last) {
  const TrueRoad road(600.0, 0.006, 3.0);
  RoadNetwork roads = road_from_terrain(road, 0.3);
  HeightGrid grid{drive_crs, {900.0, 2400.0, 10.0, 80, 80}, Raster<float>(80, 80)};
  for (int row = 0; row < 80; ++row)
    for (int col = 0; col < 80; ++col)
      grid.height_m.at(col, row) = static_cast<float>(road.z(grid.frame.center_of(col, row).x - 1000.0));
  const DriveLog log = log_of({simulate_drive(road, {.end_m = 595.0})});
  const auto without = elevate_roads(roads, {grid}, {}), with = elevate_roads(roads, {grid}, log);
  EXPECT_EQ(without.logged_m, 0.0);
  EXPECT_GT(with.logged_on_roads_m, 550.0);
  EXPECT_EQ(with.banking_measured_share, 0.0);
  const RoadNode &before = without.roads.paths[0].nodes[150], &after = with.roads.paths[0].nodes[150];
  EXPECT_EQ(before.banking_source, BankingSource::design);
  EXPECT_EQ(after.banking_source, BankingSource::log);
  EXPECT_LT(after.sigma_banking, 0.7 * before.sigma_banking);
  EXPECT_EQ(before.crown, after.crown);
}

}  // namespace
}  // namespace orthodrive
