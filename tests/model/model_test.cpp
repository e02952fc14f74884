// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "orthodrive/core/error.hpp"
#include "orthodrive/model/rasters/sample_height.hpp"
#include "orthodrive/model/roads/road_network.hpp"

namespace orthodrive {
namespace {

HeightGrid grid_of(double (*height)(Vec2)) {
  HeightGrid grid{.frame = {1000.0, 2000.0, 10.0, 12, 9}};
  grid.height_m = Raster<float>(12, 9);
  for (int row = 0; row < 9; ++row)
    for (int col = 0; col < 12; ++col)
      grid.height_m.at(col, row) = static_cast<float>(height(grid.frame.center_of(col, row)));
  return grid;
}

TEST(SampleHeight, bilinear_and_cubic_reproduce_a_plane) {
  const HeightGrid grid = grid_of([](Vec2 p) { return 0.3 * (p.x - 1000.0) - 0.2 * (p.y - 2000.0) + 5.0; });
  for (const Vec2 p : {Vec2{1033.3, 1961.7}, Vec2{1005.0, 1995.0}, Vec2{1115.0, 1915.0}}) {
    const double expected = 0.3 * (p.x - 1000.0) - 0.2 * (p.y - 2000.0) + 5.0;
    EXPECT_NEAR(sample_bilinear(grid, p), expected, 1e-4);
    EXPECT_NEAR(sample_cubic(grid, p), expected, 1e-4);
  }
}

TEST(SampleHeight, cubic_convolution_reproduces_a_parabola_and_bilinear_does_not) {
  const HeightGrid grid = grid_of([](Vec2 p) { return (p.x - 1050.0) * (p.x - 1050.0) / 100.0; });
  const Vec2 p{1060.0, 1955.0};  // half way between two centres
  EXPECT_NEAR(sample_cubic(grid, p), 1.0, 1e-4);
  EXPECT_NEAR(sample_bilinear(grid, p), 1.25, 1e-4);
}

TEST(SampleHeight, holes_and_the_outside_are_nan) {
  HeightGrid grid = grid_of([](Vec2) { return 7.0; });
  grid.height_m.at(5, 4) = std::numeric_limits<float>::quiet_NaN();
  EXPECT_TRUE(std::isnan(sample_bilinear(grid, grid.frame.center_of(5, 4))));
  EXPECT_TRUE(std::isnan(sample_bilinear(grid, grid.frame.center_of(5, 4) + Vec2{3.0, 3.0})));
  EXPECT_NEAR(sample_cubic(grid, grid.frame.center_of(3, 4)), 7.0,
              1e-6);  // the hole is in the 4 x 4 only: bilinear serves
  EXPECT_TRUE(std::isnan(sample_bilinear(grid, {0.0, 0.0})));
  EXPECT_TRUE(std::isnan(sample_bilinear(grid, {std::nan(""), 1955.0})));
}

TEST(SampleHeight, merging_takes_the_best_grid_that_has_a_height) {
  HeightGrid coarse = grid_of([](Vec2) { return 7.0; }), fine{.frame = {1040.0, 1990.0, 2.0, 10, 10}};
  fine.height_m = Raster<float>(10, 10, 1, 9.0f);
  fine.height_m.at(5, 5) = std::numeric_limits<float>::quiet_NaN();
  const std::vector<HeightGrid> best_first{fine, coarse};
  const HeightSource source = merged_source(best_first, coarse.frame.bounds());
  const HeightGrid merged{.frame = source.frame, .height_m = source.read(pixels_of(source.frame))};
  EXPECT_EQ(merged.frame.gsd_m, 2.0);
  EXPECT_NEAR(sample_bilinear(merged, {1045.0, 1985.0}), 9.0, 1e-6);
  EXPECT_NEAR(sample_bilinear(merged, fine.frame.center_of(5, 5)), 7.0, 1e-6);
  EXPECT_NEAR(sample_bilinear(merged, {1090.0, 1930.0}), 7.0, 1e-6);
}

TEST(ClassTable, roles_round_trip_and_unknown_is_an_option_error) {
  for (const ClassInfo& info : default_class_table().classes)
    EXPECT_EQ(role_from_string(to_string(info.role)), info.role);
  EXPECT_THROW((void)role_from_string("street"), OptionError);
}

TEST(RoadNetwork, default_widths_grow_with_lanes_and_footways_are_not_drivable) {
  EXPECT_LT(default_width_m("residential", 0, Oneway::forward), default_width_m("residential", 0, Oneway::no));
  EXPECT_LT(default_width_m("primary", 2, Oneway::no), default_width_m("primary", 4, Oneway::no));
  EXPECT_TRUE(is_drivable("service"));
  EXPECT_FALSE(is_drivable("footway"));
  EXPECT_GT(road_rank("primary"), road_rank("service"));
}

TEST(RoadNetwork, surface_of_a_straight_path_has_length_times_width) {
  RoadPath path;
  for (int i = 0; i <= 10; ++i) path.nodes.push_back({.p = {500000.0 + 2.0 * i, 6400000.0 + 1.0 * i}, .width_m = 6.0});
  EXPECT_NEAR(std::abs(signed_area_m2(surface_ring(path))), 10.0 * std::sqrt(5.0) * 6.0, 1e-6);
}

}  // namespace
}  // namespace orthodrive
