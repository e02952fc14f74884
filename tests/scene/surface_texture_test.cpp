// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/scene/look/surface_texture.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "orthodrive/model/rasters/srgb.hpp"
#include "orthodrive/scene/look/leaf_picture.hpp"

namespace orthodrive::scene {
namespace {

double linear(std::uint8_t byte) {
  const double v = byte / 255.0;
  return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
}

class EverySurfaceTexture : public testing::TestWithParam<SurfaceMaterial> {};

/// 256 px, made once for all cases.
const SurfaceTexture& texture_of(SurfaceMaterial material) {
  static std::map<SurfaceMaterial, SurfaceTexture> made;
  if (!made.contains(material)) made.emplace(material, make_surface_texture(material, 256));
  return made.at(material);
}

TEST_P(EverySurfaceTexture, has_the_mean_that_tints_count_on) {
  const SurfaceTexture& texture = texture_of(GetParam());
  for (int channel = 0; channel < 3; ++channel) {
    double sum = 0.0;
    for (int row = 0; row < 256; ++row)
      for (int col = 0; col < 256; ++col) sum += linear(texture.color.at(col, row, channel));
    EXPECT_NEAR(sum / (256.0 * 256.0), surface_texture_mean, 0.1 * (channel == 1 ? 0.1 : 1.0)) << channel;
  }
}

TEST_P(EverySurfaceTexture, goes_on_across_its_edges) {
  const SurfaceTexture& texture = texture_of(GetParam());
  const auto mean_step = [&](int col, int next) {
    double sum = 0.0;
    for (int i = 0; i < 256; ++i) {
      sum += std::abs(texture.color.at(col, i, 1) - texture.color.at(next, i, 1));
      sum += std::abs(texture.color.at(i, col, 1) - texture.color.at(i, next, 1));
    }
    return sum / 512.0;
  };
  double inside = 0.0;
  for (int col = 0; col < 255; ++col) inside = std::max(inside, mean_step(col, col + 1));
  EXPECT_LE(mean_step(255, 0), inside);
}

TEST_P(EverySurfaceTexture, has_unit_normals_that_look_up_on_average_and_no_metal) {
  const SurfaceTexture& texture = texture_of(GetParam());
  double sum_x = 0.0, sum_y = 0.0;
  for (int row = 0; row < 256; ++row) {
    for (int col = 0; col < 256; ++col) {
      const auto part = [&](int c) { return texture.normal_rgb.at(col, row, c) / 127.5 - 1.0; };
      ASSERT_NEAR(std::hypot(part(0), part(1), part(2)), 1.0, 0.02);
      ASSERT_GT(part(2), 0.0);
      sum_x += part(0), sum_y += part(1);
      ASSERT_EQ(texture.roughness.at(col, row, 2), 0);
    }
  }
  EXPECT_NEAR(sum_x / 65536.0, 0.0, 0.01);
  EXPECT_NEAR(sum_y / 65536.0, 0.0, 0.01);
}

INSTANTIATE_TEST_SUITE_P(SurfaceTexture, EverySurfaceTexture,
                         testing::Values(SurfaceMaterial::asphalt, SurfaceMaterial::concrete, SurfaceMaterial::setts,
                                         SurfaceMaterial::gravel, SurfaceMaterial::ground, SurfaceMaterial::verge,
                                         SurfaceMaterial::paint, SurfaceMaterial::facade, SurfaceMaterial::roof_tiles,
                                         SurfaceMaterial::foliage, SurfaceMaterial::balconies,
                                         SurfaceMaterial::cladding, SurfaceMaterial::openings, SurfaceMaterial::lane),
                         [](const auto& info) { return std::string(to_string(info.param)); });

TEST(LeafPicture, has_clusters_with_holes_and_clear_corners) {
  constexpr int size_px = 256;
  const Raster<std::uint8_t> picture = leaf_picture(size_px);
  ASSERT_EQ(picture.channels, 4);
  const auto opaque_share = [&](const PictureBox& box) {
    int opaque = 0, all = 0;
    for (int row = 0; row < size_px; ++row)
      for (int col = 0; col < size_px; ++col) {
        const double u = (col + 0.5) / size_px, v = (row + 0.5) / size_px;
        if (u < box.u0 || u > box.u1 || v < box.v0 || v > box.v1) continue;
        const int alpha = picture.at(col, row, 3);
        EXPECT_TRUE(alpha == 0 || alpha == 255);
        ++all, opaque += alpha == 255 ? 1 : 0;
      }
    return static_cast<double>(opaque) / all;
  };
  EXPECT_EQ(opaque_share(dense_leaves_box), 1.0);
  EXPECT_EQ(opaque_share(bark_box), 1.0);
  for (const PictureBox& box : {broad_leaves_box, small_leaves_box, needles_box}) {
    EXPECT_GT(opaque_share(box), 0.3);
    EXPECT_LT(opaque_share(box), 0.75);
    for (const auto& [u, v] : {std::pair{box.u0, box.v0}, {box.u1 - 0.05, box.v0}, {box.u0, box.v1 - 0.05}})
      EXPECT_EQ(opaque_share({u, v, u + 0.05, v + 0.05}), 0.0);
  }
  double sum = 0.0;
  int opaque = 0;
  for (int row = 0; row < size_px; ++row)
    for (int col = 0; col < size_px; ++col)
      if (picture.at(col, row, 3) == 255)
        sum += static_cast<double>(linear_values()[picture.at(col, row, 1)]), ++opaque;
  EXPECT_NEAR(sum / opaque, surface_texture_mean, 0.02);
  EXPECT_EQ(make_surface_texture(SurfaceMaterial::leaves, 2 * size_px).color.data, picture.data);
}

TEST(SurfaceTexture, is_the_same_each_time) {
  EXPECT_EQ(make_surface_texture(SurfaceMaterial::gravel, 128).color.data,
            make_surface_texture(SurfaceMaterial::gravel, 128).color.data);
}

}  // namespace
}  // namespace orthodrive::scene
