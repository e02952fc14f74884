// SPDX-License-Identifier: Apache-2.0
// The verdict on maps made by hand: a clean one passes, and every made fault is found where it is.

#include "orthodrive/evaluate/networks/judge_network.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "orthodrive/model/roads/traffic_calming.hpp"
#include "roadquery/make_road.hpp"

namespace orthodrive {
namespace {

using namespace roadquery;

constexpr double kmh = 1.0 / 3.6;

/// 100 m of straight road of two lanes of 3.5 m along the x axis, from x = 0 on.
Road straight_road(int id, double x, double length = 100.0) {
  Road road = roadquery::test::make_road(id, {0.0, x, 0.0, 0.0, length, Line{}}, 10.0);
  road.speed_limit_mps = 50.0 * kmh;
  return road;
}

void join(Road& before, Road& after) {
  before.successor = {LinkKind::road, after.id, ContactPoint::start};
  after.predecessor = {LinkKind::road, before.id, ContactPoint::end};
  for (Lane* lane : {&before.sections[0].left.front(), &before.sections[0].right.front()}) lane->successor = lane->id;
  for (Lane* lane : {&after.sections[0].left.front(), &after.sections[0].right.front()}) lane->predecessor = lane->id;
}

std::size_t places(const NetworkVerdict& verdict, FaultKind kind) {
  return verdict.places[static_cast<std::size_t>(kind)];
}

/// Every place of this kind lies within a metre of x (both lanes have one), no other kind fails but `with_it`.
void expect_fault_at(const RoadMap& map, FaultKind kind, double x, std::vector<FaultKind> with_it = {}) {
  const NetworkVerdict verdict = judge_network(map);
  EXPECT_FALSE(verdict.pass());
  EXPECT_GT(places(verdict, kind), 0u) << to_string(kind);
  for (const Fault& fault : verdict.faults) {
    const bool expected = fault.kind == kind || std::find(with_it.begin(), with_it.end(), fault.kind) != with_it.end();
    EXPECT_TRUE(expected) << to_string(fault.kind) << " " << fault.value << " at " << fault.x << ", " << fault.y;
    if (fault.kind == kind) EXPECT_NEAR(fault.x, x, 1.0) << to_string(kind);
    EXPECT_GT(fault.value, fault.limit);
  }
}

TEST(JudgeNetwork, a_clean_network_passes) {
  Road bend = straight_road(1, 0.0, 40.0);
  roadquery::test::append(bend, 30.0, Spiral{0.0, 0.02});
  roadquery::test::append(bend, 40.0, Arc{0.02});
  roadquery::test::append(bend, 30.0, Spiral{0.02, 0.0});
  bend.elevation = {{.s = 0.0, .a = 10.0, .b = 0.05, .c = -2e-4}};
  bend.superelevation = {{.s = 40.0, .c = 3e-5, .d = -3e-7}};
  const PlanPoint end = reference_point(bend, bend.length);
  Road on = roadquery::test::make_road(2, {0.0, end.x, end.y, end.hdg, 50.0, Line{}}, 0.0);
  on.speed_limit_mps = 50.0 * kmh;
  on.elevation = {{.s = 0.0, .a = elevation(bend, bend.length), .b = gradient(bend, bend.length)}};
  on.superelevation = {{.s = 0.0, .a = superelevation(bend, bend.length)}};
  join(bend, on);
  for (const DrivingSide side : {DrivingSide::right, DrivingSide::left}) {
    bend.driving_side = on.driving_side = side;
    const NetworkVerdict verdict = judge_network({.roads = {bend, on}});
    EXPECT_TRUE(verdict.pass()) << (verdict.faults.empty() ? "" : to_string(verdict.faults[0].kind));
    EXPECT_EQ(verdict.lanes, 4u);
    EXPECT_EQ(verdict.links, 2u) << "one each way";
    EXPECT_NEAR(verdict.track_length_m, 2.0 * 2.0 * 190.0, 1e-6);
  }
}

TEST(JudgeNetwork, nothing_to_drive_on_passes) {
  EXPECT_TRUE(judge_network({}).pass());
  Road narrow = straight_road(1, 0.0);
  for (Lane* lane : {&narrow.sections[0].left.front(), &narrow.sections[0].right.front()}) lane->width = {{.a = 1.0}};
  narrow.elevation.push_back({.s = 50.0, .a = 20.0});
  EXPECT_TRUE(judge_network({.roads = {narrow}}).pass()) << "no car fits on it";
}

TEST(JudgeNetwork, a_step_within_a_road) {
  Road road = straight_road(1, 0.0);
  road.elevation.push_back({.s = 40.03, .a = 10.03});
  expect_fault_at({.roads = {road}}, FaultKind::step, 40.0);
  road.elevation[1].a = 10.004;
  EXPECT_TRUE(judge_network({.roads = {road}}).pass()) << "4 mm are below the limit";
}

TEST(JudgeNetwork, a_step_where_roads_are_linked) {
  RoadMap map{.roads = {straight_road(1, 0.0), straight_road(2, 100.0)}};
  join(map.roads[0], map.roads[1]);
  EXPECT_TRUE(judge_network(map).pass());
  map.roads[1].elevation[0].a = 10.05;
  expect_fault_at(map, FaultKind::step, 100.0);
}

TEST(JudgeNetwork, a_ramp_is_no_step_but_a_kink_that_speed_feels) {
  Road road = straight_road(1, 0.0);
  road.elevation.push_back({.s = 40.0, .a = 10.0, .b = 0.12});
  expect_fault_at({.roads = {road}}, FaultKind::vertical_acceleration, 40.0);
  road.speed_limit_mps = 20.0 * kmh;
  EXPECT_TRUE(judge_network({.roads = {road}}).pass()) << "at walking pace nobody minds";
}

TEST(JudgeNetwork, a_hump_is_judged_by_the_legal_speed) {
  Road road = straight_road(1, 0.0);
  constexpr double radius_m = 100.0;  // a crest: v^2 / R = 1.93 m/s2 at 50 km/h, 13.0 at 130 km/h
  road.elevation.push_back({.s = 40.0, .a = 10.0, .c = -0.5 / radius_m});
  const NetworkVerdict slow = judge_network({.roads = {road}});
  EXPECT_TRUE(slow.pass());
  EXPECT_NEAR(slow.worst[static_cast<std::size_t>(FaultKind::vertical_acceleration)], 1.93, 0.02);
  road.speed_limit_mps = 130.0 * kmh;
  EXPECT_GT(places(judge_network({.roads = {road}}), FaultKind::vertical_acceleration), 0u);
}

TEST(JudgeNetwork, a_hump_that_is_meant_is_driven_at_its_own_speed) {
  Road road = straight_road(1, 0.0);
  road.speed_limit_mps = 100.0 * kmh;
  const HumpProfile& hump = *hump_profile("hump");
  const double c = 3.0 * hump.height_m / (hump.ramp_m * hump.ramp_m), d = 2.0 * c / (3.0 * hump.ramp_m);
  road.elevation.push_back({.s = 40.0, .a = 10.0, .c = c, .d = -d});
  road.elevation.push_back({.s = 40.0 + hump.ramp_m, .a = 10.0 + hump.height_m, .c = -c, .d = d});
  road.elevation.push_back({.s = 40.0 + 2.0 * hump.ramp_m, .a = 10.0});
  EXPECT_GT(places(judge_network({.roads = {road}}), FaultKind::vertical_acceleration), 0u) << "nothing says so";
  road.objects.push_back({.type = hump_object,
                          .subtype = hump_subtype,
                          .name = "hump",
                          .s = 40.0 + hump.ramp_m,
                          .length = hump.length_m(),
                          .width = 7.0});
  EXPECT_TRUE(judge_network({.roads = {road}}).pass());
  road.objects.back().s = 70.0;
  EXPECT_GT(places(judge_network({.roads = {road}}), FaultKind::vertical_acceleration), 0u) << "another one's";
}

TEST(JudgeNetwork, a_hole_between_linked_roads) {
  RoadMap map{.roads = {straight_road(1, 0.0), straight_road(2, 100.8)}};
  join(map.roads[0], map.roads[1]);
  expect_fault_at(map, FaultKind::hole, 100.4, {FaultKind::gap});
}

TEST(JudgeNetwork, a_wedge_on_the_outer_side_of_a_kink) {
  RoadMap map{.roads = {straight_road(1, 0.0), straight_road(2, 100.0)}};
  join(map.roads[0], map.roads[1]);
  map.roads[1].plan[0].hdg = 0.2;  // 3.4 m to the right of the joint the ends are 0.7 m apart
  expect_fault_at(map, FaultKind::hole, 100.0, {FaultKind::heading_jump, FaultKind::gap});
  EXPECT_GT(places(judge_network(map), FaultKind::heading_jump), 0u);
}

TEST(JudgeNetwork, a_kink_of_the_line_within_a_road) {
  Road road = straight_road(1, 0.0, 50.0);
  road.plan.push_back({.s = 50.0, .x = 50.0, .hdg = 0.03, .length = 50.0, .shape = Line{}});
  road.length = 100.0;
  expect_fault_at({.roads = {road}}, FaultKind::heading_jump, 50.0);
  road.plan[1].hdg = 0.01;
  EXPECT_TRUE(judge_network({.roads = {road}}).pass());
}

TEST(JudgeNetwork, a_jump_of_the_curvature) {
  Road road = straight_road(1, 0.0, 50.0);
  roadquery::test::append(road, 30.0, Arc{1.0 / 80.0});  // 2.4 m/s2 at once at 50 km/h
  expect_fault_at({.roads = {road}}, FaultKind::curvature_jump, 50.0);
  road.junction = 7;
  EXPECT_TRUE(judge_network({.roads = {road}}).pass()) << "connecting roads are G1";
}

TEST(JudgeNetwork, a_jump_of_the_width) {
  RoadMap map{.roads = {straight_road(1, 0.0), straight_road(2, 100.0)}};
  join(map.roads[0], map.roads[1]);
  map.roads[1].sections[0].right[0].width = {{.a = 3.2}};
  expect_fault_at(map, FaultKind::width_jump, 100.0, {FaultKind::gap});
}

TEST(JudgeNetwork, a_jump_of_the_grip) {
  Road road = straight_road(1, 0.0);
  road.sections[0].right[0].materials = {{.friction = 1.0}, {.s_offset = 30.0, .friction = 0.45}};
  expect_fault_at({.roads = {road}}, FaultKind::grip_jump, 30.0);
  road.sections[0].right[0].materials[1].friction = 0.7;
  EXPECT_TRUE(judge_network({.roads = {road}}).pass()) << "asphalt to gravel is what roads do";
}

/// A road that turns by 86 degrees with a radius of 6 m, in a junction whose surface is z(x, y).
RoadMap turn_on(const std::function<double(double, double)>& z) {
  Road turn = roadquery::test::make_road(1, {0.0, 0.0, 0.0, 0.0, 9.0, Arc{1.0 / 6.0}}, 10.0);
  turn.speed_limit_mps = 20.0 * kmh;
  turn.junction = 2;
  JunctionSurface surface{.boundary = {{-18, -18}, {18, -18}, {18, 18}, {-18, 18}}, .x = -20, .y = -20};
  surface.spacing_m = 0.5, surface.columns = surface.rows = 81;
  for (int r = 0; r < surface.rows; ++r)
    for (int c = 0; c < surface.columns; ++c)
      surface.z.push_back(z(surface.x + c * surface.spacing_m, surface.y + r * surface.spacing_m));
  return {.roads = {turn}, .junctions = {{.id = 2, .surface = surface}}};
}

TEST(JudgeNetwork, a_plane_twists_no_car_that_turns_on_it) {
  const auto twist = static_cast<std::size_t>(FaultKind::twist);
  const NetworkVerdict plane = judge_network(turn_on([](double x, double y) { return 10.0 + 0.12 * x - 0.05 * y; }));
  EXPECT_LT(plane.worst[twist], 1e-6) << "though an axle tilts by 13 % while it turns";
  EXPECT_EQ(places(plane, FaultKind::twist), 0u);
  // A saddle z = a x y twists a car that heads along x or y by a times its wheelbase, one between them not at all.
  constexpr double a = 0.03;
  const NetworkVerdict saddle = judge_network(turn_on([](double x, double y) { return 10.0 + a * x * y; }));
  EXPECT_GT(saddle.worst[twist], 0.8 * a * 2.7);
  EXPECT_LT(saddle.worst[twist], a * 2.7 + 1e-3);
  EXPECT_GT(places(saddle, FaultKind::twist), 0u);
}

TEST(JudgeNetwork, a_twist_of_the_banking) {
  Road road = straight_road(1, 0.0);
  road.superelevation = {{.s = 60.0, .b = 0.1}, {.s = 61.0, .a = 0.1}};
  const NetworkVerdict verdict = judge_network({.roads = {road}});
  ASSERT_GT(places(verdict, FaultKind::twist), 0u);
  for (const Fault& fault : verdict.faults)
    if (fault.kind == FaultKind::twist) EXPECT_NEAR(fault.x, 60.5, 3.5) << "seen from either axle";
}

TEST(JudgeNetwork, a_lane_that_folds_back_over_itself) {
  Road road = straight_road(1, 0.0, 30.0);
  roadquery::test::append(road, 0.5, Spiral{0.0, 0.8});  // the middle of the left lane is 1.75 m off a radius of 1.25 m
  roadquery::test::append(road, 1.0, Arc{0.8});
  const NetworkVerdict verdict = judge_network({.roads = {road}});
  EXPECT_GT(places(verdict, FaultKind::heading_jump), 0u);
}

TEST(JudgeNetwork, a_turn_through_a_junction_is_followed) {
  RoadMap map{.roads = {straight_road(1, 0.0), straight_road(2, 120.0)}};
  Road through = roadquery::test::make_road(3, {0.0, 100.0, 0.0, 0.0, 20.0, Line{}}, 10.0);
  through.junction = 1;
  through.speed_limit_mps = 50.0 * kmh;
  through.sections[0].left.clear();
  through.sections[0].right[0].predecessor = through.sections[0].right[0].successor = -1;
  through.predecessor = {LinkKind::road, 1, ContactPoint::end};
  through.successor = {LinkKind::road, 2, ContactPoint::start};
  map.roads.push_back(through);
  map.roads[0].successor = {LinkKind::junction, 1};
  map.roads[1].predecessor = {LinkKind::junction, 1};
  map.junctions = {{.id = 1, .connections = {{.incoming_road = 1, .connecting_road = 3, .lane_links = {{-1, -1}}}}}};
  NetworkVerdict verdict = judge_network(map);
  EXPECT_TRUE(verdict.pass());
  EXPECT_EQ(verdict.links, 2u);
  map.roads[2].elevation = {{.a = 10.0}, {.s = 10.0, .a = 10.08}};
  expect_fault_at({.roads = {map.roads[2]}}, FaultKind::step, 110.0);
  map.roads[2].elevation = {{.a = 10.08}};
  verdict = judge_network(map);
  EXPECT_EQ(places(verdict, FaultKind::step), 2u) << "on entering and on leaving";
}

TEST(JudgeNetwork, threads_do_not_change_the_verdict) {
  RoadMap map;
  for (int i = 0; i < 8; ++i) {
    map.roads.push_back(straight_road(i + 1, 200.0 * i));
    map.roads.back().elevation.push_back({.s = 40.0, .a = 10.0 + 0.01 * i});
  }
  const NetworkVerdict one = judge_network(map, {.threads = 1}), three = judge_network(map, {.threads = 3});
  ASSERT_EQ(one.faults.size(), three.faults.size());
  EXPECT_GT(one.faults.size(), 5u);
  for (std::size_t i = 0; i < one.faults.size(); ++i) {
    EXPECT_EQ(one.faults[i].value, three.faults[i].value);
    EXPECT_EQ(one.faults[i].x, three.faults[i].x);
  }
  EXPECT_EQ(one.worst, three.worst);
}

}  // namespace
}  // namespace orthodrive
