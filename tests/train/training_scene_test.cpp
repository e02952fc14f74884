// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/train/training_scene.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <set>
#include <utility>

#include "orthodrive/core/error.hpp"
#include "orthodrive/segment/resample_photo.hpp"
#include "train/toy_scene.hpp"

namespace orthodrive {
namespace {

TEST(DrawCrop, repeats_for_a_seed_and_keeps_labels_with_their_pixels) {
  TrainingScene scene = toy_scene();
  const Crop a = draw_crop(scene, {.size_px = 64, .gsd_m = 0.5}, 7),
             b = draw_crop(scene, {.size_px = 64, .gsd_m = 0.5}, 7);
  EXPECT_EQ(a.rgb.data, b.rgb.data);
  EXPECT_EQ(a.allowed.data, b.allowed.data);
  EXPECT_NE(a.rgb.data, draw_crop(scene, {.size_px = 64, .gsd_m = 0.5}, 8).rgb.data);
  // Wherever the crop was taken, bright pixels are the square: compare in the middle of the two colours.
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Crop crop = draw_crop(scene, {.size_px = 64, .gsd_m = 0.5}, seed);
    double bright = 0.0, dark = 0.0, bright_count = 0.0, dark_count = 0.0;
    for (std::size_t i = 0; i < crop.allowed.data.size(); ++i) {
      if (crop.allowed.data[i] == only(1)) bright += crop.rgb.data[3 * i], bright_count += 1.0;
      if (crop.allowed.data[i] == only(0)) dark += crop.rgb.data[3 * i], dark_count += 1.0;
    }
    if (bright_count < 50.0 || dark_count < 50.0) continue;
    EXPECT_GT(bright / bright_count, dark / dark_count + 60.0) << seed;
  }
}

/// How red (to the right in the photo) and green (downwards) change along the columns and rows of a crop.
std::optional<std::array<int, 4>> orientation_of(const Crop& crop) {
  const int from = 8, step = 12;
  for (const auto [col, row] : {std::pair(from, from), {from + step, from}, {from, from + step}})
    if (crop.allowed.at(col, row) == unknown_class) return std::nullopt;
  std::array<int, 4> result{};
  for (int c = 0; c < 2; ++c) {
    const double here = crop.rgb.at(from, from, c);
    const auto rate = [&](int col, int row) {
      return static_cast<int>(std::round((crop.rgb.at(col, row, c) - here) / step));
    };
    result[static_cast<std::size_t>(2 * c)] = rate(from + step, from);
    result[static_cast<std::size_t>(2 * c) + 1] = rate(from, from + step);
  }
  return result;
}

TEST(DrawCrop, quarters_and_mirroring_give_the_eight_copies_of_the_thesis) {
  TrainingScene scene{
      .name = "ramp", .rgb = Raster<std::uint8_t>(96, 96, 3), .allowed = Raster<ClassSet>(96, 96, 1, only(0))};
  for (int row = 0; row < 96; ++row)
    for (int col = 0; col < 96; ++col) {
      scene.rgb.at(col, row, 0) = static_cast<std::uint8_t>(2 * col);
      scene.rgb.at(col, row, 1) = static_cast<std::uint8_t>(2 * row);
    }
  scene.gsd_m = 0.5;
  for (const bool mirror : {true, false}) {
    const Augmentation of_thesis{.turn = Augmentation::Turn::quarters,
                                 .mirror = mirror,
                                 .zoom = false,
                                 .colors = false,
                                 .blur = false,
                                 .noise = false};
    std::set<std::array<int, 4>> found;
    for (std::uint64_t seed = 1; seed <= 200; ++seed)
      if (const auto one =
              orientation_of(draw_crop(scene, {.size_px = 32, .gsd_m = 0.5, .augmentation = of_thesis}, seed)))
        found.insert(*one);
    std::set<std::array<int, 4>> expected{{2, 0, 0, 2}, {0, 2, -2, 0}, {-2, 0, 0, -2}, {0, -2, 2, 0}};
    if (mirror) expected.insert({{-2, 0, 0, 2}, {0, -2, -2, 0}, {2, 0, 0, -2}, {0, 2, 2, 0}});
    EXPECT_EQ(found, expected) << mirror;
  }
}

TEST(DrawCrop, averages_what_is_finer_than_the_crop) {
  // Squares of 1 px, black and white: a crop pixel covers 25 of them.
  TrainingScene scene{
      .name = "fine", .rgb = Raster<std::uint8_t>(400, 400, 3), .allowed = Raster<ClassSet>(400, 400, 1, only(0))};
  for (int row = 0; row < 400; ++row)
    for (int col = 0; col < 400; ++col)
      for (int c = 0; c < 3; ++c) scene.rgb.at(col, row, c) = (row + col) % 2 == 0 ? 255 : 0;
  scene.gsd_m = 0.1;
  const Augmentation plain{.turn = Augmentation::Turn::none, .colors = false, .blur = false, .noise = false};
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const Crop crop = draw_crop(scene, {.size_px = 32, .gsd_m = 0.5, .augmentation = plain}, seed);
    for (std::size_t i = 0; i < crop.allowed.data.size(); ++i) {
      if (crop.allowed.data[i] == unknown_class) continue;     // beyond the photo
      ASSERT_NEAR(crop.rgb.data[3 * i], 127.5, 15.0) << seed;  // an odd sample at the most
    }
  }
}

