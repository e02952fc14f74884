// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "orthodrive/scene/ground/ground_surface.hpp"
#include "scene_site.hpp"

namespace orthodrive::scene {
namespace {

using scene_test::make_road;
using scene_test::south_m;
using scene_test::west_m;

constexpr float hole = std::numeric_limits<float>::quiet_NaN();

Vec2 at(double x, double y) { return {west_m + x, south_m + y}; }

/// Roads along y = 100 m on terrain of 12 m that rises to the east.
struct GroundSite {
  std::vector<roadquery::Road> roads, bridges;
  RoadLevel level;
  std::vector<RoadLevel> decks;

  explicit GroundSite(std::vector<roadquery::Road> on_ground, std::vector<roadquery::Road> above = {})
      : roads(std::move(on_ground)), bridges(std::move(above)) {
    const auto level_of = [](const std::vector<roadquery::Road>& all) {
      std::vector<const roadquery::Road*> pointers;
      for (const roadquery::Road& road : all) pointers.push_back(&road);
      return RoadLevel(pointers, {scene_test::square(west_m, south_m, 300.0), {}}, {.reach_m = 6.0});
    };
    level = level_of(roads);
    if (!bridges.empty()) decks.push_back(level_of(bridges));
  }
  Waters waters;  // none
  [[nodiscard]] Ground ground() const {
    HeightGrid terrain;
    terrain.frame = covering_grid({west_m, south_m, west_m + 300.0, south_m + 300.0}, 5.0);
    terrain.height_m = Raster<float>(terrain.frame.width, terrain.frame.height);
    for (int row = 0; row < terrain.frame.height; ++row)
      for (int col = 0; col < terrain.frame.width; ++col)
        terrain.height_m.at(col, row) = static_cast<float>(terrain_m(terrain.frame.center_of(col, row)));
    return {std::move(terrain), level, decks, waters, {.verge_m = 5.0, .deck_clearance_m = 1.1}};
  }
  static double terrain_m(Vec2 p) { return 12.0 + 0.01 * (p.x - west_m); }
};

TEST(Ground, is_the_road_on_it_the_terrain_beyond_the_verge_and_smooth_between) {
  const GroundSite site({make_road(1, {.start = at(50, 100), .z_m = 10.0})});
  const Ground ground = site.ground();
  EXPECT_NEAR(ground.height_m(at(100, 100)), 10.0, 1e-6);
  EXPECT_NEAR(ground.height_m(at(100, 102.9)), 10.0, 1e-6);
  EXPECT_NEAR(ground.height_m(at(100, 108.1)), 13.0, 1e-5);   // terrain
  EXPECT_NEAR(ground.height_m(at(100, 105.5)), 11.5, 1e-5);   // half way
  EXPECT_NEAR(ground.height_m(at(100, 103.01)), 10.0, 1e-3);  // no step at the edge
  for (double y = 103.0, before = 10.0; y < 110.0; y += 0.1) {
    const double z = ground.height_m(at(100, y));
    EXPECT_GE(z, before - 1e-9) << y;
    before = z;
  }
}

TEST(Ground, its_normal_is_that_of_the_slope) {
  const GroundSite site({});
  const Vec3 normal = site.ground().normal(at(150, 150));
  EXPECT_NEAR(normal.x, -0.01 / std::hypot(1.0, 0.01), 1e-6);
  EXPECT_NEAR(normal.y, 0.0, 1e-6);
  EXPECT_NEAR(normal.z, 1.0 / std::hypot(1.0, 0.01), 1e-6);
}

TEST(Ground, beyond_the_terrain_model_its_border_value_goes_on) {
  const GroundSite site({});
  const Ground ground = site.ground();
  EXPECT_EQ(ground.terrain_m(at(-1000, 50)), ground.terrain_m(at(0, 50)));
}

TEST(Ground, keeps_clear_of_a_deck_less_near_the_road_that_leads_onto_it) {
  const GroundSite site(
      {make_road(1, {.start = at(50, 100), .length_m = 50.0, .z_m = 11.0})},
      {make_road(2, {.start = at(100, 100), .length_m = 60.0, .z_m = 11.0, .layer = 1, .bridge = true})});
  const Ground ground = site.ground();
  EXPECT_NEAR(ground.height_m(at(130, 100)), 11.0 - 1.1, 1e-6);         // terrain of 13.3 m is cut away
  EXPECT_NEAR(ground.height_m(at(101, 100)), 11.0 - 0.05 - 0.3, 1e-6);  // 1 m from the abutment
  EXPECT_NEAR(ground.height_m(at(130, 110)), GroundSite::terrain_m(at(130, 110)), 1e-5);
}

TEST(FillHoles, takes_heights_from_around_and_leaves_the_others) {
  Raster<float> heights(9, 9, 1, 5.0F);
  heights.at(4, 4) = heights.at(5, 4) = heights.at(0, 0) = hole;
  heights.at(8, 8) = 50.0F;
  fill_holes(heights);
  EXPECT_EQ(heights.at(4, 4), 5.0F);
  EXPECT_EQ(heights.at(0, 0), 5.0F);
  EXPECT_EQ(heights.at(8, 8), 50.0F);
}

TEST(FillHoles, one_height_fills_everything_and_none_fills_nothing) {
  Raster<float> heights(7, 5, 1, hole);
  fill_holes(heights);
  for (const float v : heights.data) EXPECT_TRUE(std::isnan(v));
  heights.at(6, 0) = 3.0F;
  fill_holes(heights);
  for (const float v : heights.data) EXPECT_EQ(v, 3.0F);
}

TEST(FillHoles, lies_between_the_heights_around) {
  Raster<float> heights(32, 8);
  for (int row = 0; row < 8; ++row)
    for (int col = 0; col < 32; ++col) heights.at(col, row) = col < 12 ? 10.0F : col < 20 ? hole : 20.0F;
  fill_holes(heights);
  for (int col = 12; col < 20; ++col) {
    EXPECT_GE(heights.at(col, 4), 10.0F) << col;
    EXPECT_LE(heights.at(col, 4), 20.0F) << col;
    EXPECT_GE(heights.at(col, 4), heights.at(col - 1, 4) - 1e-4F) << col;
  }
}

}  // namespace
}  // namespace orthodrive::scene
