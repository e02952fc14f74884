// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/scene/ground/photo_shadows.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "orthodrive/core/random.hpp"
#include "orthodrive/model/rasters/srgb.hpp"

namespace orthodrive::scene {
namespace {

constexpr int size_px = 600;
constexpr double gsd_m = 0.5;
constexpr LinearColor sunlight = {0.10F, 0.10F, 0.10F}, skylight = {0.010F, 0.013F, 0.022F},
                      haze = {0.004F, 0.005F, 0.010F};
enum Label : std::uint8_t { ground = 0, road = 1, vegetation = 4, water = 6 };

/// A road from west to east between ground, trees in the north and a lake in the south. Everything west of `shade_px`
/// lies in the shadow. The same grain of up to a tenth everywhere.
struct Site {
  Photo photo;
  LabelMap labels;
  explicit Site(int shade_px, const LinearColor& in_shade = skylight) {
    const GridFrame frame{1000.0, 2000.0, gsd_m, size_px, size_px};
    photo = {.frame = frame,
             .rgb = Raster<std::uint8_t>(size_px, size_px, 3),
             .valid = Raster<std::uint8_t>(size_px, size_px, 1, 1)};
    labels = {.frame = frame, .labels = Raster<std::uint8_t>(size_px, size_px), .classes = default_class_table()};
    for (int row = 0; row < size_px; ++row) {
      for (int col = 0; col < size_px; ++col) {
        const Label label = row < 100 ? vegetation : row >= 500 ? water : row >= 200 && row < 400 ? road : ground;
        labels.labels.at(col, row) = label;
        const LinearColor color = of(label, col < shade_px ? in_shade : sunlight);
        Random random(derive_seed(static_cast<std::uint64_t>(row), static_cast<std::uint64_t>(col)));
        const auto grain = static_cast<float>(random.uniform(0.9, 1.1));
        for (std::size_t c = 0; c < 3; ++c)
          photo.rgb.at(col, row, static_cast<int>(c)) = srgb_byte(static_cast<double>(grain * color[c] + haze[c]));
      }
    }
  }
  static LinearColor of(Label label, const LinearColor& light) {
    LinearColor albedo = {2.2F, 2.2F, 2.0F};
    if (label == ground) albedo = {1.4F, 1.6F, 0.9F};
    if (label == vegetation) albedo = {0.4F, 0.6F, 0.3F};
    if (label == water) return {0.002F, 0.003F, 0.004F};
    for (std::size_t c = 0; c < 3; ++c) albedo[c] *= light[c];
    return albedo;
  }
  [[nodiscard]] std::optional<PhotoShadows> shadows() const {
    return find_shadows(source_of(photo), source_of(labels));
  }
  [[nodiscard]] Photo lifted() const {
    const PixelBox all = pixels_of(photo.frame);
    PhotoWindow window = without_shadows(source_of(photo), source_of(labels), *shadows()).read(all);
    return {.frame = photo.frame, .rgb = std::move(window.rgb), .valid = std::move(window.valid)};
  }
};

LinearColor mean(const Photo& photo, int first_col, int first_row, int length_px = 60) {
  LinearColor sum{};
  for (int row = first_row; row < first_row + length_px; ++row)
    for (int col = first_col; col < first_col + length_px; ++col)
      for (std::size_t c = 0; c < 3; ++c) sum[c] += linear_values()[photo.rgb.at(col, row, static_cast<int>(c))];
  for (float& v : sum) v /= static_cast<float>(length_px * length_px);
  return sum;
}

TEST(PhotoShadows, gains_are_sunlight_over_skylight) {
  const auto shadows = Site(250).shadows();
  ASSERT_TRUE(shadows);
  for (const Label label : {road, ground})
    for (std::size_t c = 0; c < 3; ++c)
      // The lake is not black: what it reflects is taken for haze.
      EXPECT_NEAR(shadows->classes[label].gain[c] / (sunlight[c] / skylight[c]), 1.0, 0.15) << int{label} << " " << c;
  for (const Label label : {vegetation, water}) EXPECT_FALSE(shadows->classes[label].is_lifted());
}

TEST(PhotoShadows, ground_in_the_shadow_looks_as_in_the_sun) {
  const Photo photo = Site(250).lifted();
  for (const int row : {270, 130, 430}) {
    const LinearColor was_dark = mean(photo, 100, row), lit = mean(photo, 400, row);
    for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(was_dark[c] / lit[c], 1.0, 0.12) << row << " " << c;
  }
}

TEST(PhotoShadows, what_lies_in_the_sun_stays) {
  const Site site(250);
  const Photo photo = site.lifted();
  for (int row = 0; row < size_px; ++row)
    for (int col = 260; col < size_px; ++col)
      for (int c = 0; c < 3; ++c)
        ASSERT_EQ(photo.rgb.at(col, row, c), site.photo.rgb.at(col, row, c)) << col << " " << row;
}

TEST(PhotoShadows, water_and_trees_stay_dark) {
  const Site site(250);
  const Photo photo = site.lifted();
  for (int row : {10, 40, 520, 580})
    for (int col = 0; col < size_px; ++col)
      for (int c = 0; c < 3; ++c)
        ASSERT_EQ(photo.rgb.at(col, row, c), site.photo.rgb.at(col, row, c)) << col << " " << row;
}

TEST(PhotoShadows, none_where_the_photo_has_none) {
  EXPECT_FALSE(Site(0).shadows());
  // Darker, but not bluer: old and new asphalt.
  EXPECT_FALSE(Site(250, {0.02F, 0.02F, 0.02F}).shadows());
}

TEST(PhotoShadows, dark_crops_in_the_sun_stay) {
  Site site(250);
  for (int row = 420; row < 480; ++row) {
    for (int col = 300; col < 500; ++col) {
      const LinearColor crop = {0.012F, 0.040F, 0.017F};  // as dark as ground in the shadow, and as little red
      for (std::size_t c = 0; c < 3; ++c)
        site.photo.rgb.at(col, row, static_cast<int>(c)) = srgb_byte(static_cast<double>(crop[c]));
    }
  }
  const Photo photo = site.lifted();
  for (int row = 425; row < 475; ++row)
    for (int col = 305; col < 495; ++col)
      for (int c = 0; c < 3; ++c)
        ASSERT_EQ(photo.rgb.at(col, row, c), site.photo.rgb.at(col, row, c)) << col << " " << row;
}

TEST(PhotoShadows, a_pixel_is_the_same_in_every_box) {
  const Site site(250);
  const PhotoSource source = without_shadows(source_of(site.photo), source_of(site.labels), *site.shadows());
  const Photo whole = site.lifted();
  for (const PixelBox box : {PixelBox{240, 300, 17, 9}, PixelBox{-5, -5, 30, 30}, PixelBox{590, 495, 40, 200}}) {
    const PhotoWindow part = source.read(box);
    for (int row = 0; row < box.height; ++row) {
      for (int col = 0; col < box.width; ++col) {
        const int c = static_cast<int>(box.col) + col, r = static_cast<int>(box.row) + row;
        ASSERT_EQ(part.valid.at(col, row) != 0, whole.valid.inside(c, r));
        for (int k = 0; whole.valid.inside(c, r) && k < 3; ++k)
          ASSERT_EQ(part.rgb.at(col, row, k), whole.rgb.at(c, r, k)) << c << " " << r;
      }
    }
  }
}

TEST(PhotoShadows, an_empty_photo_has_none) {
  const Photo photo;
  LabelMap labels;
  labels.classes = default_class_table();
  EXPECT_FALSE(find_shadows(source_of(photo), source_of(labels)));
}

}  // namespace
}  // namespace orthodrive::scene
