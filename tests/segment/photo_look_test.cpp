// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/segment/photo_look.hpp"

#include <gtest/gtest.h>

#include <array>

namespace orthodrive {
namespace {

using Color = std::array<std::uint8_t, 3>;

/// Columns below `split` have the first colour.
Raster<std::uint8_t> two_colors(Color a, Color b, int split) {
  Raster<std::uint8_t> rgb(100, 10, 3);
  for (int row = 0; row < 10; ++row)
    for (int col = 0; col < 100; ++col)
      for (int c = 0; c < 3; ++c) rgb.at(col, row, c) = (col < split ? a : b)[static_cast<std::size_t>(c)];
  return rgb;
}

std::string codes(const Raster<std::uint8_t>& rgb) {
  std::string all;
  const Raster<std::uint8_t> valid(rgb.width, rgb.height, 1, 1);
  for (const Finding& f : judge_look(look_of(rgb, valid, 0, 0, rgb.width, rgb.height), {1.0, 2.0})) all += f.code + " ";
  return all;
}

constexpr Color grass{90, 120, 70}, snow{230, 232, 238}, night{20, 24, 34}, gray{120, 120, 121}, infrared{180, 70, 80};

TEST(PhotoLook, NamesWhatNoTrainingPhotoShows) {
  EXPECT_EQ(codes(two_colors(grass, gray, 60)), "");
  EXPECT_EQ(codes(two_colors(gray, gray, 0)), "segment.gray_photo ");
  EXPECT_EQ(codes(two_colors(night, night, 0)), "segment.dark_photo ");
  EXPECT_EQ(codes(two_colors(snow, grass, 55)), "segment.white_photo ");
  EXPECT_EQ(codes(two_colors(snow, grass, 45)), "");
  EXPECT_EQ(codes(two_colors(infrared, grass, 45)), "segment.infrared_photo ");
  EXPECT_EQ(codes(two_colors(infrared, grass, 35)), "");
}

TEST(PhotoLook, CountsValidPixelsOnceHoweverAPhotoIsCut) {
  const Raster<std::uint8_t> rgb = two_colors(snow, infrared, 30);
  Raster<std::uint8_t> valid(100, 10, 1, 1);
  for (int row = 0; row < 10; ++row) valid.at(0, row) = 0;
  const PhotoLook whole = look_of(rgb, valid, 0, 0, 100, 10);
  PhotoLook sum = look_of(rgb, valid, 0, 0, 37, 10);
  sum += look_of(rgb, valid, 37, 0, 63, 10);
  EXPECT_EQ(whole.pixels, 990);
  EXPECT_EQ(whole.white, 290);
  EXPECT_EQ(whole.red, 700);
  for (const auto member :
       {&PhotoLook::pixels, &PhotoLook::luminance, &PhotoLook::chroma, &PhotoLook::white, &PhotoLook::red})
    EXPECT_EQ(sum.*member, whole.*member);
}

TEST(PhotoLook, SaysNothingOfNoPhoto) { EXPECT_TRUE(judge_look({}, {}).empty()); }

}  // namespace
}  // namespace orthodrive
