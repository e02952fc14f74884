// SPDX-License-Identifier: Apache-2.0
// Stop and give-way lines, arrows and crosswalks.

#include <gtest/gtest.h>

#include "network_support.hpp"
#include "orthodrive/network/paint/crosswalks.hpp"
#include "orthodrive/network/paint/waiting_lines.hpp"

namespace orthodrive {
namespace {

using namespace orthodrive::network_test;
using roadquery::Road;
using roadquery::RoadObject;

/// A T: a main road of `main` (ways 1 and 2, 7 m wide) along x, a side road of `side` (way 3) to the north. Node 9 is
/// the junction, node 8 lies on the side road 20 m off it, node 7 on the main road 30 m before it.
RoadNetwork tee(const std::string& main, const std::string& side, std::vector<NodeSign> signs = {}) {
  RoadNetwork roads =
      network_of({make_path({{-100, 0}, {-30, 0}, {0, 0}}, {1, 7, 9}, {.osm_id = 1, .highway = main, .width_m = 7.0}),
                  make_path({{0, 0}, {100, 0}}, {9, 2}, {.osm_id = 2, .highway = main, .width_m = 7.0}),
                  make_path({{0, 0}, {0, 20}, {0, 100}}, {9, 8, 3}, {.osm_id = 3, .highway = side, .width_m = 6.0})});
  roads.signs = std::move(signs);
  return roads;
}

struct Painted {
  std::string osm_id, type, subtype, name;
  double x, y, s, length;  // of the object's middle, in the site
  int junction;
};

std::vector<Painted> painted(const roadquery::RoadMap& map) {
  std::vector<Painted> all;
  for (const Road& road : map.roads)
    for (const RoadObject& o : road.objects) {
      const auto p = roadquery::surface_point(road, o.s, o.t);
      all.push_back({road.osm_id, o.type, o.subtype, o.name, p.x - site_origin.x, p.y - site_origin.y, o.s, road.length,
                     road.junction});
    }
  return all;
}

TEST(WaitingLines, side_roads_of_main_roads_give_way) {
  const std::vector<Painted> lines = painted(build_network(tee("secondary", "residential")).map);
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_EQ(lines[0].osm_id, "3");
  EXPECT_EQ(lines[0].name, network::give_way_line);
  EXPECT_EQ(lines[0].subtype, "signalLines");
  EXPECT_NEAR(lines[0].x, -1.5, 0.2) << "who drives south keeps to the west: the middle of the lane";
  EXPECT_GT(lines[0].y, 3.5) << "behind the main road's edge";
  EXPECT_LT(lines[0].y, 15.0);
}

TEST(WaitingLines, none_between_equals_on_tracks_and_driveways) {
  EXPECT_TRUE(painted(build_network(tee("residential", "residential")).map).empty());
  EXPECT_TRUE(painted(build_network(tee("residential", "living_street")).map).empty()) << "right before left";
  EXPECT_TRUE(painted(build_network(tee("secondary", "service")).map).empty());
  EXPECT_TRUE(painted(build_network(tee("secondary", "track")).map).empty());
  RoadNetwork gravel = tee("secondary", "residential");
  gravel.paths[2].known_surface = {SurfaceClass::gravel, SurfaceSource::tag};
  EXPECT_TRUE(painted(build_network(gravel).map).empty());
}

TEST(WaitingLines, signs_of_the_map_count_first) {
  const auto one = [](NodeSign sign) {
    const auto lines = painted(build_network(tee("residential", "residential", {sign})).map);
    return lines.size() == 1 ? lines[0] : Painted{};
  };
  EXPECT_EQ(one({8, NodeSignKind::stop, 0}).name, network::stop_line);
  EXPECT_EQ(one({8, NodeSignKind::stop, 0}).osm_id, "3");
  EXPECT_EQ(one({8, NodeSignKind::give_way, -1}).name, network::give_way_line);
  EXPECT_EQ(one({8, NodeSignKind::give_way, 1}).name, "") << "for who drives the other way";
  EXPECT_EQ(one({7, NodeSignKind::traffic_signals, 1}).osm_id, "1");
  EXPECT_EQ(
      painted(build_network(tee("residential", "residential", {{9, NodeSignKind::traffic_signals, 0}})).map).size(), 3u)
      << "lights at the junction itself are for all";
}

TEST(WaitingLines, a_sign_without_direction_is_the_nearer_junctions) {
  RoadNetwork roads = tee("residential", "residential", {{8, NodeSignKind::stop, 0}});
  // The side road ends in another junction 15 m beyond the sign.
  roads.paths[2] = make_path({{0, 0}, {0, 20}, {0, 35}}, {9, 8, 3}, {.osm_id = 3});
  roads.paths.push_back(make_path({{-80, 35}, {0, 35}}, {11, 3}, {.osm_id = 4}));
  roads.paths.push_back(make_path({{0, 35}, {80, 35}}, {3, 12}, {.osm_id = 5}));
  const auto lines = painted(build_network(roads).map);
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_EQ(lines[0].osm_id, "3");
  EXPECT_GT(lines[0].y, 18.0);
  EXPECT_GT(lines[0].x, 0.0) << "who drives north keeps to the east";
}

TEST(WaitingLines, left_hand_traffic_waits_on_the_other_side) {
  const auto lines = painted(build_network(tee("secondary", "residential"), {.driving_side = DrivingSide::left}).map);
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_NEAR(lines[0].x, 1.5, 0.2);
}

TEST(Crosswalks, lie_on_the_road_across_its_carriageway) {
  RoadNetwork roads = tee("secondary", "residential", {{7, NodeSignKind::zebra, 0}});
  roads.paths[0].sidewalk = Sides::both;
  const roadquery::RoadMap map = build_network(roads).map;
  const Road* road = nullptr;
  for (const Road& r : map.roads)
    if (r.osm_id == "1" && r.junction < 0) road = &r;
  ASSERT_TRUE(road);
  ASSERT_EQ(road->objects.size(), 1u);
  const RoadObject& zebra = road->objects[0];
  EXPECT_EQ(zebra.type, "crosswalk");
  EXPECT_EQ(zebra.subtype, "zebra");
  EXPECT_NEAR(zebra.s, 70.0, 0.1);
  EXPECT_NEAR(zebra.t, 0.0, 0.05);
  EXPECT_NEAR(zebra.width, 7.0, 0.05) << "without the sidewalks";
  EXPECT_EQ(zebra.length, network::crosswalk_m);
  ASSERT_EQ(zebra.outline.size(), 4u);
  EXPECT_NEAR(zebra.outline[2][0] - zebra.outline[0][0], network::crosswalk_m, 1e-9);
}

TEST(Crosswalks, inside_a_junction_they_lie_on_the_way_straight_on) {
  RoadNetwork roads = tee("secondary", "secondary", {{5, NodeSignKind::signal_crossing, 0}});
  roads.paths[0] =
      make_path({{-100, 0}, {-3, 0}, {0, 0}}, {1, 5, 9}, {.osm_id = 1, .highway = "secondary", .width_m = 7.0});
  const auto found = painted(build_network(roads).map);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_GE(found[0].junction, 0);
  EXPECT_EQ(found[0].subtype, "pedestrian");
  EXPECT_NEAR(found[0].x, -3.0, 0.2);
  EXPECT_NEAR(found[0].y, 0.0, 0.1);
}

TEST(Crosswalks, waiting_lines_come_before_them) {
  RoadNetwork roads = tee("secondary", "residential", {{8, NodeSignKind::plain_crossing, 0}});
  roads.paths[2] = make_path({{0, 0}, {0, 12}, {0, 100}}, {9, 8, 3}, {.osm_id = 3});
  const auto found = painted(build_network(roads).map);
  ASSERT_EQ(found.size(), 2u);
  EXPECT_EQ(found[0].subtype, "virtual");
  EXPECT_NEAR(found[1].y - found[0].y, 0.5 * network::crosswalk_m + 1.0 + 0.5 * network::waiting_line_m, 0.02);
}

TEST(LaneArrows, show_what_turn_lanes_says) {
  RoadNetwork roads = tee("primary", "residential");
  RoadPath& west = roads.paths[0];
  west = make_path({{-100, 0}, {0, 0}}, {1, 9}, {.osm_id = 1, .highway = "primary", .width_m = 10.5, .lanes = 3});
  west.lanes_forward = 2, west.lanes_backward = 1, west.turn_forward = "left|through;right";
  std::vector<Painted> arrows;
  for (const Painted& p : painted(build_network(roads).map))
    if (p.subtype.starts_with("arrow")) arrows.push_back(p);
  ASSERT_EQ(arrows.size(), 4u) << "two lanes, twice";
  EXPECT_EQ(arrows[0].subtype, "arrowLeft");
  EXPECT_EQ(arrows[1].subtype, "arrowStraightRight");
  EXPECT_NEAR(arrows[0].y, 0.0, 0.1) << "the middle lane of three";
  EXPECT_NEAR(arrows[1].y, -3.5, 0.1);
  EXPECT_NEAR(arrows[0].length - arrows[0].s, 6.5, 0.01) << "4 m and half an arrow";
  EXPECT_NEAR(arrows[0].s - arrows[2].s, 25.0, 0.01);
}

}  // namespace
}  // namespace orthodrive
