// SPDX-License-Identifier: Apache-2.0
// Terrain grids, the borders of roads, and the ground between the two.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <limits>
#include <thread>

#include "make_road.hpp"
#include "roadquery/query/ground_query.hpp"

namespace roadquery {
namespace {

using test::append;
using test::make_road;

/// z = 100 + 0.05 x - 0.02 y at the nodes, so everywhere between them.
TerrainGrid plane_grid() {
  TerrainGrid grid{-200.0, -200.0, 10.0, 60, 50, {}};
  for (int row = 0; row < grid.rows; ++row)
    for (int column = 0; column < grid.columns; ++column)
      grid.z.push_back(static_cast<float>(100.0 + 0.05 * (-200.0 + 10.0 * column) - 0.02 * (-200.0 + 10.0 * row)));
  return grid;
}

TEST(TerrainGrid, IsExactOnAPlane) {
  const TerrainGrid grid = plane_grid();
  for (double x = -199.0; x < 380.0; x += 13.7)
    for (double y = -199.0; y < 280.0; y += 11.3) {
      const auto p = evaluate(grid, x, y);
      ASSERT_TRUE(p);
      EXPECT_NEAR(p->z, 100.0 + 0.05 * x - 0.02 * y, 2e-5);
      EXPECT_NEAR(p->dz_dx, 0.05, 1e-5);
      EXPECT_NEAR(p->dz_dy, -0.02, 1e-5);
    }
}

TEST(TerrainGrid, EndsHalfACellBeyondItsHeightsAndAtHoles) {
  TerrainGrid grid{0.0, 0.0, 2.0, 3, 2, {1, 2, 3, 4, 5, 6}};
  EXPECT_DOUBLE_EQ(evaluate(grid, -1.0, -1.0)->z, 1.0);
  EXPECT_DOUBLE_EQ(evaluate(grid, 5.0, 3.0)->z, 6.0);
  EXPECT_DOUBLE_EQ(evaluate(grid, 4.0, 2.0)->z, 6.0);
  for (const auto& [x, y] : {std::pair(-1.01, 0.0), {5.01, 0.0}, {0.0, -1.01}, {0.0, 3.01}})
    EXPECT_FALSE(evaluate(grid, x, y));
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  for (const double bad : {nan, inf, -inf, 1e300}) EXPECT_FALSE(evaluate(grid, bad, 0.0));
  grid.z[4] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_FALSE(evaluate(grid, 1.0, 1.0));
  EXPECT_FALSE(evaluate(grid, 3.0, 1.0));
}

class AscFile : public testing::Test {
 protected:
  std::string write(const std::string& text) {
    const auto path = std::filesystem::path(testing::TempDir()) /
                      (std::string(testing::UnitTest::GetInstance()->current_test_info()->name()) + ".asc");
    std::ofstream(path, std::ios::binary) << text;
    return path.string();
  }
  std::string problem_of(const std::string& text) {
    const std::string path = write(text);
    try {
      (void)read_terrain_grid(path);
    } catch (const std::runtime_error& error) {
      return std::string(error.what()).substr(path.size());
    }
    return "no error";
  }
};

TEST_F(AscFile, IsReadFromItsCornerOrCentreInAnyCase) {
  for (const std::string origin : {"xllcorner 99\nyllcorner 49\n", "XLLCENTER 100\r\nYLLCENTER 50\r\n"}) {
    const TerrainGrid grid =
        read_terrain_grid(write("NCOLS 3\nnrows 2\n" + origin + "cellsize 2\nNODATA_value -9999\n4 5 6\n1 -9999 3\n"));
    EXPECT_EQ(grid.columns, 3);
    EXPECT_EQ(grid.rows, 2);
    EXPECT_DOUBLE_EQ(grid.west, 100.0);
    EXPECT_DOUBLE_EQ(grid.south, 50.0);
    EXPECT_EQ(grid.z[0], 1.0f);
    EXPECT_TRUE(std::isnan(grid.z[1]));
    EXPECT_EQ(grid.z[5], 6.0f);
  }
}

TEST_F(AscFile, IsRefusedWithItsLine) {
  const std::string head = "ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 1\n";
  EXPECT_THAT(problem_of(""), testing::HasSubstr("empty"));
  EXPECT_EQ(problem_of(head + "1 2\n3\n"), ": line 8: a height is missing");
  EXPECT_EQ(problem_of(head + "1 2\n3 4 5\n"), ": line 7: more heights than ncols x nrows");
  EXPECT_EQ(problem_of(head + "1 2\n3 4,5\n"), ": line 7: a height is not a number: 4,5");
  EXPECT_EQ(problem_of("ncols 2\nncols 2\n"), ": line 2: ncols stands twice");
  EXPECT_THAT(problem_of("ncols 2\nnrows 2\nxllcorner 0\ncellsize 1\n1 2 3 4"),
              testing::HasSubstr("yllcorner is missing"));
  EXPECT_THAT(problem_of("ncols 100000\nnrows 10000\nxllcorner 0\nyllcorner 0\ncellsize 1\n1 2\n"),
              testing::HasSubstr("too short"));
  for (const char* bad : {"ncols -2", "ncols 1e99", "ncols 2.5", "ncols nan", "ncols x"})
    EXPECT_NE(problem_of(std::string(bad) + "\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 1\n1 2\n3 4\n"), "no error")
        << bad;
  EXPECT_THAT(problem_of("ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\ndx 1\ndy 2\n1 2\n3 4\n"),
              testing::HasSubstr("dx is not known"));
  EXPECT_THAT(problem_of("ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 0\n1 2\n3 4\n"),
              testing::HasSubstr("positive"));
  EXPECT_THAT(problem_of(std::string("\0\1\2garbage", 10)), testing::HasSubstr(": line 1: "));
}

/// A straight road along x at z = 110 with 2 % slope, crossed by one along y; the terrain lies 5 to 12 m below.
RoadMap crossing() {
  RoadMap map;
  Road along = make_road(1, {0.0, 0.0, 0.0, 0.0, 200.0, Line{}}, 110.0);
  along.elevation[0].b = 0.02;
  map.roads = {along, make_road(2, {0.0, 100.0, -80.0, M_PI / 2.0, 160.0, Line{}}, 112.0)};
  return map;
}

TEST(RoadBorders, AreEdgesAndEndsButNotWhereAnotherRoadGoesOn) {
  const RoadQuery query(crossing());
  const RoadBorders borders(query, 6.0);
  const auto near = borders.nearest(30.0, 7.0);
  ASSERT_TRUE(near);
  EXPECT_NEAR(near->distance_m, 3.5, 1e-9);
  EXPECT_NEAR(near->z, 110.6, 1e-6);
  EXPECT_NEAR(near->dz_dx, 0.02, 1e-6);
  EXPECT_NEAR(near->dz_dy, 0.0, 1e-9);
  EXPECT_FALSE(borders.nearest(30.0, 9.51));
  ASSERT_TRUE(borders.nearest(202.0, 0.0));
  EXPECT_NEAR(borders.nearest(202.0, 0.0)->distance_m, 1.75, 0.05);  // the surface goes on 0.25 m beyond the end
  // The middle of the crossing has none: the corners are the nearest.
  const auto corner = borders.nearest(100.0, 0.0);
  ASSERT_TRUE(corner);
  EXPECT_NEAR(corner->distance_m, 3.5 * std::sqrt(2.0), 0.6);
  EXPECT_FALSE(borders.nearest(1e9, 0.0));
}

TEST(RoadBorders, OfAMapWithoutAnyAreNone) {
  RoadMap map = crossing();
  for (Road& road : map.roads) road.bridge = true;
  const RoadQuery query(map);
  const RoadBorders borders(query, 5.0);
  EXPECT_EQ(borders.segments(), 0u);
  EXPECT_FALSE(borders.nearest(30.0, 7.0));
}

TEST(Ground, MeetsTheRoadAtItsEdgeAndTheTerrainAtTheEndOfTheVerge) {
  const GroundQuery ground(crossing(), plane_grid(), 5.0);
  Cursor cursor;
  for (double x = 1.0; x < 90.0; x += 3.1) {
    const double terrain_at_end = 100.0 + 0.05 * x - 0.02 * 8.5;
    EXPECT_EQ(ground.find(x, 3.499999, 110.0, cursor).place, Place::road);
    const GroundHit beside = ground.find(x, 3.500002, 110.0, cursor), far = ground.find(x, 8.5, 110.0, cursor);
    EXPECT_EQ(beside.place, Place::terrain);
    EXPECT_NEAR(beside.hit.z, 110.0 + 0.02 * x, 1e-6);
    EXPECT_EQ(beside.hit.surface, SurfaceClass::ground);
    EXPECT_NEAR(far.hit.z, terrain_at_end, 2e-5);
    const double middle = ground.find(x, 6.0, 110.0, cursor).hit.z;  // half way: the mean
    EXPECT_NEAR(middle, 0.5 * (110.0 + 0.02 * x + 100.0 + 0.05 * x - 0.12), 2e-5);
  }
}

TEST(Ground, NormalIsThatOfItsHeights) {
  const GroundQuery ground(crossing(), plane_grid(), 5.0);
  Cursor cursor;
  for (double x = -20.3; x < 215.0; x += 4.7) {
    for (double y = -20.1; y < 20.0; y += 1.3) {
      const GroundHit here = ground.find(x, y, 111.0, cursor);
      if (here.place != Place::terrain) continue;
      constexpr double h = 1e-3;
      const auto z = [&](double px, double py) { return ground.find(px, py, 111.0, cursor).hit.z; };
      const double dx = (z(x + h, y) - z(x - h, y)) / (2.0 * h), dy = (z(x, y + h) - z(x, y - h)) / (2.0 * h);
      EXPECT_NEAR(here.hit.normal[0] / here.hit.normal[2], -dx, 0.02) << x << " " << y;
      EXPECT_NEAR(here.hit.normal[1] / here.hit.normal[2], -dy, 0.02) << x << " " << y;
    }
  }
}

TEST(Ground, BelowABridgeTheGuessDecides) {
  RoadMap map = crossing();
  map.roads[1].bridge = true;
  map.roads[1].elevation[0].a = 130.0;
  const GroundQuery ground(std::move(map), plane_grid(), 5.0);
  Cursor cursor;
  EXPECT_EQ(ground.find(100.0, 40.0, 106.0, cursor).place, Place::terrain);
  EXPECT_NEAR(ground.find(100.0, 40.0, 106.0, cursor).hit.z, 104.2, 1e-4);
  EXPECT_EQ(ground.find(100.0, 40.0, 129.0, cursor).place, Place::road);
  EXPECT_EQ(ground.find(100.0, 40.0, std::numeric_limits<double>::quiet_NaN(), cursor).place, Place::road);
  EXPECT_NEAR(ground.find(100.0, 0.0, 112.0, cursor).hit.z, 112.0, 1e-6);  // the road below, not the terrain
}

TEST(Ground, WithoutTerrainIsTheRoads) {
  const GroundQuery ground(crossing());
  Cursor cursor;
  EXPECT_EQ(ground.find(30.0, 6.0, 110.0, cursor).place, Place::none);
  EXPECT_EQ(ground.find(30.0, 1.0, 110.0, cursor).place, Place::road);
  RoadMap map = crossing();
  map.roads[0].junction = 3;
  const GroundQuery turning(std::move(map));
  EXPECT_EQ(turning.find(30.0, 1.0, 110.0, cursor).place, Place::junction);
}

TEST(Ground, PointsOfRoadsAreTheRoadsOwn) {
  const GroundQuery ground(crossing());
  for (double s = 0.5; s < 200.0; s += 2.3) {
    const SurfacePoint point = ground.point(0, s, 1.2);
    Cursor cursor;
    Hit hit;
    ASSERT_EQ(ground.find(point.x, point.y, point.z, cursor = {0, s}, hit_all | hit_own, hit), Place::road);
    EXPECT_EQ(hit.road, 0);
    EXPECT_NEAR(hit.z, point.z, 1e-6);
    EXPECT_NEAR(point.z, surface_point(ground.roads().map().roads[0], s, 1.2).z, 1e-6);
    EXPECT_NEAR(point.x, s, 1e-3);
  }
}

TEST(Ground, AnswersManyThreadsAlike) {
  const GroundQuery ground(crossing(), plane_grid(), 5.0);
  const auto sum = [&](double* out) {
    Cursor cursor;
    double total = 0.0;
    for (int i = 0; i < 20000; ++i) total += ground.find(-20.0 + 0.012 * i, 8.0 * std::sin(i), 110.0, cursor).hit.z;
    *out = total;
  };
  std::array<double, 4> sums{};
  std::vector<std::thread> threads;
  for (double& one : sums) threads.emplace_back(sum, &one);
  for (std::thread& thread : threads) thread.join();
  for (const double one : sums) EXPECT_EQ(one, sums[0]);
}

}  // namespace
}  // namespace roadquery
