// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/network/paint/raise_sidewalks.hpp"

#include <gtest/gtest.h>

#include "network_support.hpp"
#include "roadquery/query/road_query.hpp"

namespace orthodrive {
namespace {

using namespace orthodrive::network_test;
using network::kerb_m;
using network::lowered_kerb_m;
using roadquery::Lane;
using roadquery::LaneType;
using roadquery::Road;

/// Height of the walk on a side over the road's surface, nothing where there is no walk.
std::optional<double> walk_height(const Road& road, bool left, double s) {
  for (const Lane& lane : left ? road.sections[0].left : road.sections[0].right)
    if (lane.type == LaneType::sidewalk) return roadquery::lane_height_at(lane.heights, s).value[0];
  return std::nullopt;
}

const Road& road_with_sidewalk(const roadquery::RoadMap& map, const std::string& osm_id) {
  for (const Road& road : map.roads)
    if (road.junction < 0 && road.osm_id == osm_id) return road;
  throw std::runtime_error("no road of way " + osm_id);
}

TEST(RaiseSidewalks, kerbs_fade_out_before_junctions_and_are_low_at_crosswalks) {
  RoadPath west = make_path({{-100, 0}, {-50, 0}, {0, 0}}, {1, 7, 9}, {.osm_id = 1, .width_m = 7.0});
  west.sidewalk = Sides::right;
  RoadNetwork roads = network_of({west, make_path({{0, 0}, {100, 0}}, {9, 2}, {.osm_id = 2}),
                                  make_path({{0, 0}, {0, 100}}, {9, 3}, {.osm_id = 3})});
  roads.signs = {{7, NodeSignKind::zebra, 0}};
  const roadquery::RoadMap map = build_network(roads).map;
  const Road& road = road_with_sidewalk(map, "1");
  EXPECT_FALSE(walk_height(road, true, 20.0));
  EXPECT_EQ(walk_height(road, false, 0.0), 0.0);
  EXPECT_NEAR(walk_height(road, false, 0.5).value_or(-1.0), 0.5 * kerb_m, 1e-9);
  EXPECT_EQ(walk_height(road, false, 20.0), kerb_m);
  EXPECT_NEAR(walk_height(road, false, 50.0).value_or(-1.0), lowered_kerb_m, 1e-9);
  EXPECT_NEAR(walk_height(road, false, 48.1).value_or(-1.0), lowered_kerb_m, 1e-9);
  EXPECT_NEAR(walk_height(road, false, 47.0).value_or(-1.0), kerb_m, 1e-9);
  EXPECT_NEAR(walk_height(road, false, road.length - 1.0).value_or(-1.0), kerb_m, 1e-3);
  EXPECT_EQ(walk_height(road, false, road.length), 0.0);
}

TEST(RaiseSidewalks, joints_of_roads_have_one_height) {
  RoadPath a = make_path({{-60, 0}, {0, 0}}, {1, 9}, {.osm_id = 1}),
           b = make_path({{60, 0}, {0, 0}}, {2, 9}, {.osm_id = 2});
  a.sidewalk = Sides::left, b.sidewalk = Sides::both;  // b runs the other way: its right is a's left
  RoadNetwork roads = network_of({a, b});
  roadquery::RoadMap map = build_network(roads).map;
  EXPECT_EQ(walk_height(road_with_sidewalk(map, "1"), true, 60.0), kerb_m) << "the walk goes on";
  EXPECT_EQ(walk_height(road_with_sidewalk(map, "2"), false, 60.0), kerb_m);
  EXPECT_EQ(walk_height(road_with_sidewalk(map, "2"), true, 60.0), 0.0) << "no walk beyond";
  // A crosswalk on the joint's far side: as low on both.
  roads.paths[1] = make_path({{60, 0}, {2, 0}, {0, 0}}, {2, 7, 9}, {.osm_id = 2});
  roads.paths[1].sidewalk = Sides::both;
  roads.signs = {{7, NodeSignKind::zebra, 0}};
  map = build_network(roads).map;
  EXPECT_NEAR(walk_height(road_with_sidewalk(map, "1"), true, 60.0).value_or(-1.0),
              walk_height(road_with_sidewalk(map, "2"), false, 60.0).value_or(-1.0), 1e-3);
  EXPECT_NEAR(walk_height(road_with_sidewalk(map, "1"), true, 60.0).value_or(-1.0), lowered_kerb_m, 1e-3);
}

TEST(RaiseSidewalks, what_cars_drive_on_is_the_same_with_and_without_them) {
  // A road forks off another one and falls beside it: sidewalks of full width would lie on the other's lanes, up to
  // half a metre off.
  const auto map_of = [](Sides sidewalk) {
    RoadPath a = make_path({{-80, 0}, {0, 0}, {120, 0}}, {1, 9, 2}, {.osm_id = 1, .width_m = 7.0});
    RoadPath b = make_path({{0, 0}, {60, 11}, {120, 7.6}}, {9, 0, 3}, {.osm_id = 2, .width_m = 6.0});
    for (RoadNode& node : a.nodes) node.z_m = 10.0;
    for (RoadNode& node : b.nodes) node.z_m = 10.0 - 0.01 * node.s_m;
    a.sidewalk = b.sidewalk = sidewalk;
    return build_network(network_of({a, b})).map;
  };
  const roadquery::RoadMap with = map_of(Sides::both), without = map_of(Sides::none);
  const roadquery::RoadQuery one(with), two(without);
  int asked = 0;
  double narrowest = 2.0, widest = 0.0;
  for (const Road& road : without.roads) {
    if (road.junction >= 0) continue;
    for (double s = 0.05; s < road.length; s += 0.5) {
      const roadquery::Edges edges = roadquery::road_edges(road, s);
      for (double t = edges.right_t + 0.05; t < edges.left_t; t += 0.3, ++asked) {
        const auto p = roadquery::surface_point(road, s, t);
        roadquery::Cursor c, d;
        const auto hit = one.find(p.x, p.y, p.z, c), flat = two.find(p.x, p.y, p.z, d);
        ASSERT_TRUE(hit && flat);
        EXPECT_NEAR(hit->z, flat->z, 1e-6) << road.osm_id << ' ' << s << ' ' << t;
      }
    }
  }
  for (const Road& road : with.roads)
    for (const auto* side : {&road.sections[0].left, &road.sections[0].right})
      for (const Lane& lane : *side)
        for (double s = 0.0; s < road.length && lane.type == LaneType::sidewalk; s += 1.0) {
          const double width = roadquery::lane_width(lane, s);
          narrowest = std::min(narrowest, width), widest = std::max(widest, width);
        }
  EXPECT_GT(asked, 1000);
  EXPECT_LT(narrowest, 0.6) << "beside the fork";
  EXPECT_GE(narrowest, 0.0);
  EXPECT_EQ(widest, 2.0);
}

TEST(RaiseSidewalks, nothing_steps_on_driving_lanes) {
  // Two roads with walks, whose lanes and walks overlap for some way, and a junction of both.
  RoadPath a = make_path({{-80, 0}, {0, 0}, {80, 0}}, {1, 9, 2}, {.osm_id = 1, .width_m = 7.0});
  RoadPath b = make_path({{0, 0}, {30, 20}, {80, 9}}, {9, 0, 3}, {.osm_id = 2, .width_m = 6.0});
  a.sidewalk = b.sidewalk = Sides::both;
  const roadquery::RoadMap with = build_network(network_of({a, b})).map;
  roadquery::RoadMap without = with;
  int raised = 0;
  for (Road& road : without.roads)
    for (auto* side : {&road.sections[0].left, &road.sections[0].right})
      for (Lane& lane : *side) raised += static_cast<int>(lane.heights.size() > 2), lane.heights.clear();
  EXPECT_GE(raised, 4);
  const roadquery::RoadQuery one(with), two(without);
  int walked = 0;
  for (const Road& road : with.roads) {
    for (double s = 0.05; s < road.length; s += 0.4) {
      const roadquery::Edges edges = roadquery::road_edges(road, s);
      for (double t = edges.right_t + 0.05; t < edges.left_t; t += 0.23) {
        const auto p = roadquery::surface_point(road, s, t);
        roadquery::Cursor c, d;
        const auto hit = one.find(p.x, p.y, p.z, c), flat = two.find(p.x, p.y, p.z, d);
        ASSERT_TRUE(hit && flat);
        const int id = roadquery::lane_id_at(road, s, t);
        const auto& lanes = id > 0 ? road.sections[0].left : road.sections[0].right;
        const bool driving = id != 0 && lanes[static_cast<std::size_t>(std::abs(id)) - 1].type == LaneType::driving;
        if (driving) {
          EXPECT_NEAR(hit->z, flat->z, 1e-6) << road.osm_id << ' ' << s << ' ' << t;
        }
        walked += static_cast<int>(hit->z > flat->z + 0.1);
      }
    }
  }
  EXPECT_GT(walked, 1000) << "walks are high";
}

}  // namespace
}  // namespace orthodrive
