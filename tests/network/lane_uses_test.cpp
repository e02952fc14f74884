// SPDX-License-Identifier: Apache-2.0
// Lanes for both directions, of one kind of vehicle and with limits of their own; where placement puts the lanes.

#include "network_support.hpp"
#include "orthodrive/network/lanes/lanes.hpp"

namespace orthodrive {
namespace {

using namespace orthodrive::network_test;
using roadquery::Lane;
using roadquery::LaneType;
using roadquery::Road;

const Road& of_way(const roadquery::RoadMap& map, const std::string& osm_id) {
  for (const Road& road : map.roads)
    if (road.junction < 0 && road.osm_id == osm_id) return road;
  throw std::runtime_error("no road of way " + osm_id);
}

std::vector<LaneType> types(const std::vector<Lane>& lanes) {
  std::vector<LaneType> result;
  result.reserve(lanes.size());
  for (const Lane& lane : lanes) result.push_back(lane.type);
  return result;
}

RoadPath five_lanes(const std::vector<Vec2>& corners, const std::vector<std::int64_t>& ids, std::int64_t id) {
  RoadPath path = make_path(corners, ids, {.osm_id = id, .highway = "secondary", .width_m = 16.75, .lanes = 5});
  path.lanes_forward = path.lanes_backward = 2, path.lanes_both_ways = 1;
  return path;
}

TEST(LaneUses, a_centre_lane_is_bidirectional) {
  for (const DrivingSide side : {DrivingSide::right, DrivingSide::left}) {
    BuildNetworkOptions options;
    options.driving_side = side;
    const NetworkResult result = build_network(network_of({five_lanes({{0, 0}, {100, 0}}, {1, 2}, 1)}), options);
    const Road& road = of_way(result.map, "1");
    const bool left_hand = side == DrivingSide::left;
    const auto &with = left_hand ? road.sections[0].left : road.sections[0].right,
               &against = left_hand ? road.sections[0].right : road.sections[0].left;
    EXPECT_EQ(types(with), (std::vector{LaneType::bidirectional, LaneType::driving, LaneType::driving}));
    EXPECT_EQ(types(against), (std::vector{LaneType::driving, LaneType::driving}));
    EXPECT_EQ(network::lanes_of_direction(road, true).size(), 2u);
    EXPECT_NEAR(roadquery::road_edges(road, 50.0).left_t, 0.5 * 16.75, 0.01) << "all centred";
    EXPECT_NEAR(roadquery::evaluate(road.lane_offset, 50.0), (left_hand ? -0.5 : 0.5) * 3.25, 0.2);
  }
}

TEST(LaneUses, a_centre_lane_opens_between_the_directions_and_goes_on) {
  RoadPath four =
      make_path({{0, 0}, {100, 0}}, {1, 2}, {.osm_id = 1, .highway = "secondary", .width_m = 16.75, .lanes = 4});
  RoadPath back = five_lanes({{300, 0}, {200, 0}}, {4, 3}, 3);  // drawn against the one before
  const NetworkResult result = build_network(network_of({four, five_lanes({{100, 0}, {200, 0}}, {2, 3}, 2), back}));
  expect_sound(result.map);
  EXPECT_TRUE(result.map.junctions.empty());
  const Road &a = of_way(result.map, "1"), &b = of_way(result.map, "2"), &c = of_way(result.map, "3");
  EXPECT_EQ(a.sections[0].right[0].successor, -2) << "the lane for both opens inside";
  EXPECT_FALSE(b.sections[0].right[0].predecessor);
  EXPECT_NEAR(roadquery::lane_width(b.sections[0].right[0], 0.0), 0.0, 1e-9);
  EXPECT_EQ(b.sections[0].right[0].successor, -1) << "that of the other road";
  EXPECT_EQ(c.sections[0].right[0].successor, -1);
  EXPECT_EQ(b.sections[0].right[1].successor, 1);
  EXPECT_EQ(b.sections[0].left[0].successor, -2);
}

TEST(LaneUses, a_single_track_road_has_one_lane_of_its_width) {
  RoadPath narrow =
      make_path({{0, 0}, {100, 0}}, {1, 2}, {.osm_id = 1, .highway = "unclassified", .width_m = 3.0, .lanes = 1});
  RoadPath wide =
      make_path({{100, 0}, {200, 0}}, {2, 3}, {.osm_id = 2, .highway = "unclassified", .width_m = 5.5, .lanes = 2});
  for (const DrivingSide side : {DrivingSide::right, DrivingSide::left}) {
    BuildNetworkOptions options;
    options.driving_side = side;
    const NetworkResult result = build_network(network_of({narrow, wide}), options);
    expect_sound(result.map);
    const Road& road = of_way(result.map, "1");
    const auto& lanes = side == DrivingSide::right ? road.sections[0].right : road.sections[0].left;
    EXPECT_EQ(types(lanes), std::vector{LaneType::bidirectional});
    EXPECT_NEAR(roadquery::lane_width(lanes[0], 50.0), 3.0, 0.02);
    EXPECT_EQ(network::lanes_of_direction(road, true), network::lanes_of_direction(road, false));
    ASSERT_EQ(result.map.junctions.size(), 1u) << "one lane becomes two";
    EXPECT_EQ(result.map.junctions[0].connections.size(), 2u) << "both ways";
    for (const Finding& finding : result.findings) EXPECT_NE(finding.code, "network.widened");
  }
}

TEST(LaneUses, lanes_against_a_one_way_road_are_not_for_cars) {
  RoadPath path =
      make_path({{0, 0}, {100, 0}}, {1, 2},
                {.osm_id = 1, .highway = "secondary", .width_m = 10.0, .oneway = Oneway::forward, .lanes = 3});
  path.lanes_forward = 2, path.lanes_backward = 1, path.use_backward = "bus";
  const RoadPath next =
      make_path({{100, 0}, {200, 0}}, {2, 3},
                {.osm_id = 2, .highway = "secondary", .width_m = 7.0, .oneway = Oneway::forward, .lanes = 2});
  const NetworkResult result = build_network(network_of({path, next}));
  expect_sound(result.map);
  const Road& road = of_way(result.map, "1");
  EXPECT_EQ(types(road.sections[0].right), (std::vector{LaneType::driving, LaneType::driving}));
  EXPECT_EQ(types(road.sections[0].left), std::vector{LaneType::bus});
  EXPECT_EQ(road.sections[0].left[0].allowed, std::vector<std::string>{"bus"});
  EXPECT_TRUE(network::lanes_of_direction(road, false).empty());
  path.use_backward.clear();
  EXPECT_EQ(network::lane_layout(path, 10.0, DrivingSide::right).use(true, 0).type, LaneType::other)
      << "nobody is told: closed";
}

TEST(LaneUses, bus_and_cycle_lanes_lie_outside) {
  RoadPath path =
      make_path({{0, 0}, {100, 0}}, {1, 2}, {.osm_id = 1, .highway = "secondary", .width_m = 17.0, .lanes = 4});
  path.side_lanes = "bus:along bus:against bicycle:right";
  const Road road = of_way(build_network(network_of({path})).map, "1");
  EXPECT_EQ(types(road.sections[0].right).at(0), LaneType::driving);
  EXPECT_EQ(types(road.sections[0].right).at(1), LaneType::bus);
  EXPECT_EQ(types(road.sections[0].right).at(2), LaneType::biking);
  EXPECT_NEAR(roadquery::lane_width(road.sections[0].right[2], 50.0), 1.5, 0.01);
  EXPECT_EQ(types(road.sections[0].left).at(1), LaneType::bus);
  path.side_lanes = "bus:left";
  EXPECT_EQ(network::lane_layout(path, 17.0, DrivingSide::right).use(true, 1).type, LaneType::bus);
  EXPECT_EQ(network::lane_layout(path, 17.0, DrivingSide::left).use(true, 1).type, LaneType::bus);
  path = make_path({{0, 0}, {100, 0}}, {1, 2}, {.highway = "secondary", .width_m = 5.0, .lanes = 2});
  path.side_lanes = "bicycle:left bicycle:right";
  const NetworkResult narrow = build_network(network_of({path}));
  EXPECT_EQ(std::ranges::count(narrow.findings, "network.no_room_for_cycle_lanes", &Finding::code), 1);
}

TEST(LaneUses, a_bus_road_is_linked_and_no_car_is_led_into_it) {
  RoadPath buses = make_path({{0, 0}, {0, 100}}, {9, 3}, {.osm_id = 3, .highway = "busway", .width_m = 7.0});
  buses.use = "bus";
  const NetworkResult result = build_network(network_of(
      {make_path({{-100, 0}, {0, 0}}, {1, 9}, {.osm_id = 1, .highway = "secondary", .width_m = 7.0}),
       make_path({{0, 0}, {100, 0}}, {9, 2}, {.osm_id = 2, .highway = "secondary", .width_m = 7.0}), buses}));
  expect_sound(result.map);
  const Road& road = of_way(result.map, "3");
  EXPECT_EQ(types(road.sections[0].right), std::vector{LaneType::bus});
  int of_buses = 0;
  for (const Road& connecting : result.map.roads) {
    if (connecting.junction < 0) continue;
    const bool of_bus_road = connecting.predecessor.id == road.id || connecting.successor.id == road.id;
    EXPECT_EQ(connecting.sections[0].right[0].type, of_bus_road ? LaneType::bus : LaneType::driving);
    of_buses += of_bus_road ? 1 : 0;
  }
  EXPECT_EQ(of_buses, 4);
}

TEST(LaneUses, lanes_have_the_limits_of_their_direction) {
  RoadPath path = make_path({{0, 0}, {100, 0}}, {1, 2}, {.osm_id = 1, .highway = "tertiary", .width_m = 7.0});
  path.speeds_forward = "70", path.speeds_backward = "30", path.speed_limit_kmh = 70.0;
  const Road road = of_way(build_network(network_of({path})).map, "1");
  ASSERT_EQ(road.sections[0].right[0].speeds.size(), 1u);
  EXPECT_NEAR(road.sections[0].right[0].speeds[0].mps, 70.0 / 3.6, 1e-9);
  EXPECT_NEAR(road.sections[0].left[0].speeds.at(0).mps, 30.0 / 3.6, 1e-9);
}

double shift_at_middle(const RoadPath& path, DrivingSide side) {
  BuildNetworkOptions options;
  options.driving_side = side;
  return roadquery::evaluate(of_way(build_network(network_of({path}), options).map, "1").lane_offset, 50.0);
}

TEST(Placement, the_line_lies_where_it_says) {
  RoadPath path =
      make_path({{0, 0}, {100, 0}}, {1, 2},
                {.osm_id = 1, .highway = "motorway", .width_m = 11.25, .oneway = Oneway::forward, .lanes = 3});
  for (const double told : {0.0, 0.5, 1.0, 1.5, 3.0}) {
    path.placement = {false, told, told};
    EXPECT_NEAR(shift_at_middle(path, DrivingSide::right), told * 3.75, 0.02) << "left edge of lane 1";
    EXPECT_NEAR(shift_at_middle(path, DrivingSide::left), -(3.0 - told) * 3.75, 0.02) << "right edge of lane 3";
  }
  path = make_path({{0, 0}, {100, 0}}, {1, 2}, {.osm_id = 1, .highway = "secondary", .width_m = 9.0, .lanes = 3});
  path.lanes_forward = 2, path.lanes_backward = 1, path.placement = {false, 1.0, 1.0};
  EXPECT_NEAR(shift_at_middle(path, DrivingSide::right), 3.0, 0.02) << "between the forward lanes";
  path.placement = {true, 1.0, 1.0};
  EXPECT_NEAR(shift_at_middle(path, DrivingSide::right), -3.0, 0.02) << "at the edge of the backward one";
}

TEST(Placement, nothing_jumps_where_lanes_end_and_where_it_changes) {
  RoadPath three =
      make_path({{0, 0}, {100, 0}}, {1, 2},
                {.osm_id = 1, .highway = "motorway", .width_m = 11.25, .oneway = Oneway::forward, .lanes = 3});
  RoadPath two =
      make_path({{100, 0}, {200, 0}}, {2, 3},
                {.osm_id = 2, .highway = "motorway", .width_m = 11.25, .oneway = Oneway::forward, .lanes = 2});
  RoadPath next =
      make_path({{200, 0}, {300, 0}}, {3, 4},
                {.osm_id = 3, .highway = "motorway", .width_m = 11.25, .oneway = Oneway::forward, .lanes = 2});
  three.placement = two.placement = {false, 1.0, 1.0};
  next.placement.transition = true;
  const NetworkResult result = build_network(network_of({three, two, next}));
  expect_sound(result.map);
  const Road &a = of_way(result.map, "1"), &b = of_way(result.map, "2"), &c = of_way(result.map, "3");
  EXPECT_NEAR(roadquery::evaluate(a.lane_offset, 40.0), 3.75, 0.1);
  EXPECT_NEAR(roadquery::evaluate(a.lane_offset, a.length), roadquery::evaluate(b.lane_offset, 0.0), 1e-6);
  EXPECT_NEAR(roadquery::evaluate(b.lane_offset, b.length), roadquery::evaluate(c.lane_offset, 0.0), 1e-6);
}

/// Largest distance between the borders of lanes of connecting roads and of the lanes that they are linked to, m.
double lane_gap(const roadquery::RoadMap& map) {
  double worst_m = 0.0;
  const auto borders = [](const Road& road, int id, bool at_end) {
    const double s = at_end ? road.length : 0.0;
    double t = roadquery::evaluate(road.lane_offset, s);
    for (const Lane& lane : id > 0 ? road.sections.front().left : road.sections.front().right) {
      const double inner = t;
      t += (id > 0 ? 1.0 : -1.0) * roadquery::lane_width(lane, s);
      if (lane.id != id) continue;
      const roadquery::SurfacePoint a = roadquery::surface_point(road, s, inner),
                                    b = roadquery::surface_point(road, s, t);
      return std::pair{Vec2{a.x, a.y}, Vec2{b.x, b.y}};
    }
    throw std::runtime_error("no such lane");
  };
  for (const Road& road : map.roads) {
    if (road.junction < 0) continue;
    for (const auto* side : {&road.sections.front().left, &road.sections.front().right})
      for (const Lane& lane : *side)
        for (const bool at_end : {false, true}) {
          const std::optional<int>& linked = at_end ? lane.successor : lane.predecessor;
          if (!linked) continue;
          const roadquery::RoadLink& link = at_end ? road.successor : road.predecessor;
          const auto [a, b] = borders(road, lane.id, at_end);
          const auto [c, d] = borders(*road_by_id(map, link.id), *linked, link.contact == roadquery::ContactPoint::end);
          worst_m = std::max(
              worst_m, std::min(std::max(distance(a, c), distance(b, d)), std::max(distance(a, d), distance(b, c))));
        }
  }
  return worst_m;
}

/// A hilly crossing, a reversible road of three lanes, and the next crossing: down to what is shorter than a car.
TEST(LaneUses, reversible_lanes_meet_those_of_junctions) {
  const auto height = [](Vec2 p) { return 50.0 + 2.0 * std::sin(p.x / 17.0) + 3.0 * std::cos(p.y / 23.0); };
  for (const DrivingSide side : {DrivingSide::right, DrivingSide::left})
    for (double length_m = 20.0; length_m < 40.0; length_m += 1.0) {
      RoadPath reversible =
          make_path({{0, 0}, {length_m, 0}}, {1, 2},
                    {.osm_id = 1, .width_m = 11.25, .lanes = 3, .height = height, .banking = [](double s) {
                       return 0.04 + 0.0005 * s;
                     }});
      reversible.lanes_both_ways = 3;
      const auto street = [&](Vec2 a, Vec2 b, Vec2 c, std::int64_t id, std::int64_t node) {
        return make_path({a, b, c}, {10 * id, node, 10 * id + 1},
                         {.osm_id = id, .highway = "tertiary", .width_m = 7.0, .lanes = 2, .height = height});
      };
      BuildNetworkOptions options;
      options.driving_side = side;
      const NetworkResult result =
          build_network(network_of({reversible, street({-20, -60}, {0, 0}, {-10, 60}, 2, 1),
                                    street({length_m, -60}, {length_m, 0}, {length_m + 25, 60}, 3, 2)}),
                        options);
      EXPECT_LT(lane_gap(result.map), 0.01) << length_m << " m";
    }
}

/// Two carriageways of one-way roads end at one node, as far apart as they lie, or nearer than their lanes are wide.
TEST(LaneUses, lanes_turn_back_only_where_they_have_room) {
  for (const DrivingSide side : {DrivingSide::right, DrivingSide::left})
    for (const double apart_m : {1.0, 2.5, 4.0, 6.0, 9.0, 14.0}) {
      const double sign = side == DrivingSide::left ? -1.0 : 1.0;
      const auto carriageway = [&](double x, bool north, std::int64_t id) {
        const std::vector<Vec2> out{{sign * x, -150.0}, {sign * x, -6.0 * std::abs(x)}, {0.0, 0.0}};
        return make_path(north ? out : std::vector(out.rbegin(), out.rend()),
                         north ? std::vector<std::int64_t>{10 * id, 0, 1} : std::vector<std::int64_t>{1, 0, 10 * id},
                         {.osm_id = id, .highway = "secondary", .width_m = 7.5, .oneway = Oneway::forward, .lanes = 2});
      };
      BuildNetworkOptions options;
      options.driving_side = side;
      const NetworkResult result = build_network(
          network_of({carriageway(0.5 * apart_m, true, 1), carriageway(-0.5 * apart_m, false, 2)}), options);
      EXPECT_LT(lane_gap(result.map), 0.01);
      int turns = 0;
      for (const Road& road : result.map.roads) {
        if (road.junction < 0) continue;
        ++turns;
        for (double s = 0.0; s <= road.length; s += 0.25) {
          const roadquery::Edges edges = roadquery::road_edges(road, s);
          const double middle = 0.5 * (edges.left_t + edges.right_t);
          EXPECT_GT(1.0 - roadquery::reference_point(road, s).curvature * middle, 0.0)
              << apart_m << " m apart, road " << road.id << ", s " << s;
        }
      }
      const bool is_told =
          std::ranges::any_of(result.findings, [](const Finding& f) { return f.code == "network.no_room_to_turn"; });
      if (apart_m < 2.0) EXPECT_TRUE(is_told) << apart_m;
      if (apart_m > 8.0) EXPECT_FALSE(is_told) << apart_m;
      if (apart_m > 8.0) EXPECT_GT(turns, 0) << apart_m;
    }
}

}  // namespace
}  // namespace orthodrive
