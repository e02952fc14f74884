// SPDX-License-Identifier: Apache-2.0
// What io writes for simulators is what the road query, and GDAL, read.

#include "roadquery/query/terrain_grid.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "orthodrive/io/raster/raster_io.hpp"
#include "orthodrive/io/raster/terrain_grid_io.hpp"
#include "orthodrive/io/support/gdal_support.hpp"
#include "orthodrive/model/rasters/sample_height.hpp"
#include "places.hpp"
#include "scratch.hpp"

namespace orthodrive {
namespace {

HeightGrid hills() {
  HeightGrid grid{utm33, {500000.25, 5540010.5, 0.75, 31, 17}, Raster<float>(31, 17), ""};
  for (int row = 0; row < 17; ++row)
    for (int col = 0; col < 31; ++col)
      grid.height_m.at(col, row) = static_cast<float>(400.0 + 3.0 * std::sin(0.4 * col) + 0.2 * row);
  return grid;
}

TEST(TerrainGridFile, HasTheSameHeightsEverywhere) {
  const Scratch scratch;
  HeightGrid grid = hills();
  grid.height_m.at(4, 6) = std::numeric_limits<float>::quiet_NaN();
  io::write_terrain_grid(scratch / "terrain.asc", grid);
  const roadquery::TerrainGrid read = roadquery::read_terrain_grid((scratch / "terrain.asc").string());
  const Box2 box = grid.frame.bounds();
  int known = 0;
  for (double x = box.min_x + 0.4; x < box.max_x - 0.4; x += 0.31)
    for (double y = box.min_y + 0.4; y < box.max_y - 0.4; y += 0.29) {
      const double expected = sample_bilinear(grid, {x, y});
      const auto found = roadquery::evaluate(read, x, y);
      ASSERT_EQ(found.has_value(), !std::isnan(expected)) << x << " " << y;
      if (!found) continue;
      EXPECT_NEAR(found->z, expected, 6e-4);
      ++known;
    }
  EXPECT_GT(known, 2000);
}

TEST(TerrainGridFile, IsOneForGdal) {
  const Scratch scratch;
  const HeightGrid grid = hills();
  io::write_terrain_grid(scratch / "terrain.asc", grid);
  const io::DatasetPtr dataset = io::open_dataset(scratch / "terrain.asc", GDAL_OF_RASTER);
  double place[6];
  ASSERT_EQ(dataset->GetGeoTransform(place), CE_None);
  EXPECT_DOUBLE_EQ(place[0], grid.frame.west_m);
  EXPECT_DOUBLE_EQ(place[3], grid.frame.north_m);
  float z = 0.0f;
  ASSERT_EQ(dataset->GetRasterBand(1)->RasterIO(GF_Read, 7, 3, 1, 1, &z, 1, 1, GDT_Float32, 0, 0), CE_None);
  EXPECT_NEAR(z, grid.height_m.at(7, 3), 6e-4f);
}

}  // namespace
}  // namespace orthodrive
