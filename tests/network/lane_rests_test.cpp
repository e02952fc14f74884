// SPDX-License-Identifier: Apache-2.0
// What lies beside the driving lanes: which strips a carriageway has, and that they fill it along roads and junctions.

#include "orthodrive/network/lanes/lane_rests.hpp"

#include "network_support.hpp"
#include "orthodrive/network/lanes/lanes.hpp"
#include "roadquery/surface/junction_surface.hpp"

namespace orthodrive {
namespace {

using namespace orthodrive::network_test;
using network::LaneRests;
using roadquery::Lane;
using roadquery::LaneType;
using roadquery::Road;

struct Strips {
  LaneType left, right;
  double left_m, right_m, lane_m;
};

Strips strips_of(const RoadPath& path, double width_m, DrivingSide side = DrivingSide::right) {
  const network::LaneLayout layout = network::lane_layout(path, width_m, side);
  const LaneRests rests = network::lane_rests(path, layout, width_m, side);
  return {rests.left.type, rests.right.type, rests.left.share * width_m, rests.right.share * width_m,
          (1.0 - rests.share()) * width_m / layout.total()};
}

void expect_strips(const Strips& s, LaneType left, double left_m, LaneType right, double right_m, double lane_m) {
  EXPECT_EQ(s.left, left);
  EXPECT_EQ(s.right, right);
  EXPECT_NEAR(s.left_m, left_m, 1e-9);
  EXPECT_NEAR(s.right_m, right_m, 1e-9);
  EXPECT_NEAR(s.lane_m, lane_m, 1e-9);
}

TEST(LaneRests, a_motorway_has_a_strip_inside_and_a_shoulder_outside) {
  RoadPath path{.highway = "motorway", .oneway = Oneway::forward, .lanes = 2};
  expect_strips(strips_of(path, 11.5), LaneType::border, 0.75, LaneType::shoulder, 3.25, 3.75);
  expect_strips(strips_of(path, 11.5, DrivingSide::left), LaneType::shoulder, 3.25, LaneType::border, 0.75, 3.75);
  path.lanes = 0;
  EXPECT_NEAR(strips_of(path, 11.5).lane_m, 3.75, 1e-9) << "a shoulder is no third lane";
  path.lanes = 2;
  expect_strips(strips_of(path, 7.9), LaneType::none, 0.0, LaneType::none, 0.0, 3.95);
}

TEST(LaneRests, a_rural_road_has_shoulders_or_edge_strips) {
  RoadPath path{.highway = "primary"};
  expect_strips(strips_of(path, 9.5), LaneType::shoulder, 1.25, LaneType::shoulder, 1.25, 3.5);
  expect_strips(strips_of(path, 8.0), LaneType::border, 0.5, LaneType::border, 0.5, 3.5);
  expect_strips(strips_of(path, 7.8), LaneType::none, 0.0, LaneType::none, 0.0, 3.9);
  path.sidewalk = Sides::left;
  EXPECT_EQ(strips_of(path, 9.5).left, LaneType::border) << "in a town";
  path.shoulder = Sides::left;
  expect_strips(strips_of(path, 7.6), LaneType::shoulder, 1.6, LaneType::none, 0.0, 3.0);
}

TEST(LaneRests, streets_have_room_for_parked_cars) {
  RoadPath path{.highway = "residential"};
  expect_strips(strips_of(path, 9.5), LaneType::parking, 2.0, LaneType::parking, 2.0, 2.75);
  expect_strips(strips_of(path, 11.0), LaneType::parking, 2.5, LaneType::parking, 2.5, 3.0);
  expect_strips(strips_of(path, 12.5), LaneType::parking, 3.0, LaneType::parking, 3.0, 3.25);
  expect_strips(strips_of(path, 8.5), LaneType::border, 1.0, LaneType::border, 1.0, 3.25);
  expect_strips(strips_of(path, 6.0), LaneType::none, 0.0, LaneType::none, 0.0, 3.0);
  path = {.highway = "residential", .oneway = Oneway::forward};
  expect_strips(strips_of(path, 5.2), LaneType::none, 0.0, LaneType::parking, 2.2, 3.0);
}

TEST(LaneRests, a_ring_has_a_strip_at_its_island) {
  RoadPath path{.highway = "secondary", .oneway = Oneway::forward, .roundabout = true};
  expect_strips(strips_of(path, 7.7), LaneType::border, 1.2, LaneType::none, 0.0, 6.5);
  expect_strips(strips_of(path, 6.0), LaneType::none, 0.0, LaneType::none, 0.0, 6.0);
  EXPECT_EQ(network::lane_layout(path, 9.0, DrivingSide::right).total(), 2);
}

TEST(LaneRests, race_tracks_and_unknown_classes_have_none) {
  expect_strips(strips_of({.highway = "raceway", .oneway = Oneway::forward}, 13.0), LaneType::none, 0.0, LaneType::none,
                0.0, 13.0 / 4.0);
}

/// Widths of all lanes of a road are none negative and fill the carriageway, without steps.
void expect_filled(const Road& road, double width_m) {
  std::vector<double> before;
  for (double s = 0.0; s <= road.length; s += 0.5) {
    const roadquery::Edges edges = roadquery::carriageway_edges(road, s);
    EXPECT_NEAR(edges.left_t, 0.5 * width_m, 1e-6) << s;
    EXPECT_NEAR(edges.right_t, -0.5 * width_m, 1e-6) << s;
    std::vector<double> widths;
    for (const auto* side : {&road.sections[0].left, &road.sections[0].right})
      for (const Lane& lane : *side) widths.push_back(roadquery::lane_width(lane, s));
    for (std::size_t i = 0; i < widths.size(); ++i) {
      EXPECT_GE(widths[i], -1e-9) << s;
      if (!before.empty()) EXPECT_LT(std::abs(widths[i] - before[i]), 0.15) << s;
    }
    before = widths;
  }
}

TEST(LaneRests, strips_of_linked_roads_meet_and_end_where_the_next_has_none) {
  const auto path = [](int id, double x, std::int64_t node, int lanes) {
    return make_path({{x, 0}, {x + 150, 0}}, {node, node + 1},
                     {.osm_id = id, .highway = "motorway", .width_m = 11.5, .oneway = Oneway::forward, .lanes = lanes});
  };
  const NetworkResult result = build_network(network_of({path(1, 0, 1, 2), path(2, 150, 2, 2), path(3, 300, 3, 3)}));
  expect_sound(result.map);
  ASSERT_EQ(result.map.roads.size(), 3u);
  for (const Road& road : result.map.roads) expect_filled(road, 11.5);
  const Road &a = result.map.roads[0], &b = result.map.roads[1], &c = result.map.roads[2];
  ASSERT_EQ(b.sections[0].left.size(), 1u);
  ASSERT_EQ(b.sections[0].right.size(), 3u);
  EXPECT_EQ(b.sections[0].left[0].predecessor, 1) << "strips go on";
  EXPECT_EQ(b.sections[0].right[2].predecessor, -3);
  EXPECT_EQ(a.sections[0].right[2].successor, -3);
  EXPECT_FALSE(b.sections[0].right[2].successor) << "three lanes leave no room";
  EXPECT_NEAR(roadquery::lane_width(b.sections[0].right[2], b.length), 0.0, 1e-9);
  EXPECT_NEAR(roadquery::lane_width(b.sections[0].right[2], 0.5 * b.length), 3.25, 1e-6);
  EXPECT_TRUE(c.sections[0].left.empty());
  EXPECT_EQ(b.sections[0].center.marks[0].type, "solid") << "between the strip and the lanes";
  EXPECT_EQ(b.sections[0].right[0].marks[0].type, "broken");
  EXPECT_EQ(b.sections[0].right[1].marks[0].type, "solid") << "between the lanes and the shoulder";
  EXPECT_EQ(b.sections[0].right[2].marks[0].type, "none");
}

TEST(LaneRests, a_way_drawn_against_the_other_meets_it_too) {
  const RoadPath a = make_path({{0, 0}, {150, 0}}, {1, 2}, {.osm_id = 1, .highway = "primary", .width_m = 8.5});
  RoadPath b = make_path({{300, 0}, {150, 0}}, {3, 2}, {.osm_id = 2, .highway = "primary", .width_m = 8.5});
  b.shoulder = Sides::left;  // right of the first
  const NetworkResult result = build_network(network_of({a, b}));
  expect_sound(result.map);
  ASSERT_EQ(result.map.roads.size(), 2u);
  for (const Road& road : result.map.roads) expect_filled(road, 8.5);
}

TEST(LaneRests, strips_go_through_junctions_and_connections_link_driving_lanes_alone) {
  const auto arm = [](int id, Vec2 to, double width_m) {
    return make_path({{0, 0}, to}, {9, id}, {.osm_id = id, .highway = "primary", .width_m = width_m});
  };
  const NetworkResult result =
      build_network(network_of({arm(1, {-150, 0}, 9.5), arm(2, {150, 0}, 9.5), arm(3, {0, 150}, 6.5)}));
  expect_sound(result.map);
  ASSERT_EQ(result.map.junctions.size(), 1u);
  int with_strip = 0;
  for (const roadquery::Connection& connection : result.map.junctions[0].connections) {
    const Road& road = *road_by_id(result.map, connection.connecting_road);
    const Road& incoming = *road_by_id(result.map, connection.incoming_road);
    for (const roadquery::LaneLink& link : connection.lane_links) {
      const auto type = [](const Road& of, int id) {
        return (id > 0 ? of.sections[0].left : of.sections[0].right)
            .at(static_cast<std::size_t>(std::abs(id)) - 1)
            .type;
      };
      EXPECT_EQ(type(road, link.to), LaneType::driving);
      EXPECT_EQ(type(incoming, link.from), LaneType::driving);
    }
    if (road.sections[0].right.back().type != LaneType::border) continue;
    ++with_strip;
    EXPECT_NEAR(roadquery::lane_width(road.sections[0].right.back(), 0.5 * road.length), 1.25, 0.01);
  }
  EXPECT_EQ(with_strip, 2) << "both directions of the way straight on";
  ASSERT_TRUE(roadquery::surface_of(result.map.junctions[0]));
  const std::optional<roadquery::JunctionSurface>& surface = result.map.junctions[0].surface;
  ASSERT_TRUE(surface.has_value());
  for (const double y : {-4.6, 4.6})  // the whole width is paved
    EXPECT_TRUE(roadquery::contains(*surface, site_origin.x, site_origin.y + y)) << y;
}

}  // namespace
}  // namespace orthodrive
