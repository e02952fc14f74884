// SPDX-License-Identifier: Apache-2.0
// Superpixels and their features on photos of two plain colours.

#include "orthodrive/baselines/superpixels.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

namespace orthodrive {
namespace {

/// Grey left of the middle, green right of it.
Raster<std::uint8_t> two_halves(int width, int height) {
  Raster<std::uint8_t> rgb(width, height, 3);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const bool grey = x < width / 2;
      rgb.at(x, y, 0) = grey ? 120 : 60, rgb.at(x, y, 1) = grey ? 120 : 140, rgb.at(x, y, 2) = grey ? 120 : 50;
    }
  return rgb;
}

TEST(Superpixels, do_not_cross_an_edge_and_tell_its_sides_apart) {
  const auto rgb = two_halves(80, 60);
  const Superpixels found = make_superpixels(rgb, {}, 0.25, {});
  ASSERT_GT(found.count, 20);
  ASSERT_EQ(found.features.size(), static_cast<std::size_t>(found.count) * superpixel_features);
  int pixels = 0;
  for (const int n : found.pixels) pixels += n;
  EXPECT_EQ(pixels, 80 * 60);
  std::set<int> left, right;
  for (int y = 0; y < 60; ++y)
    for (int x = 0; x < 80; ++x)
      if (std::abs(x - 40) > 2) (x < 40 ? left : right).insert(found.labels.at(x, y));
  for (const int label : left) EXPECT_FALSE(right.contains(label));
  constexpr int greenness = 3, lightness_spread = 4;
  EXPECT_NEAR(found.features_of(found.labels.at(5, 30))[greenness], 0.0F, 0.01F);
  EXPECT_NEAR(found.features_of(found.labels.at(75, 30))[greenness], (2 * 140 - 60 - 50) / 251.0F, 0.01F);
  EXPECT_NEAR(found.features_of(found.labels.at(5, 30))[lightness_spread], 0.0F, 0.01F);
}

TEST(Superpixels, invalid_pixels_count_in_no_feature) {
  auto rgb = two_halves(80, 60);
  Raster<std::uint8_t> valid(80, 60, 1, 1);
  for (int y = 0; y < 60; ++y)
    for (int x = 60; x < 80; ++x) {
      valid.at(x, y) = 0;
      for (int c = 0; c < 3; ++c) rgb.at(x, y, c) = 255;
    }
  const Superpixels found = make_superpixels(rgb, valid, 0.25, {});
  int pixels = 0;
  for (const int n : found.pixels) pixels += n;
  EXPECT_EQ(pixels, 60 * 60);
  for (const float value : found.features) EXPECT_FALSE(std::isnan(value));
}

TEST(Superpixels, a_photo_too_small_to_cut_is_one_and_an_empty_one_is_none) {
  EXPECT_EQ(make_superpixels(two_halves(8, 8), {}, 0.25, {}).count, 1);
  EXPECT_EQ(make_superpixels({}, {}, 0.25, {}).count, 0);
  EXPECT_EQ(superpixel_px({}, 0.25), 8);
  EXPECT_EQ(superpixel_px({}, 1.0), 6) << "six pixels at least";
}

}  // namespace
}  // namespace orthodrive
