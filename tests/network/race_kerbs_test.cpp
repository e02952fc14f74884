// SPDX-License-Identifier: Apache-2.0
// Kerbs of race tracks drawn by hand, whose curvature is known.

#include "orthodrive/network/paint/race_kerbs.hpp"

#include <gtest/gtest.h>

#include "network_support.hpp"
#include "roadquery/query/road_query.hpp"

namespace orthodrive {
namespace {

using namespace orthodrive::network_test;
using namespace orthodrive::network;
using roadquery::Lane;
using roadquery::LaneType;
using roadquery::Road;

const Lane* kerb_of(const Road& road, bool left) {
  for (const Lane& lane : left ? road.sections[0].left : road.sections[0].right)
    if (lane.type == LaneType::border) return &lane;
  return nullptr;
}

double kerb_width(const Road& road, bool left, double s) {
  const Lane* lane = kerb_of(road, left);
  return lane ? roadquery::lane_width(*lane, s) : 0.0;
}

/// 200 m along x, a quarter turn to the left, 200 m along y.
std::vector<Vec2> corner_of(double radius_m) {
  std::vector<Vec2> line = {{-200, 0}};
  for (const Vec2 p : circle_points({0, radius_m}, radius_m, -M_PI / 2, M_PI / 2)) line.push_back(p);
  line.push_back({radius_m, radius_m + 200});
  return line;
}

PathOptions raceway(std::int64_t id = 1) {
  return {.osm_id = id, .highway = "raceway", .width_m = 12.0, .oneway = Oneway::forward};
}

roadquery::RoadMap built_map(std::vector<RoadPath> paths) { return build_network(network_of(std::move(paths))).map; }

TEST(RaceKerbs, lie_inside_the_bend_and_outside_at_its_exit) {
  const roadquery::RoadMap map = built_map({make_path(corner_of(60.0), {1}, raceway())});
  ASSERT_EQ(map.roads.size(), 1u);
  const Road& road = map.roads[0];
  const double turn_m = 60.0 * M_PI / 2, apex = 200.0 + 0.5 * turn_m, exit = 200.0 + turn_m;
  EXPECT_NEAR(kerb_width(road, true, apex), race_kerb_m, 1e-9) << "on the left, where the bend's middle is";
  EXPECT_EQ(kerb_width(road, false, apex), 0.0);
  EXPECT_NEAR(kerb_width(road, false, exit + 15.0), race_kerb_m, 1e-9);
  EXPECT_EQ(kerb_width(road, true, exit + 25.0), 0.0);
  for (const double s : {50.0, 150.0, exit + 80.0, road.length})
    for (const bool left : {true, false}) EXPECT_EQ(kerb_width(road, left, s), 0.0) << s;
  // Half as tight as the bend, as the mean over 40 m: half of the window lies in the bend.
  double from = 0.0, to = 0.0;
  for (double s = 0.0; s < road.length; s += 0.5)
    if (kerb_width(road, true, s) > 0.0) from = from == 0.0 ? s : from, to = s;
  EXPECT_NEAR(from, 200.0, 4.0);
  EXPECT_NEAR(to, exit, 4.0);
}

TEST(RaceKerbs, rise_to_their_outer_border_and_the_query_feels_them) {
  const roadquery::RoadMap map = built_map({make_path(corner_of(60.0), {1}, raceway())});
  const Road& road = map.roads[0];
  const double s = 200.0 + 15.0 * M_PI;
  const roadquery::Edges edges = roadquery::road_edges(road, s);
  const roadquery::RoadQuery query(map);
  roadquery::Cursor cursor;
  for (const double share : {0.0, 0.25, 0.5, 0.99}) {
    const auto p = roadquery::surface_point(road, s, edges.left_t - race_kerb_m * (1.0 - share));
    const auto hit = query.find(p.x, p.y, p.z, cursor);
    ASSERT_TRUE(hit);
    EXPECT_NEAR(hit->z, race_kerb_rise_m * share, 1e-3) << share;
    if (share > 0.0) {
      EXPECT_EQ(hit->surface, SurfaceClass::concrete);
    }
  }
}

TEST(RaceKerbs, tracks_have_lines_along_their_edges_only) {
  const roadquery::RoadMap map = built_map({make_path(corner_of(60.0), {1}, raceway())});
  const roadquery::LaneSection& section = map.roads[0].sections[0];
  EXPECT_EQ(section.center.marks.at(0).type, "solid");
  std::vector<std::string> types;
  for (const Lane& lane : section.right)
    if (lane.type == LaneType::driving) types.push_back(lane.marks.at(0).type);
  ASSERT_GT(types.size(), 1u) << "12 m hold three lanes";
  EXPECT_EQ(types.back(), "solid");
  types.pop_back();
  for (const std::string& type : types) EXPECT_EQ(type, "none");
}

TEST(RaceKerbs, wide_bends_and_other_roads_have_none) {
  for (const Road& road : built_map({make_path(corner_of(300.0), {1}, raceway())}).roads)
    for (const bool left : {true, false}) EXPECT_EQ(kerb_of(road, left), nullptr);
  PathOptions street = raceway();
  street.highway = "tertiary";
  for (const Road& road : built_map({make_path(corner_of(60.0), {1}, street)}).roads)
    for (const bool left : {true, false}) EXPECT_EQ(kerb_of(road, left), nullptr);
}

TEST(RaceKerbs, tracks_driven_both_ways_have_exits_at_both_ends) {
  PathOptions both = raceway();
  both.oneway = Oneway::no;
  const roadquery::RoadMap map = built_map({make_path(corner_of(60.0), {1}, both)});
  const double exit = 200.0 + 30.0 * M_PI;
  EXPECT_NEAR(kerb_width(map.roads[0], false, exit + 15.0), race_kerb_m, 1e-9);
  EXPECT_NEAR(kerb_width(map.roads[0], false, 185.0), race_kerb_m, 1e-9);
}

/// A ring of two bends of 50 m and two straights, of two ways that meet in the middle of the bends; the second way may
/// run the other way round.
std::vector<RoadPath> ring() {
  std::vector<Vec2> first = circle_points({100, 50}, 50.0, 0.0, M_PI / 2),
                    second = circle_points({-100, 50}, 50.0, M_PI, M_PI / 2);
  for (const Vec2 p : circle_points({-100, 50}, 50.0, M_PI / 2, M_PI / 2)) first.push_back(p);
  for (const Vec2 p : circle_points({100, 50}, 50.0, -M_PI / 2, M_PI / 2)) second.push_back(p);
  std::vector<std::int64_t> ids(std::max(first.size(), second.size()), 0);
  const auto path = [&](const std::vector<Vec2>& line, std::int64_t from, std::int64_t to, std::int64_t id) {
    ids.assign(line.size(), 0), ids.front() = from, ids.back() = to;
    return make_path(line, ids, raceway(id));
  };
  return {path(first, 1, 2, 1), path(second, 2, 1, 2)};
}

TEST(RaceKerbs, go_on_where_two_roads_meet_in_a_bend) {
  const roadquery::RoadMap map = built_map(ring());
  ASSERT_EQ(map.roads.size(), 2u);
  for (const Road& road : map.roads) {
    EXPECT_NEAR(kerb_width(road, true, 0.0), race_kerb_m, 1e-9) << "also across the seam";
    EXPECT_NEAR(kerb_width(road, true, road.length), race_kerb_m, 1e-9);
    const Lane* kerb = kerb_of(road, true);
    ASSERT_TRUE(kerb);
    EXPECT_EQ(kerb->successor, 1);
    EXPECT_EQ(kerb->predecessor, 1);
    EXPECT_EQ(kerb_width(road, true, 0.5 * road.length), 0.0);
  }
}

TEST(RaceKerbs, end_before_other_carriageways) {
  // A pit lane runs along the inner side of the corner, 0.4 m beside the track.
  std::vector<Vec2> pit = {{-150, 9.4}};
  for (const Vec2 p : circle_points({0, 60}, 50.6, -M_PI / 2, M_PI / 2)) pit.push_back(p);
  PathOptions narrow = raceway(2);
  narrow.width_m = 6.0;
  const roadquery::RoadMap map = built_map({make_path(corner_of(60.0), {1}, raceway()), make_path(pit, {5}, narrow)});
  for (const Road& road : map.roads) {
    if (road.osm_id != "1") continue;
    EXPECT_EQ(kerb_width(road, true, 200.0 + 15.0 * M_PI), 0.0);
    EXPECT_GT(kerb_width(road, false, 200.0 + 30.0 * M_PI + 15.0), 1.0) << "nothing on the outer side";
  }
}

}  // namespace
}  // namespace orthodrive
