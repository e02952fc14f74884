// SPDX-License-Identifier: Apache-2.0
// Humps as heights of the road, and barriers across it.

#include <gtest/gtest.h>

#include "network_support.hpp"
#include "orthodrive/model/roads/traffic_calming.hpp"
#include "orthodrive/network/line/raise_humps.hpp"

namespace orthodrive {
namespace {

using namespace orthodrive::network_test;
using roadquery::Road;
using roadquery::RoadObject;

NodeSign thing(std::int64_t node, NodeSignKind kind, std::string value, bool closed = false) {
  return {.osm_node = node, .kind = kind, .value = std::move(value), .closed = closed};
}
NodeSign hump(std::int64_t node, std::string value) {
  return thing(node, NodeSignKind::traffic_calming, std::move(value));
}

/// A road of 200 m along x on a slope of 3 %; node 5 lies at x = 80.
RoadNetwork sloping_road(std::vector<NodeSign> signs = {}) {
  RoadNetwork roads = network_of(
      {make_path({{0, 0}, {80, 0}, {200, 0}}, {1, 5, 2}, {.height = [](Vec2 p) { return 50.0 + 0.03 * p.x; }})});
  roads.signs = std::move(signs);
  return roads;
}

/// Of the surface over the slope, at x and left of the line by t.
double raised_m(const roadquery::RoadMap& map, double x, double t = 0.0) {
  for (const Road& road : map.roads) {
    const auto begin = roadquery::reference_point(road, 0.0);
    const double s = x - (begin.x - site_origin.x);
    if (road.junction < 0 && s >= 0.0 && s <= road.length)
      return roadquery::surface_height(road, s, t) - (50.0 + 0.03 * x);
  }
  return NAN;
}

std::vector<const RoadObject*> objects_of(const roadquery::RoadMap& map, const std::string& type) {
  std::vector<const RoadObject*> found;
  for (const Road& road : map.roads)
    for (const RoadObject& object : road.objects)
      if (object.type == type) found.push_back(&object);
  return found;
}

bool finds(const NetworkResult& result, const std::string& code) {
  return std::ranges::any_of(result.findings, [&](const Finding& f) { return f.code == code; });
}

TEST(Humps, every_kind_rises_to_its_height_and_down_again) {
  for (const HumpProfile& profile : hump_profiles()) {
    const NetworkResult result = build_network(sloping_road({hump(5, std::string(profile.value))}));
    const double half = 0.5 * profile.length_m();
    double highest = 0.0;
    for (double x = 80.0 - half; x <= 80.0 + half; x += 0.01) highest = std::max(highest, raised_m(result.map, x));
    EXPECT_NEAR(highest, profile.height_m, 2e-3) << profile.value;
    for (const double t : {-2.9, 2.9}) EXPECT_NEAR(raised_m(result.map, 80.0, t), raised_m(result.map, 80.0), 1e-6);
    for (const double x : {80.0 - half - 0.1, 80.0 + half + 0.1}) EXPECT_NEAR(raised_m(result.map, x), 0.0, 1e-3);
    EXPECT_LT(element_gaps(result.map).gradient, 1e-6) << "no kink";
    const auto objects = objects_of(result.map, hump_object);
    ASSERT_EQ(objects.size(), 1u);
    EXPECT_EQ(objects[0]->name, profile.value);
    EXPECT_NEAR(objects[0]->s, 80.0, 0.2);
    EXPECT_NEAR(objects[0]->length, profile.length_m(), 1e-9);
    EXPECT_NEAR(objects[0]->width, 6.0, 0.05);
    const Road& road = result.map.roads.front();
    EXPECT_EQ(hump_speed_mps(road, 80.0), profile.speed_mps);
    EXPECT_EQ(hump_speed_mps(road, 120.0), INFINITY);
  }
}

TEST(Humps, a_way_that_is_a_table_is_raised_along_its_length) {
  const auto height = [](Vec2 p) { return 50.0 + 0.03 * p.x; };
  RoadNetwork roads = network_of({make_path({{0, 0}, {80, 0}}, {1, 5}, {.osm_id = 1, .height = height}),
                                  make_path({{80, 0}, {110, 0}}, {5, 6}, {.osm_id = 2, .height = height}),
                                  make_path({{110, 0}, {200, 0}}, {6, 2}, {.osm_id = 3, .height = height})});
  roads.paths[1].traffic_calming = "table";
  const NetworkResult result = build_network(roads);
  const double height_m = hump_profile("table")->height_m;
  for (const double x : {82.0, 95.0, 108.0}) EXPECT_NEAR(raised_m(result.map, x), height_m, 2e-3) << x;
  for (const double x : {79.0, 111.0}) EXPECT_NEAR(raised_m(result.map, x), 0.0, 2e-3) << x;
  roads.paths[1].traffic_calming.clear(), roads.paths[2].traffic_calming = "hump";
  EXPECT_TRUE(finds(build_network(roads), "network.hump_left_out")) << "somewhere on 90 m";
}

TEST(Humps, junctions_stay_as_they_are) {
  // A side road meets the main one at x = 80; humps on the junction, 3 m beside it and 20 m off.
  const auto build = [](std::vector<NodeSign> signs) {
    RoadNetwork roads = sloping_road(std::move(signs));
    roads.paths[0].nodes[41].osm_node = 7;  // x = 82
    roads.paths.push_back(
        make_path({{80, 0}, {80, 100}}, {5, 3}, {.osm_id = 2, .height = [](Vec2 p) { return 50.0 + 0.03 * p.x; }}));
    return build_network(roads);
  };
  NetworkResult result = build({hump(5, "table")});
  EXPECT_TRUE(finds(result, "network.hump_left_out"));
  EXPECT_TRUE(objects_of(result.map, hump_object).empty());
  const NetworkResult plain = build({});
  result = build({hump(7, "hump")});
  ASSERT_EQ(objects_of(result.map, hump_object).size(), 1u) << "moved into the road";
  for (const Road& road : result.map.roads) {
    const Road* same = road_by_id(plain.map, road.id);
    ASSERT_NE(same, nullptr);
    for (const double s : {0.0, road.length})
      EXPECT_NEAR(roadquery::elevation(road, s), roadquery::elevation(*same, s), 1e-9) << "at the mouths";
    if (road.junction < 0) continue;
    EXPECT_NEAR(roadquery::elevation(road, 0.5 * road.length), roadquery::elevation(*same, 0.5 * road.length), 0.02);
  }
  EXPECT_LT(joint_gaps(result.map).z_m, 0.01);
}

TEST(Humps, short_roads_and_two_in_one_place) {
  RoadNetwork roads = sloping_road({hump(5, "table"), hump(6, "table")});
  roads.paths[0].nodes[42].osm_node = 6;  // x = 84
  NetworkResult result = build_network(roads);
  EXPECT_EQ(objects_of(result.map, hump_object).size(), 1u);
  EXPECT_TRUE(finds(result, "network.hump_left_out"));
  roads = network_of({make_path({{0, 0}, {6, 0}}, {1, 2})});
  roads.signs = {hump(1, "table")};
  result = build_network(roads);
  EXPECT_TRUE(finds(result, "network.hump_left_out")) << "9 m on a road of 6 m";
}

TEST(Humps, closed_rings_have_them_once) {
  std::vector<std::int64_t> ids{1};
  const std::vector<Vec2> circle = circle_points({0, 0}, 40.0, 0.0, 2.0 * M_PI);
  ids.resize(circle.size(), 0);
  ids[circle.size() / 2] = 5, ids.back() = 1;
  RoadNetwork roads = network_of({make_path(circle, ids, {.oneway = Oneway::forward, .roundabout = true})});
  roads.signs = {hump(5, "hump")};
  const NetworkResult result = build_network(roads);
  double highest = 0.0;
  for (const Road& road : result.map.roads)
    for (double s = 0.0; s < road.length; s += 0.05) highest = std::max(highest, roadquery::elevation(road, s));
  EXPECT_NEAR(highest, hump_profile("hump")->height_m, 1e-3);
  EXPECT_EQ(objects_of(result.map, hump_object).size(), 1u);
  EXPECT_LT(joint_gaps(result.map).z_m, 1e-6);
}

TEST(Humps, an_added_hump_is_smooth) {
  std::vector<roadquery::Cubic> profile{{0.0, 1.0, 0.1, 0.0, 0.0}, {11.0, 2.1, 0.1, 0.01, 0.0}};
  const std::vector<roadquery::Cubic> before = profile;
  network::add_hump(profile, 9.0, 2.0, 3.0, 0.08);
  for (double s = 0.0; s < 30.0; s += 0.1) {
    const double rise = network::value_at(profile, s) - network::value_at(before, s);
    const bool on_top = s > 11.0 && s < 14.0, beside = s < 9.0 || s > 16.0;
    EXPECT_NEAR(rise, on_top ? 0.08 : beside ? 0.0 : rise, 1e-12);
    EXPECT_NEAR(network::slope_at(profile, s + 1e-6), network::slope_at(profile, s - 1e-6), 1e-5);
  }
}

TEST(Barriers, stand_across_the_road_and_what_closes_it_is_told) {
  NetworkResult result = build_network(sloping_road({thing(5, NodeSignKind::barrier, "bollard", true)}));
  auto found = objects_of(result.map, "obstacle");
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0]->subtype, "bollard");
  EXPECT_NEAR(found[0]->s, 80.0, 0.2);
  EXPECT_NEAR(found[0]->t, 0.0, 0.05);
  EXPECT_LT(found[0]->width, 0.5);
  EXPECT_GT(found[0]->height, 0.5);
  EXPECT_TRUE(finds(result, "network.barrier_in_the_way"));
  for (const char* value : {"lift_gate", "swing_gate", "something"}) {
    result = build_network(sloping_road({thing(5, NodeSignKind::barrier, value)}));
    found = objects_of(result.map, "barrier");
    ASSERT_EQ(found.size(), 1u) << value;
    EXPECT_EQ(found[0]->subtype, value);
    EXPECT_NEAR(found[0]->width, 6.0, 0.05);
    EXPECT_FALSE(finds(result, "network.barrier_in_the_way"));
  }
  EXPECT_EQ(
      objects_of(build_network(sloping_road({thing(5, NodeSignKind::barrier, "toll_booth")})).map, "gantry").size(),
      1u);
  result = build_network(sloping_road({thing(5, NodeSignKind::barrier, "cattle_grid")}));
  ASSERT_EQ(objects_of(result.map, "barrier").size(), 1u);
  EXPECT_EQ(objects_of(result.map, "barrier")[0]->height, 0.0) << "cars drive over it";
}

TEST(Barriers, at_a_dead_end_beside_another_road) {
  RoadNetwork roads = sloping_road({thing(8, NodeSignKind::barrier, "gate")});
  const auto height = [](Vec2 p) { return 50.0 + 0.03 * p.x; };
  roads.paths.push_back(make_path({{80, 3}, {80, 30}}, {8, 9}, {.osm_id = 2, .highway = "service", .height = height}));
  const NetworkResult result = build_network(roads);
  EXPECT_EQ(objects_of(result.map, "barrier").size(), 1u);
  EXPECT_FALSE(finds(result, "network.barrier_left_out"));
}

}  // namespace
}  // namespace orthodrive
