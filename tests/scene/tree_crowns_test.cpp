// SPDX-License-Identifier: Apache-2.0
// Crowns in painted woods.

#include "orthodrive/scene/plants/tree_crowns.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "orthodrive/core/random.hpp"

namespace orthodrive::scene {
namespace {

constexpr std::uint8_t vegetation = 4;  // of default_class_table()
constexpr Vec2 crown_corner{500000.0, 5400000.0};
constexpr int crown_px = 400;

struct Wood {
  LabelMap labels{Crs{"EPSG:32633"},
                  {crown_corner.x, crown_corner.y + 0.5 * crown_px, 0.5, crown_px, crown_px},
                  Raster<std::uint8_t>(crown_px, crown_px),
                  default_class_table()};
  Photo photo{labels.crs, labels.frame, Raster<std::uint8_t>(crown_px, crown_px, 3, 40),
              Raster<std::uint8_t>(crown_px, crown_px, 1, 1)};

  /// A dome of leaves: bright in the middle, dark at its border.
  void plant(const TreeCrown& crown) {
    for (int row = 0; row < crown_px; ++row) {
      for (int col = 0; col < crown_px; ++col) {
        const double share = distance(labels.frame.center_of(col, row), crown.at) / crown.radius_m;
        if (share > 1.0) continue;
        labels.labels.at(col, row) = vegetation;
        for (int c = 0; c < 3; ++c)
          photo.rgb.at(col, row, c) = static_cast<std::uint8_t>(40.0 + 120.0 * std::sqrt(1.0 - share * share));
      }
    }
  }
};

const TreeCrown* crown_near(const std::vector<TreeCrown>& crowns, Vec2 p) {
  const auto found = std::ranges::min_element(crowns, {}, [&](const TreeCrown& c) { return distance(c.at, p); });
  return found == crowns.end() ? nullptr : &*found;
}

TEST(TreeCrowns, single_trees_have_their_place_and_size) {
  Wood wood;
  const std::vector<TreeCrown> truth = {{crown_corner + Vec2{30, 30}, 5.2},
                                        {crown_corner + Vec2{60, 31.3}, 4.2},
                                        {crown_corner + Vec2{90.7, 30}, 3.3},
                                        {crown_corner + Vec2{120, 30.4}, 2.5},
                                        {crown_corner + Vec2{150, 30}, 1.8}};
  for (const TreeCrown& crown : truth) wood.plant(crown);
  const auto found = find_crowns(wood.labels, wood.photo);
  EXPECT_EQ(found.size(), truth.size());
  for (const TreeCrown& crown : truth) {
    const TreeCrown* near = crown_near(found, crown.at);
    ASSERT_NE(near, nullptr);
    EXPECT_LT(distance(near->at, crown.at), 1.0) << crown.radius_m;
    EXPECT_NEAR(near->radius_m, crown.radius_m, 0.5);
  }
}

TEST(TreeCrowns, a_closed_wood_is_taken_apart_at_its_bright_tops) {
  Wood wood;
  std::ranges::fill(wood.labels.labels.data, vegetation);
  std::vector<Vec2> tops;
  Random random(5);
  for (int y = 0; y < 10; ++y)
    for (int x = 0; x < 10; ++x)
      tops.push_back(crown_corner +
                     Vec2{50.0 + 9.0 * x + random.uniform(-1.0, 1.0), 50.0 + 9.0 * y + random.uniform(-1.0, 1.0)});
  for (const Vec2 top : tops) wood.plant({top, 4.5});
  const auto found = find_crowns(wood.labels, wood.photo);
  int near = 0;
  for (const Vec2 top : tops) near += distance(crown_near(found, top)->at, top) < 1.5 ? 1 : 0;
  EXPECT_GE(near, 90);
}

TEST(TreeCrowns, crowns_overlap_by_a_fifth_at_most) {
  Wood wood;
  std::ranges::fill(wood.labels.labels.data, vegetation);
  Random random(6);
  for (std::uint8_t& v : wood.photo.rgb.data) v = static_cast<std::uint8_t>(random.below(256));
  const auto found = find_crowns(wood.labels, wood.photo);
  EXPECT_GT(found.size(), 300U);
  EXPECT_LT(found.size(), 4000U);
  for (std::size_t i = 0; i < found.size(); ++i)
    for (std::size_t k = 0; k < i; ++k)
      ASSERT_GE(distance(found[i].at, found[k].at), 0.8 * (found[i].radius_m + found[k].radius_m) - 1e-9);
}

TEST(TreeCrowns, no_vegetation_no_tree) {
  Wood wood;
  for (int row = 0; row < crown_px; ++row) wood.labels.labels.at(100, row) = vegetation;  // a hedge of half a metre
  EXPECT_TRUE(find_crowns(wood.labels, wood.photo).empty());
  std::ranges::fill(wood.labels.labels.data, label_nodata);
  EXPECT_TRUE(find_crowns(wood.labels, wood.photo).empty());
}

TEST(TreeCrowns, a_photo_that_is_not_there_does_not_matter_for_single_trees) {
  Wood wood;
  wood.plant({crown_corner + Vec2{100, 100}, 4.2});
  std::ranges::fill(wood.photo.valid.data, std::uint8_t{0});
  const auto found = find_crowns(wood.labels, wood.photo);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_LT(distance(found[0].at, crown_corner + Vec2{100, 100}), 1.0);
}

}  // namespace
}  // namespace orthodrive::scene
