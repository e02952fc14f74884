// SPDX-License-Identifier: Apache-2.0
// Terrain read in windows: holes are filled the same whichever window shows them.
#include "orthodrive/scene/ground/terrain_windows.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "orthodrive/core/error.hpp"
#include "orthodrive/core/random.hpp"
#include "orthodrive/model/rasters/sample_height.hpp"

namespace orthodrive::scene {
namespace {

constexpr double terrain_west_m = 480'000.0, terrain_north_m = 6'240'000.0, terrain_gsd_m = 2.0;
constexpr int terrain_px = 500;

/// Rough hills with holes of many sizes, one of them as large as several squares of the coarse terrain.
HeightGrid holed_terrain() {
  HeightGrid grid{{},
                  {terrain_west_m, terrain_north_m, terrain_gsd_m, terrain_px, terrain_px},
                  Raster<float>(terrain_px, terrain_px),
                  {}};
  Random random(5);
  for (int row = 0; row < terrain_px; ++row)
    for (int col = 0; col < terrain_px; ++col)
      grid.height_m.at(col, row) =
          static_cast<float>(40.0 + 8.0 * std::sin(0.02 * col) + 5.0 * std::cos(0.03 * row) + random.uniform(0.0, 1.0));
  const auto cut = [&](int col, int row, int size) {
    for (int r = row; r < std::min(terrain_px, row + size); ++r)
      for (int c = col; c < std::min(terrain_px, col + size); ++c) grid.height_m.at(c, r) = std::nanf("");
  };
  cut(130, 140, 210);
  for (int i = 0; i < 60; ++i)
    cut(static_cast<int>(random.uniform(0.0, 480.0)), static_cast<int>(random.uniform(0.0, 480.0)), 1 + i % 30);
  return grid;
}

Outline whole_area() {
  const double size_m = terrain_px * terrain_gsd_m;
  return Outline({{{{terrain_west_m, terrain_north_m - size_m},
                    {terrain_west_m + size_m, terrain_north_m - size_m},
                    {terrain_west_m + size_m, terrain_north_m},
                    {terrain_west_m, terrain_north_m}},
                   {}}},
                 1.0);
}

TEST(TerrainWindows, a_height_is_the_same_in_every_window) {
  const HeightGrid terrain = holed_terrain();
  Findings findings;
  const TerrainWindows windows(source_of(terrain), whole_area(), findings);
  ASSERT_EQ(findings.size(), 1U);
  const HeightGrid whole = windows.window(terrain.frame.bounds());
  ASSERT_EQ(whole.frame, terrain.frame);
  Random random(9);
  for (int i = 0; i < 40; ++i) {
    const double x = terrain_west_m + random.uniform(-50.0, 1000.0),
                 y = terrain_north_m - random.uniform(-50.0, 1000.0);
    const HeightGrid part = windows.window({x, y - random.uniform(1.0, 300.0), x + random.uniform(1.0, 300.0), y});
    ASSERT_FALSE(part.height_m.empty());
    for (int row = 0; row < part.frame.height; ++row)
      for (int col = 0; col < part.frame.width; ++col)
        ASSERT_EQ(part.height_m.at(col, row), whole.height_m.at(col + part.frame.first_col, row + part.frame.first_row))
            << i << ": " << col << " " << row;
  }
}

TEST(TerrainWindows, only_holes_change_and_they_lie_between_the_heights_around) {
  const HeightGrid terrain = holed_terrain();
  Findings findings;
  const TerrainWindows windows(source_of(terrain), whole_area(), findings);
  const HeightGrid whole = windows.window(terrain.frame.bounds());
  std::size_t holes = 0;
  for (std::size_t i = 0; i < whole.height_m.data.size(); ++i) {
    if (!std::isnan(terrain.height_m.data[i])) {
      ASSERT_EQ(whole.height_m.data[i], terrain.height_m.data[i]);
      continue;
    }
    ++holes;
    ASSERT_GE(whole.height_m.data[i], 27.0F);
    ASSERT_LE(whole.height_m.data[i], 54.0F);
  }
  EXPECT_GT(holes, 40'000U);
}

TEST(TerrainWindows, heights_go_on_beyond_the_border) {
  HeightGrid terrain = holed_terrain();
  fill_holes(terrain.height_m);
  Findings findings;
  const TerrainWindows windows(source_of(terrain), whole_area(), findings);
  EXPECT_TRUE(findings.empty());
  EXPECT_NEAR(windows.height_m({terrain_west_m - 400.0, terrain_north_m + 90.0}),
              static_cast<double>(terrain.height_m.at(0, 0)), 1e-6);
  const Vec2 inside{terrain_west_m + 333.25, terrain_north_m - 511.5};
  EXPECT_EQ(windows.height_m(inside), sample_bilinear(terrain, inside));
}

TEST(TerrainWindows, no_height_anywhere_is_an_error) {
  HeightGrid terrain = holed_terrain();
  for (float& z : terrain.height_m.data) z = std::nanf("");
  Findings findings;
  EXPECT_THROW(TerrainWindows(source_of(terrain), whole_area(), findings), InputError);
}

}  // namespace
}  // namespace orthodrive::scene
