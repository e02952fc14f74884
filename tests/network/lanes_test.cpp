// SPDX-License-Identifier: Apache-2.0
// Lanes, their markings and their tapers; turn lanes, restrictions and roundabouts at junctions.

#include "orthodrive/network/lanes/lanes.hpp"

#include "network_support.hpp"
#include "orthodrive/network/line/road_cuts.hpp"
#include "orthodrive/network/topology/roundabouts.hpp"
#include "orthodrive/network/topology/topology.hpp"

namespace orthodrive {
namespace {

using namespace orthodrive::network_test;
using roadquery::Lane;
using roadquery::LaneType;
using roadquery::Road;

int findings_of(const NetworkResult& result, const std::string& code) {
  return static_cast<int>(std::count_if(result.findings.begin(), result.findings.end(),
                                        [&](const Finding& finding) { return finding.code == code; }));
}

const Road& road_of(const roadquery::RoadMap& map, const std::string& osm_id) {
  for (const Road& road : map.roads)
    if (road.junction < 0 && road.osm_id == osm_id) return road;
  throw std::runtime_error("no road of way " + osm_id);
}

/// Connecting roads from one way to another.
std::vector<const Road*> movements(const roadquery::RoadMap& map, const std::string& from, const std::string& to) {
  std::vector<const Road*> found;
  for (const Road* road : connecting_roads(map))
    if (road_by_id(map, road->predecessor.id)->osm_id == from && road_by_id(map, road->successor.id)->osm_id == to)
      found.push_back(road);
  return found;
}

TEST(LaneLayout, of_tags_and_width) {
  RoadPath path;
  const auto layout = [&](double width_m) {
    const network::LaneLayout l = network::lane_layout(path, width_m, DrivingSide::right);
    return std::pair{l.left, l.right};
  };
  EXPECT_EQ(layout(6.0), std::pair(1, 1));
  EXPECT_EQ(layout(13.0), std::pair(2, 2)) << "by width";
  path.lanes = 3;
  EXPECT_EQ(layout(10.0), std::pair(1, 2));
  EXPECT_EQ(layout(4.0), std::pair(1, 1)) << "three lanes do not fit in 4 m";
  EXPECT_TRUE(network::lane_layout(path, 4.0, DrivingSide::right).reduced);
  EXPECT_FALSE(network::lane_layout(path, 10.0, DrivingSide::right).reduced);
  path.lanes_backward = 2, path.lanes_forward = 1;
  EXPECT_EQ(layout(10.0), std::pair(2, 1));
  EXPECT_EQ(network::lane_layout(path, 10.0, DrivingSide::left).left, 1)
      << "forward is left where one drives on the left";
  path = {.lanes = 2};
  path.lanes_forward = 2;
  EXPECT_EQ(layout(10.0), std::pair(1, 2)) << "somebody may come the other way";
  path = {.oneway = Oneway::forward, .lanes = 3};
  EXPECT_EQ(layout(10.0), std::pair(0, 3));
  EXPECT_EQ(layout(2.0), std::pair(0, 1));
}

TEST(LaneMatch, lanes_open_and_end_outside_and_turn_lanes_inside) {
  const auto match = [](int from, int to, int inner) {
    const network::LaneMatch m = network::match_lanes(from, to, inner);
    return std::array{m.from.first, m.from.count, m.to.first, m.to.count};
  };
  EXPECT_EQ(match(2, 2, 0), (std::array{0, 2, 0, 2}));
  EXPECT_EQ(match(2, 1, 0), (std::array{0, 1, 0, 1}));
  EXPECT_EQ(match(1, 3, 1), (std::array{0, 1, 1, 1}));
  EXPECT_EQ(match(2, 2, 1), (std::array{0, 2, 0, 2})) << "nothing opens";
  EXPECT_EQ(match(1, 2, 3), (std::array{0, 1, 1, 1}));
}

TEST(Lanes, an_added_lane_of_a_one_way_road_tapers_in_and_the_edges_stay) {
  PathOptions one{.osm_id = 1, .highway = "primary", .width_m = 3.5, .oneway = Oneway::forward, .lanes = 1};
  PathOptions two{.osm_id = 2, .highway = "primary", .width_m = 7.0, .oneway = Oneway::forward, .lanes = 2};
  const NetworkResult result = build_network(
      network_of({make_path({{0, 0}, {100, 0}}, {1, 2}, one), make_path({{100, 0}, {200, 0}}, {2, 3}, two)}));
  expect_sound(result.map);
  EXPECT_TRUE(result.map.junctions.empty());
  const Road &a = road_of(result.map, "1"), &b = road_of(result.map, "2");
  const auto& lanes = b.sections[0].right;
  ASSERT_EQ(lanes.size(), 2u);
  EXPECT_EQ(lanes[0].predecessor, -1);
  EXPECT_EQ(a.sections[0].right[0].successor, -1);
  EXPECT_FALSE(lanes[1].predecessor);
  EXPECT_NEAR(roadquery::lane_width(lanes[1], 0.0), 0.0, 1e-9);
  EXPECT_NEAR(roadquery::lane_width(lanes[1], 50.0), 3.5, 0.01);
  for (double s = 0.0; s <= b.length; s += 0.7) {  // whatever the lanes do, they fill the carriageway
    const roadquery::Edges edges = roadquery::road_edges(b, s);
    EXPECT_NEAR(edges.left_t + edges.right_t, 0.0, 1e-9) << s;
    for (const Lane& lane : lanes) EXPECT_GE(roadquery::lane_width(lane, s), -1e-9) << s;
  }
}

TEST(Lanes, a_lane_of_a_two_way_road_that_ends_tapers_out) {
  RoadPath three =
      make_path({{0, 0}, {100, 0}}, {1, 2}, {.osm_id = 1, .highway = "primary", .width_m = 10.5, .lanes = 3});
  RoadPath next =
      make_path({{100, 0}, {200, 0}}, {2, 3}, {.osm_id = 2, .highway = "primary", .width_m = 7.0, .lanes = 2});
  const NetworkResult result = build_network(network_of({three, next}));
  expect_sound(result.map);
  EXPECT_TRUE(result.map.junctions.empty());
  const Road &a = road_of(result.map, "1"), &b = road_of(result.map, "2");
  const auto& lanes = a.sections[0].right;
  ASSERT_EQ(lanes.size(), 2u);
  EXPECT_EQ(lanes[0].successor, -1);
  EXPECT_FALSE(lanes[1].successor);
  EXPECT_NEAR(roadquery::lane_width(lanes[1], a.length), 0.0, 1e-9);
  EXPECT_NEAR(roadquery::evaluate(a.lane_offset, a.length), roadquery::evaluate(b.lane_offset, 0.0), 1e-9);
  EXPECT_NEAR(roadquery::evaluate(a.lane_offset, 40.0), 1.75, 0.01);
  for (double s = 0.0; s <= a.length; s += 0.7)
    EXPECT_NEAR(roadquery::road_edges(a, s).left_t + roadquery::road_edges(a, s).right_t, 0.0, 1e-9) << s;
}

TEST(Lanes, a_lane_that_a_two_way_road_gains_is_reached_through_a_junction) {
  const NetworkResult result = build_network(network_of(
      {make_path({{0, 0}, {100, 0}}, {1, 2}, {.osm_id = 1, .highway = "primary", .width_m = 7.0, .lanes = 2}),
       make_path({{100, 0}, {200, 0}}, {2, 3}, {.osm_id = 2, .highway = "primary", .width_m = 10.5, .lanes = 3})}));
  expect_sound(result.map);
  ASSERT_EQ(result.map.junctions.size(), 1u);
  EXPECT_EQ(movements(result.map, "1", "2").size(), 2u) << "one for each lane";
  EXPECT_EQ(movements(result.map, "2", "1").size(), 1u);
}

TEST(Lanes, a_turn_lane_opens_inside) {
  PathOptions one{.osm_id = 1, .highway = "primary", .width_m = 3.5, .oneway = Oneway::forward, .lanes = 1};
  RoadPath wide = make_path({{100, 0}, {200, 0}}, {2, 3},
                            {.osm_id = 2, .highway = "primary", .width_m = 7.0, .oneway = Oneway::forward, .lanes = 2});
  wide.turn_forward = "left|through";
  const NetworkResult result = build_network(network_of({make_path({{0, 0}, {100, 0}}, {1, 2}, one), wide}));
  expect_sound(result.map);
  const auto& lanes = road_of(result.map, "2").sections[0].right;
  ASSERT_EQ(lanes.size(), 2u);
  EXPECT_FALSE(lanes[0].predecessor);
  EXPECT_EQ(lanes[1].predecessor, -1);
  EXPECT_NEAR(roadquery::lane_width(lanes[0], 0.0), 0.0, 1e-9);
}

TEST(Lanes, sidewalks_lie_outside_the_carriageway_and_shoulders_inside) {
  RoadPath path = make_path({{0, 0}, {100, 0}}, {1, 2}, {.highway = "secondary", .width_m = 7.2});
  path.sidewalk = Sides::left, path.shoulder = Sides::right;
  RoadPath next = make_path({{100, 0}, {160, 0}}, {2, 3}, {.osm_id = 2, .highway = "secondary", .width_m = 7.2});
  next.sidewalk = Sides::both;
  const NetworkResult result = build_network(network_of({path, next}));
  const Road &road = road_of(result.map, "1"), &other = road_of(result.map, "2");
  ASSERT_EQ(road.sections[0].left.size(), 2u);
  ASSERT_EQ(road.sections[0].right.size(), 2u);
  EXPECT_EQ(road.sections[0].left[1].type, LaneType::sidewalk);
  EXPECT_EQ(road.sections[0].right[1].type, LaneType::shoulder);
  EXPECT_NEAR(roadquery::road_edges(road, 40.0).left_t, 3.6 + 2.0, 1e-6);
  EXPECT_NEAR(roadquery::road_edges(road, 40.0).right_t, -3.6, 1e-6) << "the width counts all of the asphalt";
  EXPECT_NEAR(roadquery::lane_width(road.sections[0].right[1], 40.0), 1.2, 1e-6);
  EXPECT_EQ(road.sections[0].left[1].successor, 2);
  EXPECT_FALSE(road.sections[0].right[1].successor) << "a shoulder does not become a walk";
  EXPECT_NEAR(roadquery::lane_width(road.sections[0].right[1], road.length), 0.0, 1e-9)
      << "it ends before the other road";
  EXPECT_FALSE(other.sections[0].right[1].predecessor);
  EXPECT_EQ(network::lanes_of_direction(road, true), std::vector<int>{-1}) << "nobody drives on the shoulder";
}

TEST(Lanes, markings_and_speed_by_class_and_width) {
  const auto build = [](const std::string& highway, double width_m, int lanes = 0) {
    return build_network(network_of({make_path({{0, 0}, {100, 0}}, {1, 2},
                                               {.highway = highway, .width_m = width_m, .lanes = lanes})}))
        .map.roads.at(0);
  };
  Road road = build("primary", 7.0);
  EXPECT_EQ(road.sections[0].center.marks.at(0).type, "broken");
  EXPECT_EQ(road.sections[0].right[0].marks.at(0).type, "solid");
  EXPECT_NEAR(road.speed_limit_mps, 50.0 / 3.6, 1e-9);
  road = build("tertiary", 5.0);
  EXPECT_EQ(road.sections[0].center.marks.at(0).type, "none") << "too narrow";
  EXPECT_EQ(road.sections[0].right[0].marks.at(0).type, "none");
  road = build("residential", 7.0);
  EXPECT_EQ(road.sections[0].center.marks.at(0).type, "none");
  road = build("trunk", 15.0, 4);
  EXPECT_EQ(road.sections[0].center.marks.at(0).type, "solid") << "two lanes each way";
  EXPECT_EQ(road.sections[0].right[0].marks.at(0).type, "broken");
  RoadPath tagged = make_path({{0, 0}, {100, 0}}, {1, 2});
  tagged.speed_limit_kmh = 30.0;
  EXPECT_NEAR(build_network(network_of({tagged})).map.roads.at(0).speed_limit_mps, 30.0 / 3.6, 1e-9);
}

/// A crossing of way 1 (from the west, with `lanes` forward lanes), 2 (to the east), 3 (north) and 4 (south).
RoadNetwork marked_crossing(const std::string& arrows, int lanes) {
  RoadPath west = make_path({{-100, 0}, {0, 0}}, {1, 9},
                            {.osm_id = 1, .highway = "primary", .width_m = 3.5 * (lanes + 1), .lanes = lanes + 1});
  west.lanes_forward = lanes, west.lanes_backward = 1, west.turn_forward = arrows;
  return network_of({west, make_path({{0, 0}, {100, 0}}, {9, 2}, {.osm_id = 2, .highway = "primary", .width_m = 7.0}),
                     make_path({{0, 0}, {0, 100}}, {9, 3}, {.osm_id = 3}),
                     make_path({{0, 0}, {0, -100}}, {9, 4}, {.osm_id = 4})});
}

TEST(TurnLanes, arrows_give_each_turn_its_lanes) {
  const NetworkResult result = build_network(marked_crossing("left|through|right", 3));
  expect_sound(result.map);
  const auto lane_of = [&](const std::string& to) {
    const auto roads = movements(result.map, "1", to);
    EXPECT_EQ(roads.size(), 1u) << to;
    EXPECT_EQ(roads.at(0)->sections[0].right.size(), 1u) << to;
    return roads.at(0)->sections[0].right[0].predecessor;
  };
  EXPECT_EQ(lane_of("3"), -1) << "left";
  EXPECT_EQ(lane_of("2"), -2);
  EXPECT_EQ(lane_of("4"), -3) << "right";
}

TEST(TurnLanes, without_arrows_all_lanes_go_straight_on) {
  const NetworkResult result = build_network(marked_crossing("", 2));
  expect_sound(result.map);
  ASSERT_EQ(movements(result.map, "1", "2").size(), 1u);
  const auto& lanes = movements(result.map, "1", "2")[0]->sections[0].right;
  ASSERT_EQ(lanes.size(), 2u);
  EXPECT_EQ(lanes[1].predecessor, -2);
  EXPECT_FALSE(lanes[1].successor) << "it ends";
  EXPECT_EQ(movements(result.map, "1", "4").at(0)->sections[0].right[0].predecessor, -2);
}

TEST(TurnLanes, every_lane_out_of_a_junction_is_fed) {
  RoadNetwork roads = marked_crossing("", 1);
  roads.paths[1].lanes = 5, roads.paths[1].lanes_forward = 4, roads.paths[1].lanes_backward = 1;
  for (RoadNode& node : roads.paths[1].nodes) node.width_m = 17.5;
  const NetworkResult result = build_network(roads);
  expect_sound(result.map);
  std::set<int> fed;
  for (const Road* road : connecting_roads(result.map))
    if (road_by_id(result.map, road->successor.id)->osm_id == "2")
      for (const Lane& lane : road->sections[0].right)
        if (lane.predecessor && lane.successor) fed.insert(*lane.successor);
  EXPECT_EQ(fed, (std::set<int>{-1, -2, -3, -4}));
}

TEST(TurnRestrictions, forbidden_turns_have_no_road) {
  RoadNetwork roads = marked_crossing("", 1);
  EXPECT_EQ(movements(build_network(roads).map, "1", "3").size(), 1u);
  roads.restrictions = {{1, 9, 3, false}};
  roadquery::RoadMap map = build_network(roads).map;
  expect_sound(map);
  EXPECT_EQ(movements(map, "1", "3").size(), 0u);
  EXPECT_EQ(movements(map, "1", "2").size(), 1u);
  EXPECT_EQ(movements(map, "4", "3").size(), 1u) << "others may";
  roads.restrictions = {{1, 9, 4, true}};
  map = build_network(roads).map;
  EXPECT_EQ(movements(map, "1", "4").size(), 1u);
  EXPECT_EQ(movements(map, "1", "2").size() + movements(map, "1", "3").size(), 0u);
  roads.restrictions = {{1, 7, 3, false}, {5, 9, 3, false}};
  EXPECT_EQ(movements(build_network(roads).map, "1", "3").size(), 1u) << "another node, another way";
}

TEST(TurnRestrictions, count_at_their_node_of_a_joined_junction_alone) {
  // Two crossings 3 m apart: way 5 between them lies inside of one junction.
  RoadNetwork roads = network_of(
      {make_path({{-100, 0}, {0, 0}}, {1, 9}, {.osm_id = 1}), make_path({{0, 0}, {3, 0}}, {9, 10}, {.osm_id = 5}),
       make_path({{3, 0}, {100, 0}}, {10, 2}, {.osm_id = 2}), make_path({{0, 0}, {0, 100}}, {9, 3}, {.osm_id = 3}),
       make_path({{3, 0}, {3, -100}}, {10, 4}, {.osm_id = 4})});
  ASSERT_EQ(build_network(roads).map.junctions.size(), 1u);
  const auto ways_on = [&](const TurnRestriction& restriction) {
    roads.restrictions = {restriction};
    const roadquery::RoadMap map = build_network(roads).map;
    std::string ways;
    for (const char* way : {"2", "3", "4"})
      if (!movements(map, "1", way).empty()) ways += way;
    return ways;
  };
  EXPECT_EQ(ways_on({1, 9, 5, true}), "24") << "straight on at the first, then as one likes";
  EXPECT_EQ(ways_on({1, 9, 5, false}), "3") << "not to the second at all";
  EXPECT_EQ(ways_on({5, 10, 4, false}), "23") << "what is forbidden after the way between";
}

TEST(Movements, nobody_turns_round_inside_a_joined_junction) {
  // Way 5 lies inside of one junction. Way 3 comes to its far end from behind, so that from there the near end, with
  // way 4, is reached by turning round alone: though between both roads' ends it is a turn of 70 degrees.
  const double back = 160.0 * M_PI / 180.0;
  const roadquery::RoadMap map =
      build_network(
          network_of({make_path({{-100, 0}, {0, 0}}, {1, 9}, {.osm_id = 1}),
                      make_path({{0, 0}, {8, 0}}, {9, 10}, {.osm_id = 5}),
                      make_path({{8, 0}, {100, 0}}, {10, 2}, {.osm_id = 2}),
                      make_path({{8, 0}, {8 + 120 * std::cos(back), 120 * std::sin(back)}}, {10, 3}, {.osm_id = 3}),
                      make_path({{0, 0}, {0, -100}}, {9, 4}, {.osm_id = 4})}))
          .map;
  ASSERT_EQ(map.junctions.size(), 1u);
  EXPECT_EQ(movements(map, "3", "2").size(), 1u);
  EXPECT_EQ(movements(map, "2", "3").size(), 1u);
  EXPECT_EQ(movements(map, "1", "4").size(), 1u);
  EXPECT_EQ(movements(map, "2", "4").size(), 1u);
  EXPECT_EQ(movements(map, "4", "2").size(), 1u);
  EXPECT_EQ(movements(map, "3", "4").size(), 0u);
  EXPECT_EQ(movements(map, "4", "3").size(), 0u);
}

/// A ring of four one-way ways with an arm each, counter-clockwise; `tagged` as roundabout. `gap_rad` of the last one
/// is left out.
RoadNetwork ring_with_arms(bool tagged, double gap_rad = 0.0, double turn = 1.0, double radius_m = 15.0) {
  std::vector<RoadPath> paths;
  for (int i = 0; i < 4; ++i) {
    const double from = turn * i * M_PI / 2.0, sweep = turn * (M_PI / 2.0 - (i == 3 ? gap_rad : 0.0));
    std::vector<Vec2> points = circle_points({0, 0}, radius_m, from, sweep);
    std::vector<std::int64_t> ids(points.size(), 0);
    ids.front() = i + 1, ids.back() = gap_rad > 0.0 && i == 3 ? 99 : (i + 1) % 4 + 1;
    paths.push_back(make_path(
        points, ids, {.osm_id = 10 + i, .width_m = 5.0, .oneway = Oneway::forward, .lanes = 1, .roundabout = tagged}));
    const Vec2 out{std::cos(from), std::sin(from)};
    paths.push_back(make_path({out * radius_m, out * 80.0}, {i + 1, i + 50}, {.osm_id = 20 + i}));
  }
  return network_of(std::move(paths));
}

void expect_ring(const roadquery::RoadMap& map, double radius_m) {
  expect_sound(map);
  EXPECT_EQ(map.junctions.size(), 4u);
  double length = 0.0;
  for (const Road& road : map.roads) {
    const bool ring = road.junction < 0 && road.osm_id.starts_with('1');
    // Round through a junction: in from a way of the ring, out into one.
    const bool through = road.junction >= 0 && road_by_id(map, road.predecessor.id)->osm_id.starts_with('1') &&
                         road_by_id(map, road.successor.id)->osm_id.starts_with('1');
    if (!ring && !through) continue;
    length += road.length;
    for (double s = 0.0; s <= road.length; s += 0.5)
      EXPECT_NEAR(std::abs(roadquery::reference_point(road, s).curvature), 1.0 / radius_m, 0.01 / radius_m + 0.02)
          << road.osm_id;
  }
  EXPECT_NEAR(length, 2.0 * M_PI * radius_m, 0.3);
  for (int i = 0; i < 4; ++i) {  // in and out of every arm
    int in = 0, out = 0;
    for (const Road* road : connecting_roads(map)) {
      in += road_by_id(map, road->predecessor.id)->osm_id == std::to_string(20 + i) ? 1 : 0;
      out += road_by_id(map, road->successor.id)->osm_id == std::to_string(20 + i) ? 1 : 0;
    }
    EXPECT_EQ(in, 1) << i;
    EXPECT_EQ(out, 1) << i;
  }
}

TEST(Roundabout, of_four_ways_is_one_smooth_circle) {
  expect_ring(build_network(ring_with_arms(true)).map, 15.0);
  expect_ring(build_network(ring_with_arms(false)).map, 15.0);  // nothing says so but its form
}

TEST(Roundabout, that_bends_towards_its_arms_is_smoothed) {
  // Refinement draws the ring half a metre outwards where an arm touches it.
  RoadNetwork roads = ring_with_arms(false);
  for (RoadPath& path : roads.paths)
    for (RoadNode& node : path.nodes)
      if (node.osm_node > 0 && node.osm_node < 50) node.p = site_origin + (node.p - site_origin) * (15.5 / 15.0);
  expect_ring(build_network(roads).map, 15.06);
}

TEST(Roundabout, is_told_by_its_form_and_sense) {
  Findings findings;
  const auto rings = [&](const RoadNetwork& roads, DrivingSide driving_side) {
    const network::Topology topology = network::build_topology(roads, driving_side, findings);
    return *std::max_element(topology.ring_of_piece.begin(), topology.ring_of_piece.end()) + 1;
  };
  EXPECT_EQ(rings(ring_with_arms(false), DrivingSide::right), 1);
  EXPECT_EQ(rings(ring_with_arms(false), DrivingSide::left), 0) << "driven the wrong way round";
  EXPECT_EQ(rings(ring_with_arms(false, 0.0, -1.0), DrivingSide::left), 1);
  EXPECT_EQ(rings(ring_with_arms(false, 0.0, 1.0, 90.0), DrivingSide::right), 0) << "a one-way ring road";
  std::vector<RoadPath> block;
  const Vec2 corner[] = {{0, 0}, {60, 0}, {60, 60}, {0, 60}};
  block.reserve(4);
  for (int i = 0; i < 4; ++i)
    block.push_back(make_path({corner[i], corner[(i + 1) % 4]}, {i + 1, (i + 1) % 4 + 1},
                              {.osm_id = i + 1, .oneway = Oneway::forward}));
  EXPECT_EQ(rings(network_of(block), DrivingSide::right), 0) << "one-way streets round a block";
}

TEST(Roundabout, against_the_traffic_is_told) {
  const auto told = [](const RoadNetwork& roads, DrivingSide driving_side) {
    return findings_of(build_network(roads, {.driving_side = driving_side}), "network.roundabout_against_traffic");
  };
  EXPECT_EQ(told(ring_with_arms(true), DrivingSide::right), 0);
  EXPECT_EQ(told(ring_with_arms(true), DrivingSide::left), 1);
  EXPECT_EQ(told(ring_with_arms(true, 0.0, -1.0), DrivingSide::right), 1);
  EXPECT_EQ(told(ring_with_arms(false), DrivingSide::left), 0) << "no roundabout by its tags";
}

TEST(Roundabout, that_is_not_closed_is_closed_along_its_circle) {
  const NetworkResult result = build_network(ring_with_arms(true, 0.5));
  EXPECT_EQ(findings_of(result, "network.roundabout_closed"), 1);
  expect_ring(result.map, 15.0);
  const NetworkResult half = build_network(ring_with_arms(true, 1.5));  // a quarter is missing: still one
  EXPECT_EQ(findings_of(half, "network.roundabout_closed"), 1);
  RoadNetwork bent =
      network_of({make_path({{0, 0}, {40, 0}, {60, 30}}, {1, 2, 3}, {.oneway = Oneway::forward, .roundabout = true})});
  const NetworkResult open = build_network(bent);
  EXPECT_EQ(findings_of(open, "network.roundabout_open"), 1);
  expect_sound(open.map);
  EXPECT_EQ(open.map.roads.size(), 1u);
}

TEST(Roundabout, of_two_lanes_is_left_from_the_outer_one) {
  RoadNetwork roads = ring_with_arms(true);
  for (RoadPath& path : roads.paths)
    if (path.roundabout) {
      path.lanes = 2;
      for (RoadNode& node : path.nodes) node.width_m = 8.0;
    }
  const NetworkResult result = build_network(roads);
  expect_sound(result.map);
  int exits = 0;
  for (const roadquery::Junction& junction : result.map.junctions)
    for (const roadquery::Connection& connection : junction.connections) {
      const roadquery::Road& road = *road_by_id(result.map, connection.connecting_road);
      const roadquery::Road &from = *road_by_id(result.map, connection.incoming_road),
                            &to = *road_by_id(result.map, road.successor.id);
      if (from.osm_id != to.osm_id && std::stoi(from.osm_id) < 20 && std::stoi(to.osm_id) >= 20) {
        ++exits;
        for (const roadquery::LaneLink& link : connection.lane_links) EXPECT_EQ(link.from, -2) << "the outer lane";
      }
    }
  EXPECT_EQ(exits, 4);
}

TEST(Roundabout, of_two_way_roads_is_assumed_where_it_is_a_circle_with_arms) {
  RoadNetwork roads = ring_with_arms(false);
  for (RoadPath& path : roads.paths) path.oneway = Oneway::no;
  RoadPath& turned = roads.paths[4];  // one of its ways runs the other way round
  const double length = turned.nodes.back().s_m;
  std::reverse(turned.nodes.begin(), turned.nodes.end());
  for (RoadNode& node : turned.nodes) node.s_m = length - node.s_m;
  const NetworkResult result = build_network(roads);
  EXPECT_EQ(findings_of(result, "network.roundabout_assumed"), 1);
  expect_ring(result.map, 15.0);
  // Two arms are a lay-by, and a block's corners are no circle.
  roads.paths.erase(roads.paths.begin() + 7);
  roads.paths.erase(roads.paths.begin() + 5);
  EXPECT_EQ(findings_of(build_network(roads), "network.roundabout_assumed"), 0);
  std::vector<RoadPath> block;
  const Vec2 corner[] = {{0, 0}, {40, 0}, {40, 40}, {0, 40}};
  block.reserve(4);
  for (int i = 0; i < 4; ++i) {
    block.push_back(make_path({corner[i], corner[(i + 1) % 4]}, {i + 1, (i + 1) % 4 + 1}, {.osm_id = i + 1}));
    block.push_back(make_path({corner[i], corner[i] * 3.0 - Vec2{40, 40}}, {i + 1, i + 11}, {.osm_id = i + 11}));
  }
  EXPECT_EQ(findings_of(build_network(network_of(block)), "network.roundabout_assumed"), 0);
}

TEST(Junction, of_nine_roads_connects_them_all) {
  std::vector<RoadPath> arms;
  for (int i = 0; i < 9; ++i) {
    const double angle = 2.0 * M_PI * i / 9.0;
    arms.push_back(make_path({{0, 0}, Vec2{std::cos(angle), std::sin(angle)} * 90.0}, {1, i + 10}, {.osm_id = i + 1}));
  }
  const NetworkResult result = build_network(network_of(arms));
  expect_sound(result.map);
  EXPECT_EQ(result.map.junctions.size(), 1u);
  EXPECT_EQ(plain_roads(result.map).size(), 9u);
  // 40 degrees from road to road: the sharpest turn is one of 140.
  EXPECT_EQ(connecting_roads(result.map).size(), 9u * 8u);
}

TEST(Junction, higher_class_goes_first) {
  const NetworkResult result = build_network(marked_crossing("", 1));
  ASSERT_EQ(result.map.junctions.size(), 1u);
  const auto& priorities = result.map.junctions[0].priorities;
  ASSERT_FALSE(priorities.empty());
  for (const roadquery::Priority& p : priorities) {
    EXPECT_EQ(road_by_id(result.map, road_by_id(result.map, p.high)->predecessor.id)->highway, "primary");
    EXPECT_EQ(road_by_id(result.map, road_by_id(result.map, p.low)->predecessor.id)->highway, "residential");
  }
}

TEST(RoadCuts, no_two_roads_join_the_same_two_junctions) {
  // A block with two ways round it, and a loop that comes back to its own junction.
  const NetworkResult result =
      build_network(network_of({make_path({{-80, 0}, {0, 0}, {100, 0}, {180, 0}}, {1, 2, 3, 4}),
                                make_path({{0, 0}, {0, 40}, {100, 40}, {100, 0}}, {2, 0, 0, 3}, {.osm_id = 2}),
                                make_path({{180, 0}, {200, 40}, {240, 40}, {240, -40}, {200, -40}, {180, 0}},
                                          {4, 0, 0, 0, 0, 4}, {.osm_id = 3})}));
  expect_sound(result.map);
  std::set<std::pair<int, int>> pairs;
  for (const Road* road : plain_roads(result.map)) {
    if (road->predecessor.kind != roadquery::LinkKind::junction ||
        road->successor.kind != roadquery::LinkKind::junction)
      continue;
    const auto pair = std::minmax(road->predecessor.id, road->successor.id);
    EXPECT_NE(pair.first, pair.second) << road->osm_id;
    EXPECT_TRUE(pairs.insert(pair).second) << road->osm_id;
  }
}

TEST(RoadCuts, junctions_are_one_where_only_roads_on_each_other_would_part_them) {
  // A bay of a bus stop beside a street, mapped as a way of its own.
  const auto junctions = [](double length_m, double aside_m) {
    return build_network(
               network_of({make_path({{-80, 0}, {0, 0}, {length_m, 0}, {length_m + 80, 0}}, {1, 2, 3, 4}),
                           make_path({{0, 0}, {0.5 * length_m, aside_m}, {length_m, 0}}, {2, 0, 3}, {.osm_id = 2})}))
        .map.junctions.size();
  };
  EXPECT_EQ(junctions(46.0, 4.0), 1u) << "a metre of street on a metre of bay";
  EXPECT_EQ(junctions(46.0, 25.0), 2u) << "they part";
  EXPECT_EQ(junctions(90.0, 4.0), 2u) << "too far from each other";
}

TEST(RoadCuts, ways_do_not_change_in_a_bend) {
  // Two ways meet in the corner of a street.
  std::vector<Vec2> first{{0, 0}}, second;
  for (const Vec2 p : circle_points({40, 8}, 8.0, -M_PI / 2.0, M_PI / 2.0)) (p.x < 45.6 ? first : second).push_back(p);
  second.insert(second.begin(), first.back());
  second.push_back({48, 60});
  std::vector<std::int64_t> ids(first.size(), 0);
  ids.front() = 1, ids.back() = 2;
  const NetworkResult result =
      build_network(network_of({make_path(first, ids), make_path(second, {2}, {.osm_id = 2})}));
  expect_sound(result.map);
  ASSERT_EQ(result.map.roads.size(), 2u);
  // 8 m of radius fit in the corner: outside it, or at its end.
  const Road& road = result.map.roads[0];
  const auto heading = [&](double before_end_m) {
    return roadquery::reference_point(road, road.length - before_end_m).hdg;
  };
  EXPECT_LT(std::abs(std::remainder(heading(0.0) - heading(3.0), 2.0 * M_PI)), 0.2);
}

TEST(RoadCuts, end_where_an_element_ends_if_that_is_near) {
  // Straight, then a wide bend that begins 8 m from the crossing: a cut through its first metre would make an element
  // more.
  std::vector<Vec2> line{{-100, 0}, {0, 0}};
  for (const Vec2 p : circle_points({8.0, 60.0}, 60.0, -M_PI / 2.0, 1.2)) line.push_back(p);
  std::vector<std::int64_t> ids(line.size(), 0);
  ids[0] = 1, ids[1] = 2, ids.back() = 3;
  const NetworkResult result = build_network(
      network_of({make_path(line, ids), make_path({{0, -60}, {0, 0}, {0, 60}}, {4, 2, 5}, {.osm_id = 2})}));
  expect_sound(result.map);
  for (const Road* road : plain_roads(result.map))
    for (const roadquery::PlanElement& e : road->plan) EXPECT_GT(e.length, 2.0) << road->osm_id;
}

TEST(RoadCuts, divided_slivers_look_smooth_to_readers_of_polylines) {
  using roadquery::Arc, roadquery::PlanElement;
  const std::vector<PlanElement> end_of_bend{{.length = 8.2, .shape = Arc{0.05}}};  // samples at 0, 2, .. 8 and 8.2
  const auto parts = network::divide_slivers(end_of_bend, 0.0);
  ASSERT_EQ(parts.size(), 2u);
  EXPECT_NEAR(std::fmod(parts[0].length, 2.0), 1.1, 1e-12);
  EXPECT_NEAR(parts[1].length, 1.1, 1e-12);
  for (const double s : {0.0, 3.3, 7.09, 7.11, 8.2}) {
    const Vec2 a = network::pose_at(end_of_bend, s).p, b = network::pose_at(parts, s).p;
    EXPECT_NEAR(distance(a, b), 0.0, 1e-9);
  }
  EXPECT_EQ(network::divide_slivers({{.length = 9.5, .shape = Arc{0.12}}}, 0.0).size(), 1u) << "a long rest";
  EXPECT_EQ(network::divide_slivers({{.length = 8.2, .shape = Arc{0.01}}}, 0.0).size(), 1u) << "hardly a bend";
  EXPECT_EQ(network::divide_slivers({{.length = 8.2, .shape = roadquery::Line{}}}, 0.0).size(), 1u);
  const std::vector<PlanElement> bend{{.length = 8.2, .shape = Arc{0.12}},
                                      {.s = 8.2, .length = 7.6, .shape = roadquery::Line{}}};
  EXPECT_EQ(network::divide_slivers(bend, 3.0).size(), 3u) << "lanes 3 m inside the bend turn round in 0.2 m";
  EXPECT_EQ(network::divide_slivers(bend, -3.0).size(), 2u) << "outside it they do not";
}

TEST(LaneLayout, a_car_fits_into_every_lane) {
  const NetworkResult result = build_network(
      network_of({make_path({{0, 0}, {60, 0}}, {1, 2}, {.osm_id = 1, .width_m = 2.0}),
                  make_path({{0, 30}, {60, 30}}, {3, 4}, {.osm_id = 2, .width_m = 3.9}),
                  make_path({{0, 60}, {60, 60}}, {5, 6}, {.osm_id = 3, .width_m = 2.0, .oneway = Oneway::forward})}));
  EXPECT_EQ(findings_of(result, "network.widened"), 1) << "3.9 m and a one-way road of 2 m are near enough";
  for (const Road* road : plain_roads(result.map))
    for (const auto* side : {&road->sections[0].left, &road->sections[0].right})
      for (const Lane& lane : *side)
        EXPECT_NEAR(roadquery::lane_width(lane, 10.0), road->osm_id == "3" ? 2.2 : 2.05, 1e-6);
}

TEST(Lanes, carriageways_are_multiples_of_a_centimetre_wide_where_pieces_of_their_width_end) {
  RoadNetwork roads = network_of({make_path({{0, 0}, {160, 0}}, {1, 2}, {.osm_id = 1})});
  for (RoadNode& node : roads.paths[0].nodes) node.width_m = 6.0371 + 0.8 * std::sin(node.s_m / 20.0);
  const roadquery::RoadMap map = build_network(roads).map;
  const Road& road = road_of(map, "1");
  const roadquery::LaneSection& section = road.sections.front();
  ASSERT_GT(section.left.at(0).width.size(), 3u);
  std::vector<double> ends{road.length};
  for (const roadquery::Cubic& piece : section.left.at(0).width) ends.push_back(piece.s);
  for (const double s : ends) {
    const double width = roadquery::lane_width(section.left.at(0), s) + roadquery::lane_width(section.right.at(0), s);
    EXPECT_NEAR(100.0 * width, std::round(100.0 * width), 1e-7) << s;
    EXPECT_NEAR(width, 6.0371 + 0.8 * std::sin(s / 20.0), 0.06) << s;
  }
}

TEST(LaneLayout, three_lanes_on_four_metres_are_told) {
  const NetworkResult result =
      build_network(network_of({make_path({{0, 0}, {60, 0}}, {1, 2}, {.width_m = 4.0, .lanes = 3})}));
  expect_sound(result.map);
  EXPECT_EQ(findings_of(result, "network.too_many_lanes"), 1);
  EXPECT_EQ(result.map.roads.at(0).sections[0].left.size() + result.map.roads[0].sections[0].right.size(), 2u);
}

TEST(Junction, narrow_branch_of_a_wide_road_overlaps_none_of_it) {
  // A slip road leaves the middle of a 10 m wide road at 7 degrees: its edges reach those of the wide road 40 m on.
  const NetworkResult result = build_network(
      network_of({make_path({{-100, 0}, {0, 0}, {200, 0}}, {1, 2, 3},
                            {.highway = "primary", .width_m = 10.0, .oneway = Oneway::forward}),
                  make_path({{0, 0}, {150, 18}}, {2, 4},
                            {.osm_id = 2, .highway = "primary_link", .width_m = 3.5, .oneway = Oneway::forward})}));
  expect_sound(result.map);
  const Road& branch = road_of(result.map, "2");
  for (const Road* road : plain_roads(result.map)) {
    if (road->osm_id != "1" || roadquery::reference_point(*road, 0.0).x < site_origin.x) continue;
    const roadquery::SurfacePoint begin = roadquery::surface_point(*road, 0.0, 0.0);
    // Beside the end of the connecting road, not under it.
    EXPECT_GT(begin.x - site_origin.x, 30.0);
    EXPECT_GT(roadquery::reference_point(branch, 0.0).x - site_origin.x, 30.0);
  }
}

TEST(Junction, sharp_turn_stays_where_nothing_else_leads_into_a_road) {
  // A carriageway of a divided road begins where the other one ends: one turns round, or never gets there.
  const auto network = [](bool other_way) {
    std::vector<RoadPath> paths{make_path({{100, 5}, {0, 0}}, {1, 2}, {.osm_id = 1, .oneway = Oneway::forward}),
                                make_path({{0, 0}, {-60, 0}}, {2, 3}, {.osm_id = 2, .oneway = Oneway::forward}),
                                make_path({{0, 0}, {100, -5}}, {2, 4}, {.osm_id = 3, .oneway = Oneway::forward})};
    if (other_way) paths.push_back(make_path({{0, -60}, {0, 0}}, {5, 2}, {.osm_id = 4, .oneway = Oneway::forward}));
    return network_of(paths);
  };
  const NetworkResult alone = build_network(network(false));
  expect_sound(alone.map);
  EXPECT_EQ(movements(alone.map, "1", "3").size(), 1u);
  EXPECT_EQ(movements(build_network(network(true)).map, "1", "3").size(), 0u);
}

}  // namespace
}  // namespace orthodrive
