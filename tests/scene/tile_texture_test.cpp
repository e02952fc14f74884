// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/scene/tiles/tile_texture.hpp"

#include <gtest/gtest.h>

namespace orthodrive::scene {
namespace {

constexpr int grey = 128;  // of texels far from any photo

/// 8 x 8 pixels of 1 m with their north-west corner at (0, 8); red counts columns, green rows, blue is 200.
Photo small_photo() {
  Photo photo;
  photo.frame = {0.0, 8.0, 1.0, 8, 8};
  photo.rgb = Raster<std::uint8_t>(8, 8, 3, 200);
  photo.valid = Raster<std::uint8_t>(8, 8, 1, 1);
  for (int row = 0; row < 8; ++row)
    for (int col = 0; col < 8; ++col) {
      photo.rgb.at(col, row, 0) = static_cast<std::uint8_t>(10 * col);
      photo.rgb.at(col, row, 1) = static_cast<std::uint8_t>(10 * row);
    }
  return photo;
}

TEST(TileTexture, at_the_photos_resolution_pixels_are_copied) {
  const Photo photo = small_photo();
  const auto texture = tile_texture(photo, {0, 0, 8, 8}, 64);
  ASSERT_EQ(texture.width, 8);
  EXPECT_EQ(texture.data, photo.rgb.data);
}

TEST(TileTexture, coarser_texels_are_means_of_their_pixels) {
  const auto texture = tile_texture(small_photo(), {0, 0, 8, 8}, 4);
  ASSERT_EQ(texture.width, 4);
  EXPECT_EQ(texture.at(0, 0, 0), 5);   // of columns 0 and 1
  EXPECT_EQ(texture.at(3, 1, 0), 65);  // of columns 6 and 7
  EXPECT_EQ(texture.at(3, 1, 1), 25);  // of rows 2 and 3
  EXPECT_EQ(texture.at(3, 1, 2), 200);
}

TEST(TileTexture, pixels_count_by_the_area_they_share_with_a_texel) {
  const auto texture = tile_texture(small_photo(), {0.25, 0, 8.25, 8}, 8);
  EXPECT_EQ(texture.at(0, 0, 0), 3);   // 0.75 * 0 + 0.25 * 10, rounded
  EXPECT_EQ(texture.at(4, 0, 0), 43);  // 0.75 * 40 + 0.25 * 50, rounded
  EXPECT_EQ(texture.at(7, 0, 0), 70);  // only a part of the texel has a photo
}

TEST(TileTexture, holes_take_the_colour_of_their_neighbourhood_for_four_texels_and_are_grey_beyond) {
  const auto texture = tile_texture(small_photo(), {0, 0, 16, 16}, 16);  // the photo is its south-west quarter
  ASSERT_EQ(texture.width, 16);
  EXPECT_EQ(texture.at(7, 12, 0), 70);
  EXPECT_EQ(texture.at(8, 12, 0), 70);
  EXPECT_EQ(texture.at(11, 12, 0), 70);
  EXPECT_EQ(texture.at(11, 12, 2), 200);
  EXPECT_EQ(texture.at(12, 12, 0), grey);
  EXPECT_EQ(texture.at(0, 3, 2), grey);
  EXPECT_EQ(texture.at(0, 4, 2), 200);
}

TEST(TileTexture, invalid_pixels_do_not_count) {
  Photo photo = small_photo();
  photo.valid.at(0, 0) = 0;
  EXPECT_EQ(tile_texture(photo, {0, 0, 8, 8}, 4).at(0, 0, 0), 7);  // (10 + 0 + 10) / 3, rounded
}

TEST(TileTexture, without_any_photo_there_is_no_texture) {
  EXPECT_TRUE(tile_texture(small_photo(), {100, 100, 108, 108}, 8).empty());
  Photo photo = small_photo();
  photo.valid = Raster<std::uint8_t>(8, 8, 1, 0);
  EXPECT_TRUE(tile_texture(photo, {0, 0, 8, 8}, 8).empty());
}

TEST(TileLabels, are_those_at_the_middles_of_texels_and_nodata_outside) {
  LabelMap map;
  map.frame = {0.0, 8.0, 1.0, 8, 8};
  map.labels = Raster<std::uint8_t>(8, 8, 1, 1);
  map.labels.at(3, 0) = 7;
  const auto labels = tile_labels(map, {2, 0, 10, 8}, 64);
  ASSERT_EQ(labels.width, 8);
  EXPECT_EQ(labels.at(1, 0), 7);
  EXPECT_EQ(labels.at(0, 0), 1);
  EXPECT_EQ(labels.at(5, 0), 1);
  EXPECT_EQ(labels.at(6, 0), label_nodata);
}

}  // namespace
}  // namespace orthodrive::scene
