// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/train/disturb_photo.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>

namespace orthodrive {
namespace {

using RgbRaster = Raster<std::uint8_t>;

RgbRaster uniform_photo(int size, std::array<std::uint8_t, 3> color) {
  RgbRaster photo(size, size, 3);
  for (std::size_t i = 0; i < photo.data.size(); ++i) photo.data[i] = color[i % 3];
  return photo;
}

RgbRaster noisy_photo(int width, int height) {
  Random random(3);
  RgbRaster photo(width, height, 3);
  for (std::uint8_t& value : photo.data) value = static_cast<std::uint8_t>(random.below(256));
  return photo;
}

double mean_difference(const RgbRaster& a, const RgbRaster& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.data.size(); ++i) sum += std::abs(a.data[i] - b.data[i]);
  return sum / static_cast<double>(a.data.size());
}

std::array<int, 3> first_pixel(const RgbRaster& photo) { return {photo.data[0], photo.data[1], photo.data[2]}; }

TEST(ChangeColors, no_change_keeps_every_byte) {
  RgbRaster photo = noisy_photo(40, 30);
  const RgbRaster before = photo;
  change_colors(photo, {});
  EXPECT_EQ(photo.data, before.data);
}

TEST(ChangeColors, saturation_0_is_the_mean_of_the_channels) {
  RgbRaster photo = uniform_photo(4, {30, 90, 180});
  change_colors(photo, {.saturation = 0.0});
  EXPECT_EQ(first_pixel(photo), (std::array{100, 100, 100}));
}

TEST(ChangeColors, a_third_of_a_turn_moves_red_to_green) {
  RgbRaster photo = uniform_photo(4, {200, 90, 20});
  change_colors(photo, {.hue_rad = 2.0 * std::numbers::pi / 3.0});
  EXPECT_EQ(first_pixel(photo), (std::array{20, 200, 90}));
}

TEST(ChangeColors, gain_gamma_and_contrast_follow_their_formula) {
  RgbRaster photo = uniform_photo(4, {64, 64, 64});
  change_colors(photo, {.contrast = 0.8, .gamma = 1.5, .gain = {1.0, 0.5, 8.0}});
  const double value = std::pow(0.8 * (64 / 255.0 - 0.5) + 0.5, 1.5);
  EXPECT_EQ(first_pixel(photo), (std::array{static_cast<int>(std::lround(255 * value)),
                                            static_cast<int>(std::lround(127.5 * value)), 255}));
}

TEST(FadeGreen, takes_what_green_has_above_the_others) {
  RgbRaster lawn = uniform_photo(4, {60, 120, 40});  // 70 above the mean of red and blue
  fade_green(lawn, 1.0);
  EXPECT_EQ(first_pixel(lawn), (std::array{95, 50, 40}));
  RgbRaster asphalt = uniform_photo(4, {90, 88, 95});
  fade_green(asphalt, 1.0);
  EXPECT_EQ(first_pixel(asphalt), (std::array{90, 88, 95}));
}

TEST(AddHaze, mixes_and_ends_in_air_light) {
  RgbRaster half = uniform_photo(4, {0, 0, 255}), all = half;
  add_haze(half, 0.5);
  add_haze(all, 1.0);
  EXPECT_EQ(first_pixel(half), (std::array{100, 105, 240}));
  EXPECT_EQ(first_pixel(all), (std::array{200, 210, 225}));
}

TEST(Sharpen, steepens_an_edge_and_keeps_areas) {
  RgbRaster photo = uniform_photo(16, {100, 100, 100});
  for (int row = 0; row < 16; ++row)
    for (int col = 8; col < 16; ++col)
      for (int c = 0; c < 3; ++c) photo.at(col, row, c) = 140;
  sharpen(photo, 1.0);
  EXPECT_EQ(photo.at(3, 8, 0), 100);
  EXPECT_EQ(photo.at(12, 8, 0), 140);
  EXPECT_EQ(photo.at(7, 8, 0), 90);  // a quarter of the step is blurred to each side
  EXPECT_EQ(photo.at(8, 8, 0), 150);
}

TEST(Compress, keeps_areas_and_loses_more_at_lower_quality) {
  RgbRaster flat = uniform_photo(32, {120, 70, 200});
  const RgbRaster flat_before = flat;
  compress(flat, 90);
  EXPECT_LE(mean_difference(flat, flat_before), 1.5);
  const RgbRaster noise = noisy_photo(48, 48);
  double last = 0.0;
  for (const int quality : {95, 60, 20}) {
    RgbRaster photo = noise;
    compress(photo, quality);
    const double lost = mean_difference(photo, noise);
    EXPECT_GT(lost, last + 2.0) << quality;
    last = lost;
  }
}

TEST(Compress, luminance_of_the_best_quality_is_exact_to_rounding) {
  RgbRaster grey = noisy_photo(32, 32);
  for (std::size_t i = 0; i < grey.data.size(); ++i) grey.data[i] = grey.data[i - i % 3];
  RgbRaster photo = grey;
  compress(photo, 100);  // steps of 1 in frequencies: errors of at most 1/2 each, orthonormal, so about 0.3 per pixel
  EXPECT_LT(mean_difference(photo, grey), 0.6);
}

TEST(Compress, cells_do_not_touch_each_other_and_odd_borders_work) {
  const RgbRaster before = noisy_photo(37, 21);
  RgbRaster changed = before;
  for (int c = 0; c < 3; ++c) changed.at(20, 5, c) ^= 128;  // in the cell of 16 x 16 px at (16, 0)
  RgbRaster a = before, b = changed;
  compress(a, 50), compress(b, 50);
  for (int row = 0; row < 21; ++row)
    for (int col = 0; col < 37; ++col) {
      if (col >= 16 && col < 32 && row < 16) continue;
      for (int c = 0; c < 3; ++c) ASSERT_EQ(a.at(col, row, c), b.at(col, row, c)) << col << "," << row;
    }
  EXPECT_NE(a.data, b.data);
}

TEST(CastShadow, darkens_the_parallelogram_whichever_way_it_is_spanned) {
  for (const bool swapped : {false, true}) {
    RgbRaster photo = uniform_photo(40, {200, 200, 200});
    const Vec2 a{10.0, 0.0}, b{0.0, 6.0};
    cast_shadow(photo, {{5.0, 8.0}, swapped ? b : a, swapped ? a : b, 0.4});
    int dark = 0;
    for (int row = 0; row < 40; ++row)
      for (int col = 0; col < 40; ++col) {
        if (photo.at(col, row, 0) == 200) continue;
        ++dark;
        EXPECT_TRUE(col >= 5 && col < 15 && row >= 8 && row < 14);
        EXPECT_EQ(photo.at(col, row, 0), 80);
        EXPECT_EQ(photo.at(col, row, 2), 98) << "the sky is blue";
      }
    EXPECT_EQ(dark, 60);
  }
  RgbRaster photo = uniform_photo(8, {200, 200, 200});
  cast_shadow(photo, {{2.0, 2.0}, {3.0, 3.0}, {1.0, 1.0}, 0.1});  // no area
  EXPECT_EQ(photo.data, uniform_photo(8, {200, 200, 200}).data);
}

TEST(DisturbDomain, repeats_for_a_seed_and_does_nothing_at_strength_0) {
  const RgbRaster photo = noisy_photo(64, 64);
  const auto disturbed = [&](double strength, std::uint64_t seed) {
    RgbRaster result = photo;
    Random random(seed);
    disturb_domain(result, strength, random);
    return result;
  };
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    EXPECT_EQ(disturbed(0.0, seed).data, photo.data);
    EXPECT_EQ(disturbed(1.0, seed).data, disturbed(1.0, seed).data);
    EXPECT_NE(disturbed(1.0, seed).data, disturbed(1.0, seed + 1).data);
  }
  double weak = 0.0, strong = 0.0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    weak += mean_difference(disturbed(0.3, seed), photo);
    strong += mean_difference(disturbed(1.0, seed), photo);
  }
  EXPECT_GT(strong, 1.3 * weak);
}

}  // namespace
}  // namespace orthodrive
