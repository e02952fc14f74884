// SPDX-License-Identifier: Apache-2.0
// Roads beside each other: heights of the strip that they share, where carriageways end, and lanes of short ways.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "network_support.hpp"
#include "orthodrive/network/build_network.hpp"

namespace orthodrive {
namespace {

using namespace network_test;

/// On the road of a way that lies there.
double height_at(const roadquery::RoadMap& map, const std::string& way, Vec2 p) {
  for (const roadquery::Road& road : map.roads) {
    if (road.osm_id != way || road.junction >= 0) continue;
    const roadquery::RoadPosition at =
        roadquery::position_over(road, p.x + site_origin.x, p.y + site_origin.y, 0.5 * road.length);
    if (at.s > 0.0 && at.s < road.length) return roadquery::surface_height(road, at.s, at.t);
  }
  return NAN;
}

TEST(LevelBeside, a_shared_strip_has_one_height_which_fades_out_behind_it) {
  // A service road of 4 m lies 4.5 m beside the axis of a main road of 12 m, too near to make room, and parts from it.
  const auto height = [](double z) { return [z](Vec2) { return z; }; };
  const PathOptions main{.highway = "secondary", .width_m = 12.0, .height = height(10.0)},
      side{.osm_id = 2,
           .highway = "service",
           .width_m = 4.0,
           .oneway = Oneway::forward,
           .height = height(10.3),
           .banking = [](double) { return 0.04; }};
  const roadquery::RoadMap map =
      build_network(network_of({make_path({{0, 0}, {500, 0}}, {1, 2}, main),
                                make_path({{100, 4.5}, {250, 4.5}, {330, 40}, {480, 40}}, {3, 4}, side)}))
          .map;
  for (const double x : {120.0, 150.0, 180.0, 210.0})
    for (const double y : {4.0, 4.8, 5.5})
      EXPECT_NEAR(height_at(map, "2", {x, y}), height_at(map, "1", {x, y}), 0.015) << x << " " << y;
  EXPECT_NEAR(height_at(map, "1", {150, 0}), 10.0, 1e-3) << "the greater road stays";
  EXPECT_NEAR(height_at(map, "2", {450, 40}), 10.3, 1e-3) << "far from it nothing changes";
  for (const roadquery::Road& road : map.roads)
    for (double s = 0.0; s <= road.length; s += 1.0)
      EXPECT_LT(std::abs(roadquery::gradient(road, s)), 0.04) << road.osm_id << " at " << s;
}

TEST(LevelBeside, roads_of_two_levels_stay) {
  const auto z_of_side = [](double z) {
    const PathOptions main{.highway = "secondary", .width_m = 12.0, .height = [](Vec2) { return 10.0; }},
        side{.osm_id = 2, .highway = "service", .width_m = 4.0, .oneway = Oneway::forward, .height = [z](Vec2) {
               return z;
             }};
    const roadquery::RoadMap map = build_network(network_of({make_path({{0, 0}, {300, 0}}, {1, 2}, main),
                                                             make_path({{100, 4.5}, {200, 4.5}}, {3, 4}, side)}))
                                       .map;
    return height_at(map, "2", {150, 4.5});
  };
  EXPECT_NEAR(z_of_side(10.8), 10.0, 0.02);
  EXPECT_NEAR(z_of_side(16.0), 16.0, 1e-3);
}

/// Where the roads of a way end, along x; the nearest to `x`.
double end_near(const roadquery::RoadMap& map, const std::string& way, double x) {
  double nearest = INFINITY;
  for (const roadquery::Road& road : map.roads)
    if (road.osm_id == way && road.junction < 0)
      for (const double s : {0.0, road.length})
        if (const double at = roadquery::reference_point(road, s).x - site_origin.x;
            std::abs(at - x) < std::abs(nearest - x))
          nearest = at;
  return nearest;
}

TEST(LevelBeside, carriageways_of_one_road_end_side_by_side) {
  // A street crosses both at 50 degrees: by itself each carriageway would end 5.9 m further along than the other.
  const double skew = 50.0 * M_PI / 180.0;
  const auto on_street = [&](double y) { return Vec2{y / std::tan(skew), y}; };
  const auto way = [](std::int64_t id) {
    return PathOptions{.osm_id = id, .highway = "primary", .oneway = Oneway::forward};
  };
  const Vec2 low = on_street(-3.5), high = on_street(3.5);
  const roadquery::RoadMap map =
      build_network(
          network_of({make_path({{-150, -3.5}, low}, {1, 2}, way(1)), make_path({low, {150, -3.5}}, {2, 3}, way(2)),
                      make_path({{150, 3.5}, high}, {4, 5}, way(3)), make_path({high, {-150, 3.5}}, {5, 6}, way(4)),
                      make_path({on_street(-90), low, high, on_street(90)}, {7, 2, 5, 8}, {.osm_id = 5})}))
          .map;
  EXPECT_EQ(map.junctions.size(), 1U);
  EXPECT_NEAR(end_near(map, "1", -10.0), end_near(map, "4", -10.0), 0.6);
  EXPECT_NEAR(end_near(map, "2", 10.0), end_near(map, "3", 10.0), 0.6);
  EXPECT_LT(end_near(map, "1", 0.0), -8.0);
  EXPECT_GT(end_near(map, "2", 0.0), 8.0);
}

TEST(LevelBeside, lanes_do_not_begin_or_end_within_a_few_metres) {
  const auto ways = [](double short_m) {
    const PathOptions wide{.osm_id = 2, .highway = "tertiary", .width_m = 13.0, .lanes = 4},
        narrow{.osm_id = 3, .highway = "tertiary", .width_m = 6.5, .lanes = 2};
    const NetworkResult result = build_network(network_of(
        {make_path({{-150, 0}, {0, 0}}, {1, 2}, {.highway = "tertiary", .width_m = 6.5, .lanes = 2}),
         make_path({{0, 0}, {short_m, 0}}, {2, 3}, wide), make_path({{short_m, 0}, {150, 0}}, {3, 4}, narrow),
         make_path({{0, -90}, {0, 0}, {0, 90}}, {5, 2, 6}, {.osm_id = 4})}));
    return std::ranges::count_if(result.map.roads, [](const roadquery::Road& road) { return road.osm_id == "2"; });
  };
  EXPECT_EQ(ways(11.0), 0) << "3 m are left between the junction and the narrow way";
  EXPECT_EQ(ways(40.0), 1);
}

}  // namespace
}  // namespace orthodrive
