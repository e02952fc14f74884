// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/model/rasters/map_alignment.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace orthodrive {
namespace {

const GridFrame frame{500000.0, 5500000.0, 0.5, 200, 160};

TEST(MapRaster, PointsFromEveryPixelToTheNearestLine) {
  const std::vector<RoadLine> lines{{{{-10.0, 20.0}, {110.0, 20.0}}, 3.0}, {{{50.0, 60.0}, {50.0, 60.0}}, 0.0}};
  const PixelBox box{0, 0, 100, 90};
  const Raster<NearestLine> nearest = nearest_lines(lines, box);
  const Raster<std::uint8_t> map = map_raster(lines, nearest);
  EXPECT_EQ(map.at(30, 9, 0), 128);
  EXPECT_EQ(map.at(30, 9, 1), 128 + 42);  // 10.5 px below
  EXPECT_EQ(map.at(30, 9, 2), std::lround(255.0 * (1.0 - 10.5 / 32.0)));
  EXPECT_EQ(map.at(30, 9, 3), 24);
  EXPECT_EQ(map.at(52, 60, 0), 128 - 10);  // the point without extent: 2.5 px to the left
  EXPECT_EQ(map.at(52, 60, 3), 0);         // no width told
  EXPECT_EQ(map.at(5, 80, 2), 0);          // out of reach
  EXPECT_EQ(map.at(5, 80, 0), 128);
}

TEST(MapLines, IsTheSameThroughEveryWindow) {
  const MapLines roads({{{{500010.3, 5499990.1}, {500060.7, 5499950.9}, {500088.0, 5499928.0}}, 2.75},
                        {{{500020.0, 5499999.0}, {500021.0, 5499921.0}}, 4.0}});
  const Raster<std::uint8_t> whole = roads.read(frame, {-20, -20, 240, 200});
  for (const PixelBox box : {PixelBox{0, 0, 37, 53}, PixelBox{90, 40, 64, 64}, PixelBox{150, 110, 70, 70}}) {
    const Raster<std::uint8_t> part = roads.read(frame, box);
    for (int row = 0; row < box.height; ++row)
      for (int col = 0; col < box.width; ++col)
        for (int c = 0; c < map_raster_channels; ++c)
          ASSERT_EQ(part.at(col, row, c),
                    whole.at(static_cast<int>(box.col) + 20 + col, static_cast<int>(box.row) + 20 + row, c));
  }
}

TEST(MapLines, OfNoRoadsIsEmpty) {
  EXPECT_TRUE(MapLines({{{{1.0, 2.0}}, 3.0}}).empty());
  const Raster<std::uint8_t> map = MapLines().read(frame, {0, 0, 8, 8});
  EXPECT_EQ(map.at(3, 3, 0), 128);
  EXPECT_EQ(map.at(3, 3, 2), 0);
}

}  // namespace
}  // namespace orthodrive
