// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/segment/mirror_beyond.hpp"

#include <gtest/gtest.h>

#include <array>

#include "nets/shipped_model.hpp"
#include "orthodrive/core/random.hpp"
#include "orthodrive/model/rasters/map_alignment.hpp"
#include "orthodrive/segment/segment_mosaic.hpp"

namespace orthodrive {
namespace {

constexpr GridFrame small{500000.0, 6400000.0, 0.5, 5, 4};

TEST(MirrorBeyond, goes_to_and_fro) {
  constexpr std::array<int, 14> of_three{0, 1, 2, 2, 1, 0, 0, 1, 2, 2, 1, 0, 0, 1};  // from -6 on
  for (int i = 0; i < 14; ++i) EXPECT_EQ(mirrored_index(i - 6, 3), of_three[static_cast<std::size_t>(i)]) << i - 6;
  for (int i = -3; i < 4; ++i) EXPECT_EQ(mirrored_index(i, 1), 0);
}

TEST(MirrorBeyond, a_pixel_shows_the_one_that_it_mirrors_in_every_box) {
  Raster<std::uint8_t> whole(small.width, small.height, 3);
  for (std::size_t i = 0; i < whole.data.size(); ++i) whole.data[i] = static_cast<std::uint8_t>(i);
  for (const PixelBox& core : {pixels_of(small), PixelBox{0, 0, 1, 1}, PixelBox{3, 1, 2, 2}, PixelBox{4, 3, 1, 1}})
    for (const int margin : {0, 1, 2, 3, 13}) {
      const PixelBox box = core.grown(margin), part = intersection(box, pixels_of(small));
      Raster<std::uint8_t> inside(part.width, part.height, 3);
      for (int row = 0; row < part.height; ++row)
        for (int col = 0; col < part.width; ++col)
          for (int c = 0; c < 3; ++c)
            inside.at(col, row, c) = whole.at(static_cast<int>(part.col) + col, static_cast<int>(part.row) + row, c);
      const Raster<std::uint8_t> seen = mirror_beyond(inside, box, small);
      for (int row = 0; row < box.height; ++row)
        for (int col = 0; col < box.width; ++col)
          for (int c = 0; c < 3; ++c)
            ASSERT_EQ(seen.at(col, row, c), whole.at(static_cast<int>(mirrored_index(box.col + col, small.width)),
                                                     static_cast<int>(mirrored_index(box.row + row, small.height)), c))
                << margin << ": " << col << ", " << row;
    }
}

TEST(MirrorBeyond, a_mirrored_road_lies_where_its_vectors_say) {
  const GridFrame frame{0.0, 60.0, 1.0, 60, 60};
  const PixelBox box = pixels_of(frame).grown(20);
  // One road near the western edge, one near the southern, and what a mirror makes of them.
  const std::vector<RoadLine> roads{{{{9.25, -100.0}, {9.25, 100.0}}, 2.0}, {{{-100.0, 7.5}, {100.0, 7.5}}, 3.0}};
  std::vector<RoadLine> mirrored = roads;
  mirrored.push_back({{{-9.25, -100.0}, {-9.25, 100.0}}, 2.0});
  mirrored.push_back({{{-100.0, -7.5}, {100.0, -7.5}}, 3.0});
  const Raster<std::uint8_t> seen = mirror_map_beyond(MapLines(roads).read(frame, pixels_of(frame)), box, frame),
                             truth = MapLines(mirrored).read(frame, box);
  // Not beyond the northern and the eastern edge: there the mirror crosses the roads themselves.
  for (int row = 20; row < box.height; ++row)
    for (int col = 0; col < 20 + 60; ++col)
      for (int c = 0; c < map_raster_channels; ++c)
        ASSERT_NEAR(seen.at(col, row, c), truth.at(col, row, c), 1) << col << ", " << row << ", " << c;
  EXPECT_EQ(seen.at(5, 50, 0), 128 + 21);            // 14.5 m west of the edge: 5.25 m to the mirrored road
  EXPECT_EQ(seen.at(70, 20 + 60 + 2, 1), 128 + 20);  // 2.5 m south of the edge: 5 m further south
}

/// Grown by its own size, so that what is mirrored at the edges of the larger photo is the same; a multiple of the 32
/// px that the network is aligned to.
TEST(MirrorBeyond, labels_at_the_edge_are_those_of_a_photo_that_goes_on_mirrored) {
  constexpr int size = 96;
  Photo photo{{"EPSG:32633"},
              {500000.0, 6400000.0, 0.5, size, size},
              Raster<std::uint8_t>(size, size, 3),
              Raster<std::uint8_t>(size, size, 1, 1)};
  Random random(3);
  for (int row = 0; row < size; ++row)
    for (int col = 0; col < size; ++col)
      for (int c = 0; c < 3; ++c)
        photo.rgb.at(col, row, c) = static_cast<std::uint8_t>((col > 20 && col < 40 ? 120
                                                               : c == 1             ? 110
                                                                                    : 75) +
                                                              random.below(20));
  const PixelBox box = pixels_of(photo.frame).grown(size);
  const Photo larger{photo.crs,
                     {500000.0 - 0.5 * size, 6400000.0 + 0.5 * size, 0.5, box.width, box.height},
                     mirror_beyond(photo.rgb, box, photo.frame),
                     Raster<std::uint8_t>(box.width, box.height, 1, 1)};
  const SegmentResult one = segment_mosaic(photo, shipped_model()), other = segment_mosaic(larger, shipped_model());
  for (int row = 0; row < size; ++row)
    for (int col = 0; col < size; ++col)
      ASSERT_NEAR(one.road_probability.confidence.at(col, row),
                  other.road_probability.confidence.at(size + col, size + row), 1)
          << col << ", " << row;
}

}  // namespace
}  // namespace orthodrive
