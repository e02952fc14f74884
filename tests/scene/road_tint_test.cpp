// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/scene/roads/road_tint.hpp"

#include <gtest/gtest.h>

#include "scene_site.hpp"

namespace orthodrive::scene {
namespace {

using scene_test::south_m, scene_test::west_m;

void paint(Photo& photo, const Box2& box, std::uint8_t value) {
  for (int row = 0; row < photo.frame.height; ++row)
    for (int col = 0; col < photo.frame.width; ++col)
      if (box.contains(photo.frame.center_of(col, row)))
        for (int c = 0; c < 3; ++c) photo.rgb.at(col, row, c) = value;
}

/// A road of 8 m through a photo of 1 m; grass is bright.
scene_test::Site site_with_road() {
  scene_test::Site site =
      scene_test::make_site(480.0, {{.start = {west_m, south_m + 100.0}, .length_m = 400.0, .width_m = 8.0}});
  paint(site.photo, {west_m, south_m, west_m + 480.0, south_m + 480.0}, 200);
  paint(site.photo, {west_m, south_m + 96.0, west_m + 480.0, south_m + 104.0}, 100);
  return site;
}

RoadTint tint_of(const scene_test::Site& site) {
  const RoadLevel level({&site.roads.roads[0]}, site.area, {});
  const RoadLevel* levels[] = {&level};
  return {levels, site.photo};
}

TEST(RoadTint, is_the_linear_colour_of_the_road) {
  const RoadTint tint = tint_of(site_with_road());
  EXPECT_NEAR(tint.at({west_m + 200.0, south_m + 100.0})[1], 0.1274, 1e-3);  // of sRGB 100
}

TEST(RoadTint, cars_and_narrow_shadows_do_not_show) {
  scene_test::Site site = site_with_road();
  paint(site.photo, {west_m + 200.0, south_m + 97.0, west_m + 205.0, south_m + 99.0}, 255);
  paint(site.photo, {west_m + 210.0, south_m + 96.0, west_m + 218.0, south_m + 104.0}, 20);
  const RoadTint tint = tint_of(site);
  for (double x = 190.0; x < 230.0; x += 2.0) EXPECT_NEAR(tint.at({west_m + x, south_m + 100.0})[1], 0.1274, 1e-3) << x;
}

TEST(RoadTint, goes_from_one_surface_to_the_next_without_a_step) {
  scene_test::Site site = site_with_road();
  paint(site.photo, {west_m + 240.0, south_m + 96.0, west_m + 480.0, south_m + 104.0}, 160);
  const RoadTint tint = tint_of(site);
  EXPECT_NEAR(tint.at({west_m + 300.0, south_m + 100.0})[1], 0.3515, 1e-3);
  for (double x = 200.0; x < 280.0; x += 0.5)
    EXPECT_NEAR(tint.at({west_m + x, south_m + 100.0})[1], tint.at({west_m + x + 0.5, south_m + 100.0})[1], 0.02) << x;
}

TEST(RoadTint, asphalt_is_grey_where_the_photo_shows_sand_and_keeps_a_slight_hue) {
  const LinearColor sand = {0.46F, 0.33F, 0.20F}, reddish = {0.22F, 0.20F, 0.18F};
  const LinearColor grey = as_asphalt(sand);
  EXPECT_NEAR(grey[0] + grey[1] + grey[2], sand[0] + sand[1] + sand[2], 1e-5);
  EXPECT_NEAR((grey[0] - grey[2]) / grey[1], asphalt_chroma, 0.01);
  EXPECT_EQ(as_asphalt(reddish), reddish);
  EXPECT_EQ(as_asphalt({}), LinearColor{});
}

TEST(RoadTint, grey_where_nothing_is_known) {
  EXPECT_GT(tint_of(site_with_road()).at({west_m + 200.0, south_m + 400.0})[1], 0.0F);
  scene_test::Site site = site_with_road();
  std::ranges::fill(site.photo.valid.data, std::uint8_t{0});
  const auto none = tint_of(site).at({west_m + 200.0, south_m + 100.0});
  EXPECT_GT(none[1], 0.05F);
  EXPECT_EQ(photo_mean(site.photo, {west_m + 200.0, south_m + 100.0}, 2.0), none);
}

}  // namespace
}  // namespace orthodrive::scene
