// SPDX-License-Identifier: Apache-2.0
// Network scores of maps made by hand, each with one known fault.

#include <gtest/gtest.h>

#include <cmath>

#include "orthodrive/evaluate/networks/compare_surfaces.hpp"
#include "orthodrive/evaluate/networks/evaluate_network.hpp"

namespace orthodrive {
namespace {
using namespace roadquery;

Road straight_road(int id, double x, double y, double hdg, double length) {
  Road road{.id = id, .length = length};
  road.plan = {{.x = x, .y = y, .hdg = hdg, .length = length, .shape = Line{}}};
  road.elevation = {{.a = 10.0}};
  LaneSection section;
  section.left = {{.id = 1, .width = {{.a = 3.0}}}};
  section.right = {{.id = -1, .width = {{.a = 3.0}}}};
  road.sections = {section};
  return road;
}
void link(Road& before, Road& after) {
  before.successor = {LinkKind::road, after.id, ContactPoint::start};
  after.predecessor = {LinkKind::road, before.id, ContactPoint::end};
  for (Lane* lane : {&before.sections[0].left[0], &before.sections[0].right[0]}) lane->successor = lane->id;
  for (Lane* lane : {&after.sections[0].left[0], &after.sections[0].right[0]}) lane->predecessor = lane->id;
}

TEST(EvaluateNetwork, two_roads_in_a_row) {
  RoadMap map{.roads = {straight_road(1, 0, 0, 0, 100), straight_road(2, 100, 0, 0, 50)}};
  link(map.roads[0], map.roads[1]);
  const NetworkScores scores = evaluate_network(map);
  EXPECT_EQ(scores.roads, 2u);
  EXPECT_DOUBLE_EQ(scores.length_m, 150.0);
  EXPECT_EQ(scores.elements.at("line"), 2u);
  EXPECT_EQ(scores.elements.at("spiral"), 0u);
  EXPECT_NEAR(scores.max_joint_gap_m, 0.0, 1e-12);
  EXPECT_DOUBLE_EQ(scores.connected_share, 1.0);
  EXPECT_EQ(scores.crossings, 0u);
  EXPECT_TRUE(std::isnan(scores.min_clearance_m));
}

TEST(EvaluateNetwork, gap_step_and_broken_link) {
  RoadMap map{.roads = {straight_road(1, 0, 0, 0, 100), straight_road(2, 100.3, 0, 0, 50)}};
  link(map.roads[0], map.roads[1]);
  map.roads[1].elevation[0].a = 10.4;
  EXPECT_NEAR(evaluate_network(map).max_joint_gap_m, 0.5, 1e-12) << "0.3 along and 0.4 up";
  map.roads[1].successor = {LinkKind::road, 99, ContactPoint::start};
  EXPECT_EQ(evaluate_network(map).broken_links, 1u);
}

TEST(EvaluateNetwork, gap_between_the_elements_of_one_road) {
  Road road = straight_road(1, 0, 0, 0, 60);
  road.plan[0].length = 30.0;
  road.plan.push_back({.s = 30.0, .x = 30.0, .y = 0.02, .hdg = 0.0, .length = 30.0, .shape = Arc{0.01}});
  const NetworkScores scores = evaluate_network({.roads = {road}});
  EXPECT_NEAR(scores.max_joint_gap_m, 0.02, 1e-12);
  EXPECT_EQ(scores.elements.at("arc"), 1u);
}

TEST(EvaluateNetwork, connecting_road_that_starts_at_the_lane_edge_has_no_gap) {
  // Its reference line is the inner border of the incoming road's left lane pair shifted: only the linked lane has to
  // meet.
  RoadMap map{.roads = {straight_road(1, 0, 0, 0, 100), straight_road(2, 100, -3, 0, 20)}};
  Road& connecting = map.roads[1];
  connecting.junction = 7;
  connecting.lane_offset = {{.a = 3.0}};  // back to the middle of the incoming road
  connecting.sections[0].left.clear();
  connecting.predecessor = {LinkKind::road, 1, ContactPoint::end};
  connecting.sections[0].right[0].predecessor = -1;
  map.roads[0].successor = {LinkKind::junction, 7, ContactPoint::start};
  map.junctions = {{.id = 7, .connections = {{.incoming_road = 1, .connecting_road = 2}}}};
  const NetworkScores scores = evaluate_network(map);
  EXPECT_NEAR(scores.max_joint_gap_m, 0.0, 1e-12);
  EXPECT_EQ(scores.connecting_roads, 1u);
  EXPECT_EQ(scores.junctions, 1u);
  EXPECT_DOUBLE_EQ(scores.connected_share, 1.0);
}

TEST(EvaluateNetwork, gradient_kink_inside_a_road) {
  Road road = straight_road(1, 0, 0, 0, 100);
  road.elevation = {
      {.s = 0, .a = 0, .b = 0.01, .c = 0.0005}, {.s = 20, .a = 0.4, .b = 0.03}, {.s = 60, .a = 1.6, .b = -0.04}};
  EXPECT_NEAR(evaluate_network({.roads = {road}}).max_gradient_kink, 0.07, 1e-12)
      << "smooth at 20 m, 0.03 to -0.04 at 60 m";
}

TEST(EvaluateNetwork, jumps_of_heading_curvature_and_gradient) {
  RoadMap map{.roads = {straight_road(1, 0, 0, 0, 100), straight_road(2, 100, 0, 0.02, 50)}};
  link(map.roads[0], map.roads[1]);
  map.roads[1].elevation = {{.a = 10.0, .b = 0.03}};
  NetworkScores scores = evaluate_network(map);
  EXPECT_NEAR(scores.max_heading_jump_rad, 0.02, 1e-12);
  EXPECT_NEAR(scores.max_gradient_kink, 0.03, 1e-12) << "from road to road";
  EXPECT_NEAR(scores.max_curvature_jump, 0.0, 1e-12);
  map.roads[1].plan[0].shape = Arc{0.01};
  EXPECT_NEAR(evaluate_network(map).max_curvature_jump, 0.01, 1e-12);
  map.roads[1].junction = 5;
  EXPECT_NEAR(evaluate_network(map).max_curvature_jump, 0.0, 1e-12) << "turning roads may";

  // Driven against its s a road's gradient and curvature change sign: end to end, smooth.
  RoadMap facing{.roads = {straight_road(1, 0, 0, 0, 100), straight_road(2, 150, 0, M_PI, 50)}};
  Road &a = facing.roads[0], &b = facing.roads[1];
  a.successor = {LinkKind::road, 2, ContactPoint::end}, b.successor = {LinkKind::road, 1, ContactPoint::end};
  a.elevation = {{.a = 10.0, .b = 0.02}}, b.elevation = {{.a = 13.0, .b = -0.02}};
  scores = evaluate_network(facing);
  EXPECT_NEAR(scores.max_heading_jump_rad, 0.0, 1e-12);
  EXPECT_NEAR(scores.max_gradient_kink, 0.0, 1e-12);
}

// docs/notes/trackers.md: extracts and writers leave connections out.
TEST(EvaluateNetwork, a_junction_has_to_know_the_roads_that_lead_to_it) {
  RoadMap map{
      .roads = {straight_road(1, 0, 0, 0, 100), straight_road(2, 120, 0, 0, 50), straight_road(3, 100, 0, 0, 20)},
      .junctions = {{.id = 9}}};
  map.roads[0].successor = map.roads[1].predecessor = {LinkKind::junction, 9, {}};
  map.roads[2].junction = 9;
  map.roads[2].predecessor = {LinkKind::road, 1, ContactPoint::end};
  map.roads[2].successor = {LinkKind::road, 2, ContactPoint::start};
  EXPECT_EQ(evaluate_network(map).broken_links, 2u) << "no connection";
  map.junctions[0].connections = {{.id = 0, .incoming_road = 1, .connecting_road = 3, .lane_links = {{-1, -1}}}};
  EXPECT_EQ(evaluate_network(map).broken_links, 0u) << "road 2 is where it leads";
  map.junctions[0].connections[0].connecting_road = 2;
  EXPECT_EQ(evaluate_network(map).broken_links, 0u) << "a direct junction names the linked road";
}

TEST(EvaluateNetwork, links_that_lead_nowhere_are_those_that_the_reader_notes) {
  RoadMap map{.roads = {straight_road(1, 0, 0, 0, 100), straight_road(2, 100, 0, 0, 50)}, .junctions = {{.id = 9}}};
  map.roads[0].successor = {LinkKind::junction, 8, {}};
  EXPECT_EQ(evaluate_network(map).broken_links, 1u) << "no such junction";
  map.roads[0].successor = {};
  map.junctions[0].connections = {{.id = 0, .incoming_road = 1, .connecting_road = 7}};
  EXPECT_EQ(evaluate_network(map).broken_links, 1u) << "no such road";
  map.junctions[0].connections = {{.id = 0, .incoming_road = 0, .connecting_road = 2}};
  EXPECT_EQ(evaluate_network(map).broken_links, 0u) << "a virtual junction has connections without an incoming road";
}

TEST(EvaluateNetwork, lane_links_have_to_agree) {
  RoadMap map{.roads = {straight_road(1, 0, 0, 0, 100), straight_road(2, 100, 0, 0, 50)}};
  link(map.roads[0], map.roads[1]);
  NetworkScores scores = evaluate_network(map);
  EXPECT_EQ(scores.lane_link_errors, 0u);
  EXPECT_EQ(scores.dead_lanes, 0u);
  EXPECT_EQ(scores.broken_links, 0u);
  EXPECT_DOUBLE_EQ(scores.min_lane_width_m, 3.0);

  RoadMap broken = map;
  broken.roads[0].sections[0].right[0].successor = -2;
  EXPECT_EQ(evaluate_network(broken).lane_link_errors, 2u) << "no such lane, and road 2 is not answered";
  broken = map;
  broken.roads[0].sections[0].right[0].successor = 1;
  EXPECT_GE(evaluate_network(broken).lane_link_errors, 1u) << "into the oncoming lane";
  broken = map;
  broken.roads[1].sections[0].right[0].type = LaneType::sidewalk;
  EXPECT_GE(evaluate_network(broken).lane_link_errors, 1u);
  broken = map;
  broken.roads[0].sections[0].right[0].successor.reset();
  broken.roads[1].sections[0].right[0].predecessor.reset();
  EXPECT_EQ(evaluate_network(broken).dead_lanes, 1u);
  broken = map;
  broken.roads[1].predecessor = {};
  EXPECT_EQ(evaluate_network(broken).broken_links, 1u) << "one side only";
}

TEST(EvaluateNetwork, clearance_under_a_bridge) {
  RoadMap map{.roads = {straight_road(1, 0, 0, 0, 100), straight_road(2, 50, -50, 1.5707963267948966, 100)}};
  map.roads[1].elevation = {{.a = 13.0, .b = 0.05}};  // 15.5 m at the crossing
  EXPECT_EQ(evaluate_network(map).crossings, 1u) << "same layer, but far apart: a bridge without a tag";
  map.roads[1].elevation.front().a = 8.0;
  EXPECT_EQ(evaluate_network(map).crossings, 0u)
      << "half a metre apart on the same layer: not a bridge but a missing junction";
  map.roads[1].elevation.front().a = 13.0;
  map.roads[1].layer = 1;
  const NetworkScores scores = evaluate_network(map);
  EXPECT_EQ(scores.crossings, 1u);
  EXPECT_NEAR(scores.min_clearance_m, 5.5, 1e-9);
  EXPECT_DOUBLE_EQ(scores.connected_share, 0.5);
  ASSERT_EQ(scores.crossing_places.size(), 1u);
  const Overpass& place = scores.crossing_places[0];
  EXPECT_EQ(place.upper_road, 2);
  EXPECT_EQ(place.lower_road, 1);
  EXPECT_NEAR(place.x, 50.0, 1e-9);
  EXPECT_NEAR(place.y, 0.0, 1e-9);
  map.roads[1].elevation = {{.a = 1.0, .b = 0.05}};  // the layer says above, the height does not
  EXPECT_EQ(evaluate_network(map).crossing_places.at(0).upper_road, 1);
}

TEST(EvaluateNetwork, elements_and_curvature_rates_of_roads_outside_junctions) {
  RoadMap map{.roads = {straight_road(1, 0, 0, 0, 100), straight_road(2, 0, 50, 0, 20)}};
  map.roads[0].plan = {{.length = 60.0, .shape = Line{}},
                       {.s = 60.0, .x = 60.0, .length = 40.0, .shape = Spiral{0.0, 0.02}}};
  NetworkScores scores = evaluate_network(map);
  EXPECT_EQ(scores.road_elements, 3u);
  EXPECT_DOUBLE_EQ(scores.road_length_m, 120.0);
  EXPECT_DOUBLE_EQ(scores.mean_road_element_m, 40.0);
  EXPECT_NEAR(scores.max_curvature_rate, 0.02 / 40.0, 1e-12);
  map.roads[0].junction = 5;
  scores = evaluate_network(map);
  EXPECT_EQ(scores.road_elements, 1u);
  EXPECT_EQ(scores.max_curvature_rate, 0.0);
}

TEST(EvaluateNetwork, lane_that_has_narrowed_to_nothing_is_not_dead) {
  RoadMap map{.roads = {straight_road(1, 0, 0, 0, 100), straight_road(2, 100, 0, 0, 50)}};
  link(map.roads[0], map.roads[1]);
  map.roads[0].sections[0].right.push_back({.id = -2, .width = {{.a = 3.0}}});
  NetworkScores scores = evaluate_network(map);
  ASSERT_EQ(scores.dead_lane_places.size(), 1u);
  EXPECT_EQ(scores.dead_lane_places[0].road, 1);
  EXPECT_EQ(scores.dead_lane_places[0].lane, -2);
  EXPECT_NEAR(scores.dead_lane_places[0].x, 100.0, 1e-9);
  EXPECT_NEAR(scores.dead_lane_places[0].y, -3.0, 1e-9);
  map.roads[0].sections[0].right[1].width = {{.a = 3.0, .b = -0.03}};
  scores = evaluate_network(map);
  EXPECT_EQ(scores.dead_lanes, 0u);
  EXPECT_DOUBLE_EQ(scores.min_lane_width_m, 3.0) << "where it is widest";
}

TEST(CompareSurfaces, finds_the_road_that_differs_and_those_that_are_missing) {
  const RoadMap a{.roads = {straight_road(1, 0, 0, 0, 100), straight_road(2, 0, 50, 0.3, 33)}};
  EXPECT_EQ(compare_surfaces(a, a).max_distance_m, 0.0);
  EXPECT_EQ(compare_surfaces(a, a).points, 51u * 3u + 18u * 3u);
  RoadMap b = a;
  b.roads[1].superelevation = {{.a = 0.0, .b = 1e-4}};
  const SurfaceComparison tilted = compare_surfaces(a, b);
  EXPECT_EQ(tilted.road, 2);
  EXPECT_NEAR(tilted.max_distance_m, 3.0 * 33e-4, 1e-5) << "at the edge of its end";
  EXPECT_DOUBLE_EQ(tilted.s, 33.0);
  b.roads.pop_back();
  EXPECT_EQ(compare_surfaces(a, b).missing_roads, 1u);
  EXPECT_EQ(compare_surfaces(b, a).missing_roads, 1u);
  b = a, b.roads[0].length = 99.0;
  EXPECT_EQ(compare_surfaces(a, b).missing_roads, 1u);
  EXPECT_TRUE(std::isnan(compare_surfaces({}, a).max_distance_m));
}

TEST(EvaluateNetwork, connecting_road_off_a_bridge_lies_on_both_layers) {
  // 1 ends on a bridge, 2 leads off it through a junction into 3 and crosses 4, which the map joins to none of them.
  RoadMap map{.roads = {straight_road(1, 0, 0, 0, 100), straight_road(2, 100, 0, 0, 20),
                        straight_road(3, 120, 0, 0, 50), straight_road(4, 110, -30, 1.5707963267948966, 60)}};
  map.roads[0].layer = map.roads[1].layer = 1;
  link(map.roads[0], map.roads[1]), link(map.roads[1], map.roads[2]);
  map.roads[1].junction = 7;
  EXPECT_EQ(evaluate_network(map).crossings, 0u) << "level with 4: a missing junction";
  map.roads[2].layer = 1;
  EXPECT_EQ(evaluate_network(map).crossings, 1u) << "from bridge to bridge: no height between them";
  EXPECT_NEAR(evaluate_network(map).min_clearance_m, 0.0, 1e-9);
}

TEST(EvaluateNetwork, bridge_that_joins_the_road_before_it_is_no_crossing) {
  RoadMap map{.roads = {straight_road(1, 0, 0, 0, 100), straight_road(2, 100, 0, 0.2, 50)}};
  map.roads[1].layer = 1;
  link(map.roads[0], map.roads[1]);
  EXPECT_EQ(evaluate_network(map).crossings, 0u);
}

TEST(EvaluateNetwork, empty_map) {
  const NetworkScores scores = evaluate_network({});
  EXPECT_EQ(scores.roads, 0u);
  EXPECT_TRUE(std::isnan(scores.connected_share));
}

}  // namespace
}  // namespace orthodrive