TEST(DrawCrop, keeps_the_map_on_its_roads) {
  TrainingScene scene{.name = "mapped",
                      .rgb = Raster<std::uint8_t>(200, 200, 3, 90),
                      .allowed = Raster<ClassSet>(200, 200, 1, only(0))};
  for (int row = 0; row < 200; ++row)
    for (int col = 0; col < 200; ++col)
      if (std::abs(row - col - 30) < 4) scene.allowed.at(col, row) = only(1);
  scene.map = {{{{-100.0, -70.0}, {300.0, 330.0}}, 3.0},
               {{{900.0, 0.0}, {900.0, 200.0}}, 3.0}};  // in its middle; far off
  int on_road = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Crop crop = draw_crop(scene, {.size_px = 64, .gsd_m = 0.5}, seed);
    ASSERT_LE(crop.map.size(), 1U);
    if (crop.map.empty()) continue;
    EXPECT_GT(crop.map[0].half_width, 3.0 * 0.79);
    EXPECT_LT(crop.map[0].half_width, 3.0 * 1.26);
    for (double s = 0.0; s < length_m(crop.map[0].points); s += 1.0) {
      const Vec2 p = point_at(crop.map[0].points, s);
      const int col = static_cast<int>(std::floor(p.x)), row = static_cast<int>(std::floor(p.y));
      if (!crop.allowed.inside(col, row) || crop.allowed.at(col, row) == unknown_class) continue;
      ASSERT_EQ(crop.allowed.at(col, row), only(1)) << seed;
      ++on_road;
    }
  }
  EXPECT_GT(on_road, 200);
}

TEST(DrawCrop, beyond_the_photo_is_grey_or_the_photo_mirrored) {
  TrainingScene scene = toy_scene();
  int grey_crops = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    const Crop crop = draw_crop(scene, {.size_px = 128, .gsd_m = 0.5, .augmentation = {.domain = 1.0}}, seed);
    std::size_t beyond = 0;
    for (std::size_t i = 0; i < crop.allowed.data.size(); ++i) {
      if (crop.allowed.data[i] != unknown_class) continue;
      ++beyond;
      for (std::size_t c = 0; c < 3; ++c) ASSERT_EQ(crop.rgb.data[3 * i + c], no_photo_value);
    }
    if (beyond == 0) continue;  // mirrored: all of it has labels
    EXPECT_GT(beyond, 100u);
    ++grey_crops;
  }
  EXPECT_GT(grey_crops, 8);
  EXPECT_LT(grey_crops, 32);
  scene.map = {
      {{{0.0, 10.0}, {100.0, 10.0}}, 3.0}};  // a map of its own goes on as it is, a mirrored photo would not fit
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const Crop crop = draw_crop(scene, {.size_px = 128, .gsd_m = 0.5}, seed);
    EXPECT_GT(std::ranges::count(crop.allowed.data, unknown_class), 100) << seed;
  }
}

TEST(DrawScene, follows_weights_and_first_steps) {
  std::vector<TrainingScene> scenes(3, TrainingScene{});
  scenes[0].weight = 3.0, scenes[1].weight = 1.0, scenes[2].weight = 100.0, scenes[2].from_step = 50;
  int counts[3] = {0, 0, 0};
  for (std::uint64_t seed = 0; seed < 4000; ++seed) ++counts[draw_scene(scenes, 49, seed)];
  EXPECT_EQ(counts[2], 0);
  EXPECT_NEAR(counts[0], 3000, 120);
  int late = 0;
  for (std::uint64_t seed = 0; seed < 100; ++seed) late += draw_scene(scenes, 50, seed) == 2 ? 1 : 0;
  EXPECT_GT(late, 85);
  EXPECT_THROW(static_cast<void>(draw_scene({}, 0, 1)), OptionError);
}

}  // namespace
}  // namespace orthodrive
