// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "roadquery/make_road.hpp"
#include "roadquery/query/road_query.hpp"

namespace roadquery {
namespace {

using test::append;
using test::make_lane;
using test::make_road;

/// A banked, crowned bend on a slope. Right: a driving lane that widens, a walk of 2 m that rises over 1 m to a kerb of
/// 12 cm, falls to 3 cm at a crossing and is 1 cm higher outside. Left: a driving lane alone.
Road walk_road() {
  Road road = make_road(1, {0.0, 458000.0, 5540000.0, 0.6, 40.0, Line{}}, 200.0);
  append(road, 30.0, Spiral{0.0, 0.03});
  append(road, 30.0, Arc{0.03});
  road.elevation = {{0.0, 200.0, 0.05, -1e-3, 2e-6}};
  road.superelevation = {{0.0, 0.02, 5e-4, 0.0, 0.0}};
  road.shape = {{0.0, -30.0, -0.6, 0.02, 0.0, 0.0}, {0.0, 0.0, 0.0, -0.02, 0.0, 0.0}};
  road.lane_offset = {{0.0, 0.0, 2e-3, 0.0, 0.0}};
  Lane walk = make_lane(-2, 2.0);
  walk.type = LaneType::sidewalk;
  walk.heights = {{5.0, 0.0, 0.0},    {6.0, 0.12, 0.13},  {60.0, 0.12, 0.13},
                  {61.0, 0.03, 0.04}, {64.0, 0.03, 0.04}, {65.0, 0.12, 0.13}};
  road.sections[0].right[0].width = {{0.0, 3.5, 0.005, 0.0, 0.0}};
  road.sections[0].right.push_back(walk);
  return road;
}

RoadMap road_alone(Road road) {
  RoadMap map;
  map.roads = {std::move(road)};
  return map;
}

double right_border_t(const Road& road, double s) { return evaluate(road.lane_offset, s) - 3.5 - 0.005 * s; }

TEST(LaneHeight, is_linear_between_its_entries_and_across_the_lane) {
  const Road road = walk_road();
  Road flat = road;
  flat.sections[0].right[1].heights.clear();
  const auto over = [&](double s, double beside_m) {
    const double t = right_border_t(road, s) - beside_m;
    const double by_point = surface_point(road, s, t).z - surface_point(flat, s, t).z;
    EXPECT_NEAR(surface_height(road, s, t) - surface_height(flat, s, t), by_point, 1e-12);
    return by_point;
  };
  EXPECT_NEAR(over(2.0, 1.0), 0.0, 1e-12);     // before the first entry: as it begins
  EXPECT_NEAR(over(5.5, 0.001), 0.06, 1e-4);   // half way up
  EXPECT_NEAR(over(30.0, 0.001), 0.12, 1e-4);  // the kerb
  EXPECT_NEAR(over(30.0, 1.0), 0.125, 1e-9);   // the middle of the walk
  EXPECT_NEAR(over(62.0, 0.001), 0.03, 1e-4);  // the crossing
  EXPECT_NEAR(over(99.0, 1.999), 0.13, 1e-4);  // after the last entry
  EXPECT_EQ(over(30.0, -0.001), 0.0);          // the driving lane ends where the kerb begins
  EXPECT_EQ(over(30.0, 2.01), 0.0);
}

TEST(LaneHeight, normal_is_the_cross_product_of_numerical_tangents) {
  const Road road = walk_road();
  for (const double s : {5.5, 30.0, 60.4, 80.0}) {
    const double t = right_border_t(road, s) - 0.8, h = 1e-4;
    const SurfacePoint s0 = surface_point(road, s - h, t), s1 = surface_point(road, s + h, t);
    const SurfacePoint t0 = surface_point(road, s, t - h), t1 = surface_point(road, s, t + h);
    const double a[3] = {s1.x - s0.x, s1.y - s0.y, s1.z - s0.z}, b[3] = {t1.x - t0.x, t1.y - t0.y, t1.z - t0.z};
    const double n[3] = {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
    const double norm = std::hypot(n[0], n[1], n[2]);
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(surface_point(road, s, t).normal[i], n[i] / norm, 1e-5) << s;
  }
}

TEST(LaneHeight, the_query_has_the_exact_surface_on_walks_and_beside_them) {
  const RoadQuery query(road_alone(walk_road()));
  const Road& road = query.map().roads[0];
  Cursor cursor;
  for (double s = 0.051; s < road.length; s += 0.17) {
    for (const double beside_m : {-3.0, -0.01, 1e-3, 0.4, 1.2, 1.99}) {
      const double t = right_border_t(road, s) - beside_m;
      const SurfacePoint exact = surface_point(road, s, t);
      const auto hit = query.find(exact.x, exact.y, exact.z, cursor);
      ASSERT_TRUE(hit) << s << ' ' << beside_m;
      EXPECT_EQ(hit->lane_id, beside_m > 0.0 ? -2 : -1);
      EXPECT_NEAR(hit->z, exact.z, 1e-5) << s << ' ' << beside_m;
      for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(hit->normal[k], exact.normal[k], 1e-4) << s << ' ' << beside_m;
      Cursor other;
      EXPECT_NEAR(query.find_height(exact.x, exact.y, exact.z, other).value(), hit->z, 1e-7);
      EXPECT_NEAR(query.at(0, s, t)->z, exact.z, 1e-6);
    }
  }
}

TEST(LaneHeight, driving_lanes_answer_as_without_walks) {
  Road flat = walk_road();
  flat.sections[0].right[1].heights.clear();
  const RoadQuery with(road_alone(walk_road())), without(road_alone(flat));
  for (double s = 0.3; s < 100.0; s += 1.3) {
    for (const double t : {-3.2, -0.5, 2.0}) {
      const SurfacePoint p = surface_point(flat, s, t);
      Cursor a, b;
      const auto one = with.find(p.x, p.y, p.z, a), two = without.find(p.x, p.y, p.z, b);
      ASSERT_TRUE(one && two);
      EXPECT_NEAR(one->z, two->z, 1e-6);
      EXPECT_EQ(one->friction, two->friction);
      for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(one->normal[k], two->normal[k], 1e-5);
    }
  }
}

/// A file with one straight road whose right lane holds `heights`.
RoadMap read_with(const std::string& heights) {
  const auto path = std::filesystem::temp_directory_path() / "orthodrive_lane_height.xodr";
  std::ofstream(path) << R"(<OpenDRIVE><header revMajor="1" revMinor="7"/>
<road id="1" length="20" junction="-1"><planView><geometry s="0" x="0" y="0" hdg="0" length="20"><line/></geometry></planView>
<lanes><laneSection s="0"><center><lane id="0" type="none"/></center><right><lane id="-1" type="sidewalk">
<width sOffset="0" a="2" b="0" c="0" d="0"/>)"
                      << heights << "</lane></right></laneSection></lanes></road></OpenDRIVE>";
  RoadMap map = read_opendrive(path.string());
  std::filesystem::remove(path);
  return map;
}

TEST(LaneHeight, is_read_and_the_last_one_of_a_place_counts) {
  const RoadMap map = read_with(R"(<height sOffset="0" inner=".12" outer=".1"/><height sOffset="4" inner="0"/>)");
  const auto& heights = map.roads[0].sections[0].right[0].heights;
  ASSERT_EQ(heights.size(), 2u);
  EXPECT_EQ(heights[0].inner, 0.12);
  EXPECT_EQ(heights[0].outer, 0.1);
  EXPECT_EQ(heights[1].s_offset, 4.0);
  EXPECT_EQ(heights[1].outer, 0.0);
  const std::string twice = R"(<height sOffset="4" inner="0" outer="0"/><height sOffset="4" inner="1" outer="1"/>)";
  const RoadMap repeated = read_with(twice);
  ASSERT_EQ(repeated.roads[0].sections[0].right[0].heights.size(), 1u);
  EXPECT_EQ(repeated.roads[0].sections[0].right[0].heights[0].inner, 1.0);
}

}  // namespace
}  // namespace roadquery
