// SPDX-License-Identifier: Apache-2.0
// The photo is a formula, the picture of the tile is drawn from it with a known shift.
#include "orthodrive/evaluate/scenes/texture_position.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace orthodrive {
namespace {

constexpr int size_px = 960;
constexpr double tile_m = 480.0, tile_west_m = 480.0 * 1000, tile_south_m = 480.0 * 13000;

double brightness(Vec2 p) {
  const double x = p.x - tile_west_m, y = p.y - tile_south_m;
  return 128.0 + 40.0 * std::sin(0.9 * x + 0.3 * y) + 35.0 * std::sin(0.4 * x - 1.1 * y) + 20.0 * std::sin(1.7 * y);
}

/// Its picture lies `shift_px` texels to the east and south of where the photo has it; gain changes its contrast.
SceneTile tile_with(Vec2 shift_px, double gain = 1.0) {
  SceneTile tile{
      .column = 1000, .row = 13000, .origin = {tile_west_m + 0.5 * tile_m, tile_south_m + 0.5 * tile_m, 0.0}};
  tile.texture_rgb = Raster<std::uint8_t>(size_px, size_px, 3);
  const double texel_m = tile_m / size_px;
  for (int row = 0; row < size_px; ++row)
    for (int col = 0; col < size_px; ++col) {
      const Vec2 p{tile_west_m + (col + 0.5 - shift_px.x) * texel_m,
                   tile_south_m + tile_m - (row + 0.5 - shift_px.y) * texel_m};
      const auto value = static_cast<std::uint8_t>(std::lround(128.0 + gain * (brightness(p) - 128.0)));
      for (int channel = 0; channel < 3; ++channel) tile.texture_rgb.at(col, row, channel) = value;
    }
  TriMesh mesh{.kind = MeshKind::terrain};
  mesh.positions = {{-240.0F, -240.0F, 0.0F}, {240.0F, -240.0F, 0.0F}, {0.0F, 240.0F, 0.0F}};
  mesh.uv = {{0.0F, 1.0F}, {1.0F, 1.0F}, {0.5F, 0.0F}};
  mesh.indices = {0, 1, 2};
  tile.meshes = {mesh};
  return tile;
}

TEST(TexturePosition, a_picture_in_its_place_has_no_error) {
  const TexturePosition found = texture_position(tile_with({0.0, 0.0}), brightness);
  EXPECT_EQ(found.windows, 16U);
  EXPECT_LT(found.error_px, 0.01);
}

TEST(TexturePosition, shifts_are_measured_whatever_the_contrast) {
  for (const double gain : {1.0, 0.8})
    for (const Vec2 shift : {Vec2{0.1, 0.0}, Vec2{-0.3, 0.4}, Vec2{1.2, 0.9}})
      EXPECT_NEAR(texture_position(tile_with(shift, gain), brightness).error_px, std::hypot(shift.x, shift.y), 0.02);
}

TEST(TexturePosition, lifted_shadows_do_not_count_but_shifts_do) {
  for (const Vec2 shift : {Vec2{0.0, 0.0}, Vec2{0.3, -0.4}}) {
    SceneTile tile = tile_with(shift);
    // The photo has stripes of shadow, 4 m wide and 60 m apart; the picture has none.
    const auto shaded = [&](Vec2 p) {
      const double share = std::fmod(p.x - tile_west_m, 60.0) < 4.0 ? 0.3 : 1.0;
      return std::optional(share * brightness(p));
    };
    EXPECT_NEAR(texture_position(tile, shaded).error_px, std::hypot(shift.x, shift.y), 0.05);
  }
}

TEST(TexturePosition, wrong_coordinates_of_a_vertex_count) {
  SceneTile tile = tile_with({0.0, 0.0});
  tile.meshes[0].uv[2] = {0.5F + 0.25F / size_px, 0.0F};
  EXPECT_NEAR(texture_position(tile, brightness).error_px, 0.25, 0.02);
}

TEST(TexturePosition, what_shows_nothing_is_not_measured) {
  EXPECT_EQ(texture_position(tile_with({0.0, 0.0}), [](Vec2) { return std::optional(90.0); }).windows, 0U);
  EXPECT_EQ(texture_position(tile_with({0.0, 0.0}), [](Vec2) { return std::optional<double>(); }).windows, 0U);
  EXPECT_EQ(texture_position(SceneTile{}, brightness).windows, 0U);
  // Stripes move along themselves unseen.
  const auto stripes = [](Vec2 p) { return std::optional(128.0 + 80.0 * std::sin(0.8 * (p.x - tile_west_m))); };
  EXPECT_EQ(texture_position(tile_with({0.0, 0.0}), stripes).windows, 0U);
}

}  // namespace
}  // namespace orthodrive
