// SPDX-License-Identifier: Apache-2.0
// Hand-made networks, small enough to draw.

#include "orthodrive/network/build_network.hpp"

#include "network_support.hpp"

namespace orthodrive {
namespace {

using namespace orthodrive::network_test;
using roadquery::Arc;
using roadquery::ContactPoint;
using roadquery::LinkKind;
using roadquery::Road;

int count_findings(const NetworkResult& result, const std::string& code) {
  return static_cast<int>(std::count_if(result.findings.begin(), result.findings.end(),
                                        [&](const Finding& finding) { return finding.code == code; }));
}

double slope_height(Vec2 p) { return 50.0 + 0.03 * p.x + 0.01 * p.y; }

TEST(BuildNetwork, no_paths_give_an_empty_map) {
  const NetworkResult result = build_network(network_of({}));
  EXPECT_TRUE(result.map.roads.empty());
  EXPECT_TRUE(result.findings.empty());
}

TEST(BuildNetwork, straight_road) {
  RoadPath path = make_path({{0, 0}, {100, 0}}, {1, 2}, {.osm_id = 77, .highway = "tertiary", .width_m = 7.0});
  path.name = "High Street";
  const NetworkResult result = build_network(network_of({path}));
  expect_sound(result.map);
  ASSERT_EQ(result.map.roads.size(), 1u);
  const Road& road = result.map.roads[0];
  EXPECT_NEAR(road.length, 100.0, 1e-6);
  EXPECT_EQ(road.plan.size(), 1u);
  EXPECT_TRUE(std::holds_alternative<roadquery::Line>(road.plan[0].shape));
  EXPECT_EQ(road.name, "High Street");
  EXPECT_EQ(road.osm_id, "77");
  EXPECT_EQ(road.predecessor.kind, LinkKind::none);
  EXPECT_EQ(road.successor.kind, LinkKind::none);
  const roadquery::Edges edges = roadquery::road_edges(road, 40.0);
  EXPECT_NEAR(edges.left_t, 3.5, 1e-9);
  EXPECT_NEAR(edges.right_t, -3.5, 1e-9);
  EXPECT_EQ(road.sections[0].left.size(), 1u);
  EXPECT_EQ(road.sections[0].center.marks[0].type, "broken");
  EXPECT_EQ(road.sections[0].right[0].marks[0].type, "solid");
  EXPECT_EQ(count_findings(result, "network.no_heights"), 1);  // it has none: it lies at z = 0
  EXPECT_EQ(roadquery::elevation(road, 50.0), 0.0);
  EXPECT_LT(result.map.west, site_origin.x);
  EXPECT_GT(result.map.east, site_origin.x + 100.0);
  EXPECT_NE(result.map.geo_reference.find("+proj=utm"), std::string::npos);
}

TEST(BuildNetwork, arc_of_known_radius_with_height_and_banking) {
  const std::vector<Vec2> points = circle_points({0.0, 80.0}, 80.0, -M_PI / 2.0, 1.5);
  PathOptions options{.height = slope_height, .banking = [](double s) { return 0.04 * std::sin(s / 30.0); }};
  const NetworkResult result = build_network(network_of({make_path(points, {1}, options)}));
  expect_sound(result.map);
  EXPECT_TRUE(result.findings.empty());
  ASSERT_EQ(result.map.roads.size(), 1u);
  const Road& road = result.map.roads[0];
  for (const roadquery::PlanElement& e : road.plan) {
    ASSERT_TRUE(std::holds_alternative<Arc>(e.shape));
    EXPECT_NEAR(std::get<Arc>(e.shape).curvature, 1.0 / 80.0, 1e-6);
  }
  for (double s = 0.0; s <= road.length; s += 3.0) {
    const roadquery::PlanPoint q = roadquery::reference_point(road, s);
    EXPECT_NEAR(std::hypot(q.x - site_origin.x, q.y - site_origin.y - 80.0), 80.0, 1e-6);
    EXPECT_NEAR(roadquery::elevation(road, s), slope_height({q.x - site_origin.x, q.y - site_origin.y}), 0.025);
    EXPECT_NEAR(roadquery::superelevation(road, s), 0.04 * std::sin(s / 30.0), 0.0025);
  }
}

TEST(BuildNetwork, width_follows_the_nodes) {
  RoadPath path = make_path({{0, 0}, {200, 0}}, {1, 2});
  const auto width = [](double s) { return 6.0 + 1.5 * std::tanh((s - 100.0) / 15.0); };
  for (RoadNode& node : path.nodes) node.width_m = width(node.s_m);
  const NetworkResult result = build_network(network_of({path}));
  const Road& road = result.map.roads.at(0);
  for (double s = 0.0; s <= road.length; s += 2.0) {
    const roadquery::Edges edges = roadquery::road_edges(road, s);
    EXPECT_NEAR(edges.left_t - edges.right_t, width(s), 0.06);
    EXPECT_NEAR(edges.left_t + edges.right_t, 0.0, 1e-9);
  }
  EXPECT_LT(road.sections[0].right[0].width.size(), 15u);
}

TEST(BuildNetwork, one_way_road_is_centred_on_its_reference_line) {
  const NetworkResult result = build_network(
      network_of({make_path({{0, 0}, {60, 10}}, {1, 2}, {.width_m = 8.0, .oneway = Oneway::forward, .lanes = 2})}));
  expect_sound(result.map);
  const Road& road = result.map.roads.at(0);
  EXPECT_TRUE(road.sections[0].left.empty());
  ASSERT_EQ(road.sections[0].right.size(), 3u);
  EXPECT_EQ(road.sections[0].right[2].type, roadquery::LaneType::parking) << "two lanes of a street leave room for it";
  const roadquery::Edges edges = roadquery::road_edges(road, 10.0);
  EXPECT_NEAR(edges.left_t, 4.0, 1e-9);
  EXPECT_NEAR(edges.right_t, -4.0, 1e-9);
}

TEST(BuildNetwork, odd_lane_gets_to_the_forward_side_and_edges_stay_centred) {
  const NetworkResult result = build_network(
      network_of({make_path({{0, 0}, {60, 0}}, {1, 2}, {.highway = "primary", .width_m = 9.0, .lanes = 3})}));
  const Road& road = result.map.roads.at(0);
  EXPECT_EQ(road.sections[0].left.size(), 1u);
  EXPECT_EQ(road.sections[0].right.size(), 2u);
  EXPECT_NEAR(roadquery::evaluate(road.lane_offset, 5.0), 1.5, 1e-9);
  EXPECT_NEAR(roadquery::road_edges(road, 5.0).left_t, 4.5, 1e-9);
  EXPECT_NEAR(roadquery::road_edges(road, 5.0).right_t, -4.5, 1e-9);
}

TEST(BuildNetwork, left_hand_traffic_drives_on_the_left) {
  const NetworkResult result =
      build_network(network_of({make_path({{0, 0}, {60, 0}}, {1, 2}, {.oneway = Oneway::forward}),
                                make_path({{60, 0}, {120, 0}}, {2, 3}, {.osm_id = 2}),
                                make_path({{60, 0}, {60, 50}}, {2, 4}, {.osm_id = 3})}),
                    {.driving_side = DrivingSide::left});
  expect_sound(result.map);
  for (const Road& road : result.map.roads) {
    EXPECT_EQ(road.driving_side, DrivingSide::left);
    EXPECT_EQ(road.sections[0].right.empty(), road.osm_id == "1" || road.junction >= 0);
  }
}

TEST(BuildNetwork, t_junction) {
  const NetworkResult result = build_network(
      network_of({make_path({{-60, 0}, {0, 0}, {60, 0}}, {1, 2, 3}, {.width_m = 7.0, .height = slope_height}),
                  make_path({{0, 0}, {0, 50}}, {2, 4}, {.osm_id = 2, .width_m = 5.0, .height = slope_height})}));
  expect_sound(result.map);
  ASSERT_EQ(plain_roads(result.map).size(), 3u);
  ASSERT_EQ(result.map.junctions.size(), 1u);
  EXPECT_EQ(connecting_roads(result.map).size(), 6u);  // no U-turns
  for (const Road* road : plain_roads(result.map)) {
    EXPECT_TRUE((road->predecessor.kind == LinkKind::junction) != (road->successor.kind == LinkKind::junction));
    // The main road ends beyond the side road's edge, the side road beyond the main road's.
    EXPECT_LT(road->length, road->osm_id == "1" ? 60.0 - 2.5 : 50.0 - 3.5);
    EXPECT_GT(road->length, 50.0 - 10.0);
  }
  int straight = 0;
  for (const Road* road : connecting_roads(result.map)) {
    EXPECT_EQ(road->sections[0].left.size(), 0u);
    EXPECT_EQ(road->sections[0].right.size(), 1u);
    if (road->osm_id == "1") {
      ++straight;
      ASSERT_EQ(road->plan.size(), 1u);
      EXPECT_TRUE(std::holds_alternative<roadquery::Line>(road->plan[0].shape));
    }
  }
  EXPECT_EQ(straight, 2);
}

TEST(BuildNetwork, carriageways_of_an_oblique_crossing_do_not_overlap) {
  const NetworkResult result =
      build_network(network_of({make_path({{-80, 0}, {0, 0}, {80, 0}}, {1, 2, 3}, {.width_m = 8.0}),
                                make_path({{-70, -35}, {0, 0}, {70, 35}}, {4, 2, 5}, {.osm_id = 2, .width_m = 6.0})}));
  expect_sound(result.map);
  const auto roads = plain_roads(result.map);
  ASSERT_EQ(roads.size(), 4u);
  const auto inside = [](const Road& road, double x, double y) {
    for (double s = 0.0; s <= road.length; s += 0.25) {
      const roadquery::PlanPoint q = roadquery::reference_point(road, s);
      const double along = (x - q.x) * std::cos(q.hdg) + (y - q.y) * std::sin(q.hdg);
      const double t = (y - q.y) * std::cos(q.hdg) - (x - q.x) * std::sin(q.hdg);
      const roadquery::Edges edges = roadquery::road_edges(road, s);
      if (std::abs(along) < 0.13 && t < edges.left_t && t > edges.right_t) return true;
    }
    return false;
  };
  for (const Road* a : roads)
    for (const Road* b : roads)
      for (double s = 0.0; a != b && s <= a->length; s += 0.5)
        for (const double t : {roadquery::road_edges(*a, s).left_t, roadquery::road_edges(*a, s).right_t}) {
          const roadquery::SurfacePoint p = roadquery::surface_point(*a, s, t);
          EXPECT_FALSE(inside(*b, p.x, p.y)) << a->id << " in " << b->id << " at " << s;
        }
  // Of the eight sharp and blunt turns none goes back by more than 150 degrees.
  EXPECT_EQ(connecting_roads(result.map).size(), 8u);
}

TEST(BuildNetwork, crossing_of_two_ways_cut_at_the_junction) {
  std::vector<RoadPath> arms;
  const std::vector<Vec2> ends{{60, 0}, {0, 60}, {-60, 0}, {0, -60}};
  arms.reserve(ends.size());
  for (std::size_t i = 0; i < ends.size(); ++i)
    arms.push_back(
        make_path({ends[i], {0, 0}}, {static_cast<std::int64_t>(i) + 10, 5}, {.osm_id = static_cast<int>(i) + 1}));
  const NetworkResult result = build_network(network_of(arms));
  expect_sound(result.map);
  EXPECT_EQ(plain_roads(result.map).size(), 4u);
  EXPECT_EQ(connecting_roads(result.map).size(), 12u);
  int straight = 0;
  for (const Road* road : connecting_roads(result.map))
    straight += std::ranges::all_of(
        road->plan, [](const roadquery::PlanElement& e) { return std::holds_alternative<roadquery::Line>(e.shape); });
  EXPECT_EQ(straight, 4);
}

TEST(BuildNetwork, ways_that_meet_end_to_end_are_linked_in_any_direction) {
  // The second way runs against the first: its banking and its lanes change sides.
  PathOptions forward{.height = slope_height, .banking = [](double) { return 0.03; }};
  PathOptions against{.osm_id = 2, .height = slope_height, .banking = [](double) { return -0.03; }};
  const NetworkResult result = build_network(
      network_of({make_path({{0, 0}, {50, 0}}, {1, 2}, forward), make_path({{100, 5}, {50, 0}}, {3, 2}, against)}));
  expect_sound(result.map);
  ASSERT_EQ(result.map.roads.size(), 2u);
  EXPECT_TRUE(result.map.junctions.empty());
  const Road &a = result.map.roads[0], &b = result.map.roads[1];
  EXPECT_EQ(a.successor.kind, LinkKind::road);
  EXPECT_EQ(a.successor.id, b.id);
  EXPECT_EQ(a.successor.contact, ContactPoint::end);
  EXPECT_EQ(b.successor.id, a.id);
  EXPECT_EQ(a.sections[0].right[0].successor, 1);
  EXPECT_EQ(a.sections[0].left[0].successor, -1);
  EXPECT_NEAR(roadquery::superelevation(a, 25.0), 0.03, 1e-6);
  EXPECT_NEAR(roadquery::superelevation(b, 25.0), -0.03, 1e-6);
}

TEST(BuildNetwork, ends_that_do_not_quite_meet_are_joined_smoothly) {
  PathOptions low{.width_m = 5.0, .height = [](Vec2) { return 10.0; }};
  PathOptions high{.osm_id = 2, .width_m = 7.0, .height = [](Vec2) { return 10.4; }};
  const NetworkResult result = build_network(
      network_of({make_path({{0, 0}, {80, 0}}, {1, 2}, low), make_path({{80, 0.6}, {160, 0.6}}, {2, 3}, high)}));
  expect_sound(result.map);
  const Road& a = result.map.roads.at(0);
  EXPECT_NEAR(roadquery::elevation(a, a.length), 10.2, 1e-6);
  EXPECT_NEAR(roadquery::elevation(a, 40.0), 10.0, 0.021);
  EXPECT_NEAR(roadquery::road_edges(a, a.length).left_t, 3.0, 1e-6);
}

TEST(BuildNetwork, lanes_move_sideways_smoothly_where_a_two_way_road_becomes_one_way) {
  const NetworkResult result = build_network(
      network_of({make_path({{0, 0}, {80, 0}}, {1, 2}),
                  make_path({{80, 0}, {160, 0}}, {2, 3}, {.osm_id = 2, .oneway = Oneway::forward, .lanes = 1})}));
  expect_sound(result.map);
  ASSERT_EQ(connecting_roads(result.map).size(), 1u);
  const Road& road = *connecting_roads(result.map)[0];
  EXPECT_NEAR(road.length, 20.0, 1e-6);
  EXPECT_NEAR(roadquery::evaluate(road.lane_offset, 0.0), 0.0, 1e-9);  // to the right of the centre of the two-way road
  EXPECT_NEAR(roadquery::road_edges(road, 0.0).right_t, -3.0, 1e-6);
  EXPECT_NEAR(roadquery::evaluate(road.lane_offset, road.length), 3.0, 1e-6);  // all of the one-way road
  EXPECT_NEAR(roadquery::road_edges(road, road.length).right_t, -3.0, 1e-6);
}

TEST(BuildNetwork, closed_way_is_its_own_successor) {
  std::vector<Vec2> points = circle_points({0, 0}, 60.0, 0.0, 2.0 * M_PI);
  points.back() = points.front();
  RoadPath path = make_path(points, {1},
                            {.highway = "raceway", .width_m = 10.0, .oneway = Oneway::forward, .height = slope_height});
  path.nodes.back().osm_node = 1;
  const NetworkResult result = build_network(network_of({path}));
  expect_sound(result.map);
  ASSERT_EQ(result.map.roads.size(), 1u);
  const Road& road = result.map.roads[0];
  EXPECT_EQ(road.successor.id, road.id);
  EXPECT_EQ(road.successor.contact, ContactPoint::start);
  EXPECT_EQ(road.predecessor.id, road.id);
  EXPECT_EQ(road.sections[0].right[0].successor, -1);
  EXPECT_NEAR(road.length, 2.0 * M_PI * 60.0, 0.05);
}

TEST(BuildNetwork, circuit_with_an_access_road_stays_smooth_through_its_junction) {
  std::vector<Vec2> points = circle_points({0, 0}, 60.0, 0.0, 2.0 * M_PI);
  points.back() = points.front();
  const std::size_t gate = points.size() / 3;
  std::vector<std::int64_t> ids(points.size(), 0);
  ids.front() = ids.back() = 1, ids[gate] = 2;
  const NetworkResult result = build_network(network_of(
      {make_path(points, ids, {.highway = "raceway", .width_m = 10.0, .oneway = Oneway::forward}),
       make_path({points[gate], points[gate] * 2.0}, {2, 3}, {.osm_id = 2, .highway = "service", .width_m = 4.0})}));
  expect_sound(result.map);
  // Once round along the same way: the roads of the circuit and the way through its junction.
  double length = 0.0;
  for (const Road& road : result.map.roads) {
    if (road.osm_id != "1") continue;
    length += road.length;
    for (const roadquery::PlanElement& e : road.plan) EXPECT_NEAR(std::get<Arc>(e.shape).curvature, 1.0 / 60.0, 1e-5);
  }
  EXPECT_NEAR(length, 2.0 * M_PI * 60.0, 0.05);
}

TEST(BuildNetwork, roundabout_keeps_its_ring_and_direction) {
  std::vector<Vec2> ring = circle_points({0, 0}, 14.0, 0.0, 2.0 * M_PI);
  ring.back() = ring.front();
  std::vector<std::int64_t> ids(ring.size(), 0);
  const std::size_t second = ring.size() / 3, third = 2 * ring.size() / 3;
  ids.front() = ids.back() = 1, ids[second] = 2, ids[third] = 3;
  std::vector<RoadPath> paths{
      make_path(ring, ids, {.width_m = 5.0, .oneway = Oneway::forward, .lanes = 1, .roundabout = true})};
  int id = 2;
  for (const std::size_t i : {std::size_t{0}, second, third}) {
    paths.push_back(make_path({ring[i], ring[i] * 5.0}, {ids[i], id + 10}, {.osm_id = id}));
    ++id;
  }
  const NetworkResult result = build_network(network_of(paths));
  expect_sound(result.map);
  EXPECT_EQ(result.map.junctions.size(), 3u);
  EXPECT_EQ(plain_roads(result.map).size(), 6u);
  // At each: on along the ring, out of it, into it. Not the wrong way, not from the arm to itself.
  EXPECT_EQ(connecting_roads(result.map).size(), 9u);
  for (const Road& road : result.map.roads)
    for (const roadquery::PlanElement& e : road.plan)
      if (road.osm_id == "1") {
        EXPECT_NEAR(std::get<Arc>(e.shape).curvature, 1.0 / 14.0, 1e-4);
      }
}

TEST(BuildNetwork, one_way_roads_are_not_entered_from_their_end) {
  const NetworkResult result = build_network(network_of(
      {make_path({{-60, 0}, {0, 0}, {60, 0}}, {1, 2, 3}),
       make_path({{0, 50}, {0, 0}}, {4, 2}, {.osm_id = 2, .width_m = 4.0, .oneway = Oneway::forward, .lanes = 1})}));
  expect_sound(result.map);
  EXPECT_EQ(connecting_roads(result.map).size(), 4u);
  for (const Road* road : connecting_roads(result.map))
    EXPECT_NE(road_by_id(result.map, road->successor.id)->osm_id, "2");
}

TEST(BuildNetwork, lane_that_ends_at_a_junction_tapers_out) {
  const NetworkResult result = build_network(network_of(
      {make_path({{-80, 0}, {0, 0}}, {1, 2},
                 {.highway = "primary", .width_m = 7.0, .oneway = Oneway::forward, .lanes = 2}),
       make_path({{0, 0}, {80, 0}}, {2, 3}, {.osm_id = 2, .width_m = 3.5, .oneway = Oneway::forward, .lanes = 1}),
       make_path({{0, 0}, {0, -60}}, {2, 4}, {.osm_id = 3, .width_m = 3.5, .oneway = Oneway::forward, .lanes = 1})}));
  expect_sound(result.map);
  ASSERT_EQ(connecting_roads(result.map).size(), 2u);
  for (const Road* road : connecting_roads(result.map)) {
    const auto& lanes = road->sections[0].right;
    if (road_by_id(result.map, road->successor.id)->osm_id == "2") {
      ASSERT_EQ(lanes.size(), 2u);
      EXPECT_EQ(lanes[1].predecessor, -2);
      EXPECT_FALSE(lanes[1].successor);
      EXPECT_NEAR(roadquery::lane_width(lanes[1], 0.0), 3.5, 1e-6);
      EXPECT_NEAR(roadquery::lane_width(lanes[1], road->length), 0.0, 1e-9);
    } else {  // to the right, from the right lane
      ASSERT_EQ(lanes.size(), 1u);
      EXPECT_EQ(lanes[0].predecessor, -2);
      EXPECT_EQ(lanes[0].successor, -1);
    }
  }
}

TEST(BuildNetwork, bridge_over_a_road_is_no_junction) {
  RoadPath over = make_path({{0, -50}, {0, 50}}, {3, 4}, {.osm_id = 2, .height = [](Vec2) { return 16.0; }});
  over.bridge = true, over.layer = 1;
  const NetworkResult result =
      build_network(network_of({make_path({{-50, 0}, {50, 0}}, {1, 2}, {.height = [](Vec2) { return 10.0; }}), over}));
  expect_sound(result.map);
  ASSERT_EQ(result.map.roads.size(), 2u);
  EXPECT_TRUE(result.map.junctions.empty());
  EXPECT_TRUE(result.map.roads[1].bridge);
  EXPECT_EQ(result.map.roads[1].layer, 1);
  EXPECT_NEAR(roadquery::elevation(result.map.roads[1], 50.0), 16.0, 1e-9);
}

TEST(BuildNetwork, AllOfAJunctionLiesOnOneLevel) {
  // Three ways meet in a node; those of the mask are bridges.
  const auto levels = [](std::array<bool, 3> bridges) {
    RoadNetwork roads = network_of({make_path({{-60, 0}, {0, 0}}, {1, 2}, {.osm_id = 1}),
                                    make_path({{0, 0}, {60, 0}}, {2, 3}, {.osm_id = 2}),
                                    make_path({{0, 0}, {0, 60}}, {2, 4}, {.osm_id = 3})});
    for (std::size_t i = 0; i < bridges.size(); ++i)
      roads.paths[i].bridge = bridges[i], roads.paths[i].layer = bridges[i] ? 1 : 0;
    std::set<int> found;
    for (const roadquery::Road& road : build_network(roads).map.roads)
      if (road.junction >= 0) found.insert(road.layer);
    return found;
  };
  EXPECT_EQ(levels({false, false, false}), std::set<int>{0});
  EXPECT_EQ(levels({false, false, true}), std::set<int>{0}) << "the bridge begins behind the junction";
  EXPECT_EQ(levels({true, true, false}), std::set<int>{1}) << "it goes through";
  EXPECT_EQ(levels({true, true, true}), std::set<int>{1});
}

TEST(BuildNetwork, BesideAHigherRoadABankStaysFree) {
  // 6 m wide and 6.2 m apart.
  for (const double higher_m : {0.0, 0.3, 1.0}) {
    const roadquery::RoadMap map =
        build_network(
            network_of({make_path({{-100, 0}, {100, 0}}, {1, 2}, {.osm_id = 1, .height = [](Vec2) { return 10.0; }}),
                        make_path({{-100, 6.2}, {100, 6.2}}, {3, 4},
                                  {.osm_id = 2, .height = [&](Vec2) { return 10.0 + higher_m; }})}))
            .map;
    ASSERT_EQ(map.roads.size(), 2U);
    const auto half_m = [&](std::size_t i) { return roadquery::road_edges(map.roads[i], 100.0).left_t; };
    const double free_m = 6.2 - half_m(0) - half_m(1);
    EXPECT_GE(free_m, 0.1 + std::min(higher_m, 0.5) - 0.1) << higher_m;
    EXPECT_LE(free_m, 0.1 + std::min(higher_m, 0.5) + 0.15) << higher_m;
  }
}

TEST(BuildNetwork, WaysThatCrossOnOneLevelWithoutANodeGetAJunctionWithoutTurns) {
  const auto across = [](double z, int layer, bool bridge) {
    RoadNetwork roads =
        network_of({make_path({{-60, 0}, {60, 0}}, {1, 3}, {.osm_id = 1}),
                    make_path({{-0.7, -60}, {-0.7, 60}}, {4, 5}, {.osm_id = 2, .height = [z](Vec2) { return z; }})});
    for (RoadNode& node : roads.paths[0].nodes) node.z_m = 0.0;
    roads.paths[1].layer = layer, roads.paths[1].bridge = bridge;
    return build_network(roads);
  };
  const NetworkResult level = across(0.1, 0, false);
  expect_sound(level.map);
  ASSERT_EQ(level.map.junctions.size(), 1u);
  EXPECT_EQ(level.map.junctions[0].connections.size(), 4u) << "straight on in both directions of both, no turns";
  EXPECT_TRUE(level.map.junctions[0].surface);
  const auto told = std::find_if(level.findings.begin(), level.findings.end(),
                                 [](const Finding& f) { return f.code == "network.crossing_without_node"; });
  ASSERT_NE(told, level.findings.end());
  EXPECT_LT(distance({told->x_m, told->y_m}, site_origin + Vec2{-0.7, 0.0}), 1e-9);
  EXPECT_TRUE(across(0.1, 1, false).map.junctions.empty()) << "the layer says otherwise";
  EXPECT_TRUE(across(0.1, 0, true).map.junctions.empty()) << "a bridge";
  EXPECT_TRUE(across(4.0, 0, false).map.junctions.empty()) << "4 m above the other";
}

/// The least 1 - k t of where cars drive on a road, a quarter of a lane off its edges.
double least_room(const roadquery::Road& road) {
  double least = 1.0;
  for (int i = 0; i <= 100; ++i) {
    const double s = road.length * i / 100.0;
    const roadquery::Edges edges = roadquery::road_edges(road, s);
    const double k = roadquery::reference_point(road, s).curvature, inset = 0.25 * (edges.left_t - edges.right_t);
    least = std::min({least, 1.0 - k * (edges.left_t - inset), 1.0 - k * (edges.right_t + inset)});
  }
  return least;
}

TEST(BuildNetwork, LanesOfTightTurnsDoNotFold) {
  // A side road leaves backwards at 40 degrees: its cut lies so near to the main road's that the right turn into it is
  // sharper than the lane is wide.
  for (const double width : {6.0, 8.0, 12.0})
    for (const double angle : {0.6, 0.8, 1.0}) {
      const Vec2 back{-60.0 * std::cos(angle), -60.0 * std::sin(angle)};
      const roadquery::RoadMap map =
          build_network(network_of({make_path({{-60, 0}, {0, 0}, {60, 0}}, {1, 2, 3}, {.osm_id = 1, .width_m = width}),
                                    make_path({{0, 0}, back}, {2, 4}, {.osm_id = 2, .width_m = width}),
                                    make_path({{0, 0}, {back.x, -back.y}}, {2, 5}, {.osm_id = 3, .width_m = width})}))
              .map;
      for (const roadquery::Road* road : connecting_roads(map))
        EXPECT_GT(least_room(*road), 0.0) << width << " " << angle << ": road " << road->id;
    }
}

/// Where the inner border of a lane meets the end of its road.
roadquery::SurfacePoint border_of(const roadquery::Road& road, bool at_end, int lane) {
  const double s = at_end ? road.length : 0.0;
  double t = roadquery::evaluate(road.lane_offset, s);
  const roadquery::LaneSection& section = road.sections.front();
  for (const roadquery::Lane& q : lane > 0 ? section.left : section.right) {
    if (q.id == lane) break;
    t += (lane > 0 ? 1.0 : -1.0) * roadquery::lane_width(q, s);
  }
  return roadquery::surface_point(road, s, t);
}

TEST(BuildNetwork, LanesOfTightTurnsBesideShortRoadsDoNotFoldAndMeetTheirLanes) {
  // Two side roads leave a banked main road that climbs backwards, so near to each other that 8 m or little more of it
  // stay between.
  const auto height = [](Vec2 p) { return 0.06 * p.x + 0.0005 * p.x * p.x + 0.04 * p.y; };
  const auto bank = [](double) { return 0.05; };
  int beside_short = 0, moved = 0;
  for (double gap = 24.0; gap < 44.0; gap += 2.0) {
    const roadquery::RoadMap map =
        build_network(
            network_of(
                {make_path({{-60, 0}, {0, 0}, {gap, 0}, {90, 0}}, {1, 2, 3, 4},
                           {.osm_id = 1, .highway = "tertiary", .width_m = 12, .height = height, .banking = bank}),
                 make_path({{0, 0}, {33, -50}}, {2, 5}, {.osm_id = 2, .height = height}),
                 make_path({{gap, 0}, {gap - 33, 50}}, {3, 6}, {.osm_id = 3, .height = height})}))
            .map;
    for (const roadquery::Road* road : connecting_roads(map)) {
      EXPECT_GT(least_room(*road), 0.0) << "road " << road->id;
      for (const bool at_end : {false, true}) {
        const roadquery::RoadLink& link = at_end ? road->successor : road->predecessor;
        const roadquery::Road& other = *road_by_id(map, link.id);
        const bool other_end = link.contact == roadquery::ContactPoint::end;
        const roadquery::Lane& lane = road->sections.front().right.front();
        const std::optional<int>& linked = at_end ? lane.successor : lane.predecessor;
        ASSERT_TRUE(linked.has_value()) << "road " << road->id;
        const roadquery::SurfacePoint a = border_of(*road, at_end, -1), b = border_of(other, other_end, *linked);
        EXPECT_LT(std::hypot(a.x - b.x, a.y - b.y, a.z - b.z), 1e-6) << "road " << road->id << " and " << other.id;
        if (other.length > 9.0) continue;
        const roadquery::PlanPoint p = roadquery::reference_point(*road, at_end ? road->length : 0.0),
                                   q = roadquery::reference_point(other, other_end ? other.length : 0.0);
        ++beside_short, moved += std::hypot(p.x - q.x, p.y - q.y) > 0.1 ? 1 : 0;
      }
    }
  }
  EXPECT_GT(beside_short, 0) << "the case that is tested";
  EXPECT_GT(moved, 0) << "the case that is tested";
}

TEST(BuildNetwork, RoadsEndWhereTheyHaveLeftWaysInsideTheirJunction) {
  // A narrow way joins the main road at 6 degrees, 12 m behind a crossing: both vertices are one junction. It lies on
  // the main road, first on the part inside the junction, until the two lines are 7 m apart.
  const roadquery::RoadMap map =
      build_network(network_of({make_path({{-150, 0}, {0, 0}, {12, 0}, {100, 0}}, {1, 2, 3, 4},
                                          {.osm_id = 1, .highway = "primary", .width_m = 10}),
                                make_path({{0, 0}, {0, 50}}, {2, 5}, {.osm_id = 2}),
                                make_path({{12, 0}, {-138, -15.8}}, {3, 6}, {.osm_id = 3, .width_m = 4})}))
          .map;
  ASSERT_EQ(map.junctions.size(), 1u);
  int ends = 0;
  for (const roadquery::Road* road : plain_roads(map)) {
    for (const bool at_end : {false, true}) {
      if ((at_end ? road->successor : road->predecessor).kind != roadquery::LinkKind::junction) continue;
      const roadquery::PlanPoint p = roadquery::reference_point(*road, at_end ? road->length : 0.0);
      const Vec2 end = Vec2{p.x, p.y} - site_origin;
      if (road->osm_id == "3") {
        EXPECT_LT(end.y, -6.9);
        ++ends;
      } else if (road->osm_id == "1" && end.x < 0.0) {
        EXPECT_LT(end.x, 12.0 - 6.9 / 0.105);
        ++ends;
      }
    }
  }
  EXPECT_EQ(ends, 2);
}

/// By how much the edges of a road reach into the carriageway of another one, at most.
double overlap_m(const roadquery::Road& road, const roadquery::Road& other) {
  double deepest = 0.0;
  for (double s = 0.0; s <= road.length; s += 0.25) {
    const roadquery::Edges edges = roadquery::road_edges(road, s);
    for (const double t : {edges.left_t, edges.right_t}) {
      const roadquery::SurfacePoint p = roadquery::surface_point(road, s, t);
      for (double u = 0.0; u <= other.length; u += 0.25) {
        const roadquery::PlanPoint q = roadquery::reference_point(other, u);
        const double half = roadquery::road_edges(other, u).left_t;
        deepest = std::max(deepest, half - std::hypot(p.x - q.x, p.y - q.y));
      }
    }
  }
  return deepest;
}

TEST(BuildNetwork, JunctionsOfWhichTheRoadsForkAreOne) {
  // Beside the lane to the west a second one leaves the main road, forks after 10 m and turns away: between the cuts of
  // the two junctions its continuation would lie on the first lane.
  const roadquery::RoadMap map =
      build_network(network_of({make_path({{0, -60}, {0, -6}, {0, 0}, {0, 60}}, {1, 2, 3, 4}, {.osm_id = 1}),
                                make_path({{0, 0}, {-60, 0}}, {3, 5}, {.osm_id = 2, .width_m = 4}),
                                make_path({{0, -6}, {-10, -4}, {-16, -3.2}, {-22, -5}, {-30, -15}, {-40, -40}},
                                          {2, 6, 0, 0, 0, 7}, {.osm_id = 3, .width_m = 4}),
                                make_path({{-10, -4}, {-13, -30}}, {6, 8}, {.osm_id = 4, .width_m = 4})}))
          .map;
  EXPECT_EQ(map.junctions.size(), 1u);
  for (const roadquery::Road* a : plain_roads(map))
    for (const roadquery::Road* b : plain_roads(map))
      if (a != b) {
        EXPECT_LT(overlap_m(*a, *b), 0.05) << a->osm_id << " on " << b->osm_id;
      }
}

TEST(BuildNetwork, LinesThatCrossBesideTheirCommonNodeGetNoSecondOne) {
  const NetworkResult result =
      build_network(network_of({make_path({{-60, 0}, {0, 0}, {60, 0}}, {1, 2, 3}, {.osm_id = 1}),
                                make_path({{0, 0}, {6, 1}, {12, -1}, {20, -60}}, {2, 0, 0, 4}, {.osm_id = 2})}));
  EXPECT_EQ(result.map.junctions.size(), 1u);
  for (const Finding& finding : result.findings) EXPECT_NE(finding.code, "network.crossing_without_node");
}

TEST(BuildNetwork, a_slip_road_on_the_wrong_side_of_its_carriageway_still_merges) {
  // It crosses the carriageway at 6 degrees, 45 m before both meet.
  const auto one_way = [](const std::vector<Vec2>& points, const std::vector<std::int64_t>& ids, std::int64_t way) {
    return make_path(points, ids, {.osm_id = way, .width_m = 4.0, .oneway = Oneway::forward, .lanes = 1});
  };
  const NetworkResult result =
      build_network(network_of({one_way({{-200, 0}, {0, 0}}, {1, 9}, 1),
                                one_way({{-150, -12}, {-60, -1.5}, {-30, 1.5}, {0, 0}}, {2, 0, 0, 9}, 2),
                                one_way({{0, 0}, {150, 0}}, {9, 3}, 3)}));
  expect_sound(result.map);
  for (const Finding& finding : result.findings) EXPECT_NE(finding.code, "network.crossing_without_node");
  ASSERT_EQ(result.map.junctions.size(), 1u);
  EXPECT_EQ(result.map.junctions[0].connections.size(), 2u) << "from both onto the one";
}

TEST(BuildNetwork, junctions_closer_than_their_roads_are_wide_become_one) {
  const NetworkResult result = build_network(network_of({make_path({{-60, 0}, {0, 0}, {3, 0}, {60, 0}}, {1, 2, 3, 4}),
                                                         make_path({{0, 0}, {0, 50}}, {2, 5}, {.osm_id = 2}),
                                                         make_path({{3, 0}, {3, -50}}, {3, 6}, {.osm_id = 3})}));
  expect_sound(result.map);
  EXPECT_EQ(result.map.junctions.size(), 1u);
  EXPECT_EQ(plain_roads(result.map).size(), 4u);
  EXPECT_EQ(connecting_roads(result.map).size(), 12u);
}

TEST(BuildNetwork, road_between_two_junctions_is_kept_where_a_car_has_room) {
  // Cuts of 3 + 4 m at both ends.
  const auto built = [](double gap) {
    return build_network(network_of({make_path({{-60, 0}, {0, 0}, {gap, 0}, {90, 0}}, {1, 2, 3, 4}),
                                     make_path({{0, 0}, {0, 50}}, {2, 5}, {.osm_id = 2}),
                                     make_path({{gap, 0}, {gap, -50}}, {3, 6}, {.osm_id = 3})}));
  };
  const auto shortest_m = [](const NetworkResult& result) {
    double shortest = 1e9;
    for (const Road* road : plain_roads(result.map)) shortest = std::min(shortest, road->length);
    return shortest;
  };
  const NetworkResult joined = built(20.0), kept = built(21.0);
  expect_sound(joined.map), expect_sound(kept.map);
  EXPECT_EQ(joined.map.junctions.size(), 1u);
  EXPECT_GT(shortest_m(joined), 40.0);
  EXPECT_EQ(kept.map.junctions.size(), 2u);
  EXPECT_NEAR(shortest_m(kept), 8.0, 0.51);  // cuts are sampled every half metre
}

TEST(BuildNetwork, junctions_too_far_apart_to_be_one_leave_a_metre_between_them) {
  // Side roads of 12 degrees on both sides of the way between them: their cuts want more than its 45 m.
  const NetworkResult result = build_network(network_of({make_path({{-90, 0}, {0, 0}, {45, 0}, {135, 0}}, {1, 2, 3, 4}),
                                                         make_path({{0, 0}, {90, 19}}, {2, 5}, {.osm_id = 2}),
                                                         make_path({{45, 0}, {-45, -19}}, {3, 6}, {.osm_id = 3})}));
  expect_sound(result.map);
  EXPECT_EQ(result.map.junctions.size(), 2u);
  double shortest = 1e9;
  for (const Road* road : plain_roads(result.map)) shortest = std::min(shortest, road->length);
  EXPECT_NEAR(shortest, 1.0, 1e-6);
}

TEST(BuildNetwork, very_short_ways) {
  // 0.1 m between two longer ones: too short for a road; a stub of 1.5 m at a junction; a lone way of 1 m.
  const NetworkResult result = build_network(network_of(
      {make_path({{0, 0}, {40, 0}}, {1, 2}), make_path({{40, 0}, {40.1, 0}}, {2, 3}, {.osm_id = 2}),
       make_path({{40.1, 0}, {80, 0}, {120, 0}}, {3, 4, 5}, {.osm_id = 3}),
       make_path({{80, 0}, {80, 1.5}}, {4, 6}, {.osm_id = 4}), make_path({{0, 90}, {1, 90}}, {7, 8}, {.osm_id = 5}),
       make_path({{0, 95}, {0.1, 95}}, {9, 10}, {.osm_id = 6})}));
  expect_sound(result.map);
  EXPECT_TRUE(result.map.junctions.empty());
  EXPECT_EQ(count_findings(result, "network.stub_dropped"), 1);
  EXPECT_GE(count_findings(result, "network.way_in_junction"), 2);  // 0.1 m each
  for (const Road& road : result.map.roads) EXPECT_GE(road.length, 0.5);
}

TEST(BuildNetwork, hairpin_is_eased_to_what_the_carriageway_allows) {
  const NetworkResult result = build_network(network_of({make_path({{0, 0}, {50, 0}, {50, 3}, {0, 3}}, {1, 0, 0, 2})}));
  expect_sound(result.map);
  EXPECT_GT(result.eased_nodes, 0);
  const NetworkResult corner = build_network(network_of({make_path({{0, 0}, {50, 0}, {50, 50}}, {1, 0, 2})}));
  expect_sound(corner.map);
  double sharpest = 0.0;
  for (const roadquery::PlanElement& e : corner.map.roads.at(0).plan)
    if (const Arc* arc = std::get_if<Arc>(&e.shape)) sharpest = std::max(sharpest, std::abs(arc->curvature));
  EXPECT_LT(sharpest, 1.0 / 3.0) << "the inner edge of a 6 m road folds over";
  EXPECT_EQ(count_findings(corner, "network.bend_too_sharp"), 0);
}

TEST(BuildNetwork, HairpinThatHasNoRoomForAWideBendGetsANarrowOne) {
  // Two legs 40 degrees apart, 5 m wide: an inner radius of 2.5 m would move the tip by 9.6 m, one of 1.5 m by 7.7 m.
  const double half = 20.0 * M_PI / 180.0;
  const Vec2 leg{-60.0 * std::cos(half), 60.0 * std::sin(half)};
  const NetworkResult result =
      build_network(network_of({make_path({leg, {0, 0}, {leg.x, -leg.y}}, {1, 0, 2}, {.width_m = 5.0})}));
  expect_sound(result.map);
  for (const Finding& finding : result.findings) EXPECT_NE(finding.code, "network.bend_too_sharp");
  const roadquery::Road& road = result.map.roads.front();
  for (double s = 0.0; s <= road.length; s += 0.1) {
    const roadquery::Edges edges = roadquery::road_edges(road, s);
    const double k = roadquery::reference_point(road, s).curvature;
    EXPECT_GT(1.0 - k * edges.left_t, 0.1) << s;
    EXPECT_GT(1.0 - k * edges.right_t, 0.1) << s;
  }
}

TEST(BuildNetwork, sharp_corner_where_two_ways_meet_is_eased_to_the_end) {
  // 120 degrees, as where a service road leaves a street backwards.
  const NetworkResult result =
      build_network(network_of({make_path({{0, 80}, {0, 0}}, {1, 2}, {.width_m = 5.4}),
                                make_path({{0, 0}, {-60, 35}}, {2, 3}, {.osm_id = 2, .width_m = 5.4})}));
  expect_sound(result.map);
  EXPECT_EQ(count_findings(result, "network.bend_too_sharp"), 0);
  EXPECT_EQ(count_findings(result, "network.bend_eased"), 1);
  for (const Road& road : result.map.roads)
    for (const roadquery::PlanElement& e : road.plan) {
      const double k0 = roadquery::evaluate(e, 0.0).curvature, k1 = roadquery::evaluate(e, e.length).curvature;
      EXPECT_LT(std::abs(k0), 1.0 / 2.7) << "the inner edge of a 5.4 m road folds over";
      EXPECT_LE(std::abs(k1 - k0), 0.25 * e.length + 1e-9);
    }
}

TEST(BuildNetwork, way_that_turns_back_on_itself_survives) {
  const NetworkResult result = build_network(network_of({make_path({{0, 0}, {50, 0}, {0, 0.001}}, {1, 0, 2})}));
  ASSERT_EQ(result.map.roads.size(), 1u);
  expect_sound(result.map);
}

TEST(BuildNetwork, repeated_nodes_change_nothing) {
  const RoadPath path = make_path({{0, 0}, {30, 4}, {60, 0}}, {1, 2, 3});
  RoadPath repeated = path;
  repeated.nodes.clear();
  for (const RoadNode& node : path.nodes) repeated.nodes.insert(repeated.nodes.end(), 3, node);
  const NetworkResult a = build_network(network_of({path})), b = build_network(network_of({repeated}));
  expect_sound(b.map);
  ASSERT_EQ(a.map.roads.size(), b.map.roads.size());
  EXPECT_NEAR(a.map.roads[0].length, b.map.roads[0].length, 1e-9);
}

TEST(BuildNetwork, way_that_meets_itself) {
  // A lollipop: out, round, and back to its own middle.
  std::vector<Vec2> corners{{-80, 0}, {-20, 0}};
  for (const Vec2 p : circle_points({0, 0}, 20.0, M_PI, 2.0 * M_PI)) corners.push_back(p);
  corners.erase(corners.begin() + 2);
  corners.back() = {-20, 0};
  std::vector<std::int64_t> ids(corners.size(), 0);
  ids[0] = 1, ids[1] = 2, ids.back() = 2;
  const NetworkResult result = build_network(network_of({make_path(corners, ids)}));
  expect_sound(result.map);
  EXPECT_EQ(result.map.junctions.size(), 1u);
  EXPECT_EQ(plain_roads(result.map).size(), 4u);       // the loop is three: no road leads back into its own junction
  EXPECT_EQ(connecting_roads(result.map).size(), 6u);  // the loop's ends meet in one tangent: round again, too
}

TEST(BuildNetwork, CarriagewaysDoNotLieOnEachOther) {
  // A service road, measured too wide, 5 m beside a main road: 3.5 + 2.5 m of half widths.
  const roadquery::RoadMap map =
      build_network(
          network_of({make_path({{0, 0}, {200, 0}}, {1, 2}, {.highway = "tertiary", .width_m = 7.0}),
                      make_path({{20, 5}, {180, 5}}, {3, 4}, {.osm_id = 2, .highway = "service", .width_m = 5.0})}))
          .map;
  for (const roadquery::Road& road : map.roads)
    for (double s = 0.0; s < road.length; s += 1.0) {
      const double x = roadquery::reference_point(road, s).x - site_origin.x;
      if (x < 40.0 || x > 160.0) continue;  // the main road tapers to its width beyond the ends of the service road
      const roadquery::Edges edges = roadquery::road_edges(road, s);
      if (road.osm_id == "1") {
        EXPECT_NEAR(edges.left_t - edges.right_t, 7.0 - 2.0 * 0.65, 0.1) << "gives what is missing";
      }
      if (road.osm_id == "2") {
        EXPECT_NEAR(edges.left_t - edges.right_t, 4.1, 0.06) << "a lane of 2.05 m each way stays";
      }
    }
}

TEST(BuildNetwork, OneOfTwoCarriagewaysThatLieDeepOnEachOtherGivesWay) {
  // Both of one class, 10 m apart, with half widths of 7 and 5 m: 2 m and the margin are given by the narrower one. A
  // service road 4.5 m beside the axis of a main road of 12 m gives what it can, the main road nothing: it lacks 2.7 m.
  const auto widths = [](const char* highway, double far_m, double wide_m, double narrow_m) {
    const PathOptions main{.highway = "secondary", .width_m = wide_m},
        side{.osm_id = 2, .highway = highway, .width_m = narrow_m, .oneway = Oneway::forward};
    const roadquery::RoadMap map = build_network(network_of({make_path({{0, 0}, {400, 0}}, {1, 2}, main),
                                                             make_path({{100, far_m}, {300, far_m}}, {3, 4}, side)}))
                                       .map;
    std::pair<double, double> result;
    for (const roadquery::Road& road : map.roads) {
      const roadquery::Edges edges = roadquery::road_edges(road, 0.5 * road.length);
      (road.osm_id == "2" ? result.second : result.first) = edges.left_t - edges.right_t;
    }
    return result;
  };
  const auto [wide, narrow] = widths("secondary", 10.0, 14.0, 10.0);
  EXPECT_NEAR(wide, 14.0, 0.01);
  EXPECT_NEAR(narrow, 10.0 - 2.0 * 2.1, 0.06);
  const auto [main, service] = widths("service", 4.5, 12.0, 4.0);
  EXPECT_NEAR(main, 12.0, 0.01);
  EXPECT_NEAR(service, 2.2, 0.06);
}

TEST(BuildNetwork, DeadEndsStopBeforeASurfaceOfAnotherHeight) {
  // A service road runs against the edge of a main road that it is not linked to, 3.5 m beside the axis.
  const auto end_of = [](double above_m) {
    const auto height = [](double z) { return [z](Vec2) { return z; }; };
    const PathOptions main{.highway = "tertiary", .width_m = 7.0, .height = height(10.0)},
        side{.osm_id = 2, .highway = "service", .width_m = 4.0, .height = height(10.0 + above_m)};
    const roadquery::RoadMap map = build_network(network_of({make_path({{0, 0}, {200, 0}}, {1, 2}, main),
                                                             make_path({{100, 60}, {100, 3}}, {3, 4}, side)}))
                                       .map;
    for (const roadquery::Road& road : map.roads)
      if (road.osm_id == "2") return roadquery::reference_point(road, road.length).y - site_origin.y;
    return 0.0;
  };
  EXPECT_NEAR(end_of(0.0), 3.0, 0.01) << "flush: goes on into it";
  EXPECT_NEAR(end_of(0.2), 3.5 + 0.2 + 0.1, 0.26) << "a bank as wide as high, in steps of 25 cm";
  EXPECT_NEAR(end_of(5.0), 3.0, 0.01) << "another level";
}

TEST(BuildNetwork, ABankStaysFreeBetweenRoadsWhoseEdgesDifferInHeight) {
  // Side by side, edge at edge. What counts is where they meet, not their axes.
  const auto width_of = [](double z, double banking) {
    const PathOptions main{.highway = "tertiary",
                           .width_m = 7.0,
                           .height = [](Vec2) { return 10.0; },
                           .banking = [banking](double) { return banking; }},
        side{.osm_id = 2, .highway = "service", .width_m = 5.0, .height = [z](Vec2) { return z; }};
    const roadquery::RoadMap map = build_network(network_of({make_path({{0, 0}, {200, 0}}, {1, 2}, main),
                                                             make_path({{20, 6}, {180, 6}}, {3, 4}, side)}))
                                       .map;
    for (const roadquery::Road& road : map.roads)
      if (road.osm_id == "2") {
        const roadquery::Edges edges = roadquery::road_edges(road, 80.0);
        return edges.left_t - edges.right_t;
      }
    return 0.0;
  };
  EXPECT_NEAR(width_of(10.0, 0.0), 5.0, 0.01);
  EXPECT_NEAR(width_of(10.3, 0.0), 5.0 - 2.0 * (0.3 + 0.1), 0.06);
  EXPECT_NEAR(width_of(10.0 + 3.5 * std::tan(0.06), 0.06), 5.0, 0.01) << "flush where they meet";
  EXPECT_NEAR(width_of(10.0, 0.06), 5.0 - 2.0 * (3.5 * std::tan(0.06) + 0.1), 0.06);
}

TEST(BuildNetwork, OneWayRoadsBesideOthersKeepWhatACarNeeds) {
  // A service road of one direction, measured too wide, 4.3 m beside a main road: 3.5 + 2 m of half widths.
  const auto width_of = [](const roadquery::RoadMap& map, double along_m) {
    for (const roadquery::Road& road : map.roads) {
      const roadquery::Edges edges = roadquery::road_edges(road, along_m);
      if (road.osm_id == "2") return edges.left_t - edges.right_t;
    }
    return 0.0;
  };
  const PathOptions main{.highway = "tertiary", .width_m = 7.0},
      side{.osm_id = 2, .highway = "service", .width_m = 4.0, .oneway = Oneway::forward};
  const roadquery::RoadMap straight = build_network(network_of({make_path({{0, 0}, {200, 0}}, {1, 2}, main),
                                                                make_path({{20, 4.3}, {180, 4.3}}, {3, 4}, side)}))
                                          .map;
  EXPECT_NEAR(width_of(straight, 80.0), 2.2, 0.06) << "a car with its mirrors";
  const roadquery::RoadMap bend =
      build_network(network_of({make_path(circle_points({0, 0}, 24.0, 0.0, 3.0), {}, main),
                                make_path(circle_points({0, 0}, 19.7, 0.3, 2.4), {}, side)}))
          .map;
  EXPECT_NEAR(width_of(bend, 24.0), 2.2 + 2.7 * 2.7 / (2.0 * 19.7), 0.06) << "and what its wheels stray";
}

TEST(BuildNetwork, NobodyTurnsBackIntoARoadThatLeadsToTheJunctionOneComesFrom) {
  // A service road leaves the main road at 35 degrees and comes back to it 100 m further on.
  const double out_m = 50.0 * std::tan(35.0 * M_PI / 180.0);
  const PathOptions main{.width_m = 5.0}, loop{.osm_id = 2, .highway = "service", .width_m = 4.0};
  RoadNetwork roads = network_of({make_path({{-80, 0}, {0, 0}, {100, 0}, {180, 0}}, {1, 8, 9, 2}, main),
                                  make_path({{0, 0}, {50, out_m}, {100, 0}}, {8, 0, 9}, loop)});
  const auto turns_between = [](const roadquery::RoadMap& map, const std::string& from, const std::string& to) {
    int count = 0;
    for (const roadquery::Road* road : connecting_roads(map)) {
      const roadquery::Road *in = road_by_id(map, road->predecessor.id), *out = road_by_id(map, road->successor.id);
      count += static_cast<int>(in->osm_id == from && out->osm_id == to);
    }
    return count;
  };
  NetworkResult result = build_network(roads);
  EXPECT_EQ(turns_between(result.map, "1", "2"), 2) << "from outside";
  EXPECT_EQ(turns_between(result.map, "2", "1"), 2) << "outwards";
  EXPECT_EQ(count_findings(result, "network.turn_left_out"), 4);
  // The same fork without the way back: cars turn round its end.
  roads.paths[1] = make_path({{0, 0}, {50, out_m}, {100, 2.0 * out_m}}, {8, 0, 3}, loop);
  result = build_network(roads);
  EXPECT_EQ(turns_between(result.map, "1", "2"), 2);
  EXPECT_EQ(turns_between(result.map, "2", "1"), 2);
  EXPECT_EQ(count_findings(result, "network.turn_left_out"), 0);
}

TEST(BuildNetwork, DeadEndsThatLieBesideTheOtherRoadsHaveNoRoad) {
  // An access of 9 m that leaves by 12 degrees: as far as it goes it lies on the road that it leaves.
  const NetworkResult result =
      build_network(network_of({make_path({{-80, 0}, {0, 0}, {80, 0}}, {1, 2, 3}, {.width_m = 7.0}),
                                make_path({{0, 0}, {0, 60}}, {2, 5}, {.osm_id = 3}),
                                make_path({{0, 0}, {8.8, 1.9}}, {2, 4}, {.osm_id = 2, .highway = "service"})}));
  expect_sound(result.map);
  for (const roadquery::Road& road : result.map.roads) EXPECT_NE(road.osm_id, "2") << "road " << road.id;
  EXPECT_TRUE(std::any_of(result.findings.begin(), result.findings.end(),
                          [](const Finding& f) { return f.code == "network.way_in_junction"; }));
  EXPECT_EQ(result.map.junctions.size(), 1u);
}

}  // namespace
}  // namespace orthodrive
