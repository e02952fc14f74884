// SPDX-License-Identifier: Apache-2.0
// Gores between a main road and a slip road drawn by hand.

#include "orthodrive/network/paint/gores.hpp"

#include <gtest/gtest.h>

#include "network_support.hpp"
#include "roadquery/query/road_query.hpp"

namespace orthodrive {
namespace {

using namespace orthodrive::network_test;
using network::gore_mark;
using roadquery::Road;
using roadquery::RoadObject;

struct Slip {
  bool merges = false;      ///< else it leaves
  double angle_rad = 0.09;  ///< 5 degrees
  std::string main = "motorway", slip = "motorway_link";
};

/// A main road of 12 m along x; at x = 0 a slip road of 6 m leaves to the right, or comes from there.
RoadNetwork fork(const Slip& of) {
  const PathOptions main{.osm_id = 1, .highway = of.main, .width_m = 12.0, .oneway = Oneway::forward};
  PathOptions after = main, slip = main;
  after.osm_id = 2, slip.osm_id = 3, slip.highway = of.slip, slip.width_m = 6.0;
  const double sign = of.merges ? -1.0 : 1.0;
  const Vec2 end{sign * 400.0, -400.0 * std::tan(of.angle_rad)};
  std::vector<RoadPath> paths = {make_path({{-400, 0}, {0, 0}}, {1, 9}, main),
                                 make_path({{0, 0}, {400, 0}}, {9, 2}, after)};
  paths.push_back(of.merges ? make_path({end, {0, 0}}, {3, 9}, slip) : make_path({{0, 0}, end}, {9, 3}, slip));
  return network_of(std::move(paths));
}

struct Gore {
  const Road* road = nullptr;
  const RoadObject* mark = nullptr;
};
std::vector<Gore> gores_of(const roadquery::RoadMap& map) {
  std::vector<Gore> gores;
  for (const Road& road : map.roads)
    for (const RoadObject& object : road.objects)
      if (object.name == gore_mark) gores.push_back({&road, &object});
  return gores;
}

TEST(Gores, lie_between_the_edges_that_part) {
  for (const bool merges : {false, true}) {
    const roadquery::RoadMap map = build_network(fork({.merges = merges})).map;
    const auto gores = gores_of(map);
    ASSERT_EQ(gores.size(), 1u) << merges;
    const auto& [road, mark] = gores[0];
    EXPECT_EQ(road->osm_id, "3");
    EXPECT_EQ(mark->subtype, "hatchedArea");
    EXPECT_GT(mark->length, 20.0);
    EXPECT_LE(mark->length, network::longest_gore_m);
    ASSERT_EQ(mark->outline.size() % 2, 0u);
    double widest = 0.0;
    for (std::size_t i = 0; i < mark->outline.size(); ++i) {
      const auto p = roadquery::surface_point(*road, mark->outline[i][0], mark->outline[i][1]);
      const double x = (p.x - site_origin.x) * (merges ? -1.0 : 1.0), y = p.y - site_origin.y;
      if (i <
          mark->outline.size() / 2) {  // 3 m beside the slip road's line, less where it leaves room to the main road
        EXPECT_LT(std::cos(0.09) * y + std::sin(0.09) * x, 3.1) << x;
        EXPECT_GT(std::cos(0.09) * y + std::sin(0.09) * x, x < 135.0 ? 1.0 : 2.8) << x;
        EXPECT_LT(y, -6.2);
        widest = std::max(widest, -6.0 - y);
      } else {
        EXPECT_NEAR(y, -6.0, 0.1) << "along the main road's edge";
      }
    }
    EXPECT_NEAR(widest, network::widest_gore_m, 0.2);
  }
}

TEST(Gores, are_paved_and_even) {
  const roadquery::RoadMap map = build_network(fork({})).map;
  const auto gores = gores_of(map);
  ASSERT_EQ(gores.size(), 1u);
  const auto& [road, mark] = gores[0];
  const roadquery::RoadQuery query(map);
  roadquery::Cursor cursor;
  const std::size_t n = mark->outline.size();
  int asked = 0;
  for (std::size_t i = 0; i < n / 2; ++i)
    for (const double share : {0.0, 0.3, 0.7, 1.0}) {
      const double t = mark->outline[i][1] + share * (mark->outline[n - 1 - i][1] - mark->outline[i][1]);
      const auto p = roadquery::surface_point(*road, mark->outline[i][0], t);
      const auto hit = query.find(p.x, p.y, 0.0, cursor);
      ASSERT_TRUE(hit) << "no road at " << p.x - site_origin.x << ' ' << p.y - site_origin.y;
      EXPECT_NEAR(hit->z, 0.0, 0.01);
      ++asked;
    }
  EXPECT_GT(asked, 20);
}

TEST(Gores, leave_a_bank_where_the_slip_road_falls_away) {
  RoadNetwork falling = fork({});
  for (RoadPath& path : falling.paths)
    for (RoadNode& node : path.nodes) {
      const double x = node.p.x - site_origin.x;
      node.z_m = path.osm_id == 3 ? -0.004 * std::max(0.0, x - 60.0) : 0.0;
    }
  const roadquery::RoadMap map = build_network(falling).map;
  // Where the slip road is lower than the main road by more than 3 cm it ends before the main road's edge.
  int lower = 0, with_gore = 0;
  for (const Road& road : map.roads) {
    if (road.osm_id != "3" || road.junction >= 0) continue;
    for (double s = 0.0; s < std::min(road.length, 60.0); s += 0.5) {
      const auto edge = roadquery::surface_point(road, s, roadquery::road_edges(road, s).left_t);
      with_gore += roadquery::road_edges(road, s).left_t > 3.5 ? 1 : 0;
      if (edge.z > -0.03) continue;
      EXPECT_LT(edge.y - site_origin.y, -6.0) << s;
      ++lower;
    }
  }
  EXPECT_GT(lower, 20);
  EXPECT_GT(with_gore, 5);
}

TEST(Gores, none_at_wide_forks_on_small_roads_on_bridges_and_beside_two_way_roads) {
  EXPECT_TRUE(gores_of(build_network(fork({.angle_rad = 0.7})).map).empty());
  EXPECT_TRUE(gores_of(build_network(fork({.main = "residential", .slip = "residential"})).map).empty());
  RoadNetwork bridge = fork({});
  bridge.paths[2].bridge = true;
  EXPECT_TRUE(gores_of(build_network(bridge).map).empty());
  RoadNetwork two_way = fork({});
  two_way.paths[2].oneway = Oneway::no;
  EXPECT_TRUE(gores_of(build_network(two_way).map).empty());
}

TEST(Gores, both_roads_have_a_lane_where_nobody_drives) {
  const roadquery::RoadMap map = build_network(fork({})).map;
  int lanes = 0;
  for (const Road& road : map.roads)
    for (const auto* side : {&road.sections[0].left, &road.sections[0].right})
      for (const roadquery::Lane& lane : *side) lanes += lane.type == roadquery::LaneType::other ? 1 : 0;
  EXPECT_EQ(lanes, 2);
}

}  // namespace
}  // namespace orthodrive
