// SPDX-License-Identifier: Apache-2.0
// Footprints with right angles out of labels that were painted from known ones.

#include "orthodrive/scene/buildings/label_footprints.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "orthodrive/core/random.hpp"

namespace orthodrive::scene {
namespace {

constexpr std::uint8_t building = 3, green = 4;  // of default_class_table()
constexpr Vec2 corner{500000.0, 5400000.0};

LabelMap bare_ground() {
  LabelMap labels{Crs{"EPSG:32633"}, {corner.x, corner.y + 200.0, 0.5, 400, 400}, {}, default_class_table()};
  labels.labels = Raster<std::uint8_t>(400, 400);
  return labels;
}

Polygon turned(const Ring& ring, Vec2 at, double angle) {
  Polygon polygon;
  for (const Vec2 p : ring)
    polygon.outer.push_back(
        corner + at +
        Vec2{p.x * std::cos(angle) - p.y * std::sin(angle), p.x * std::sin(angle) + p.y * std::cos(angle)});
  return polygon;
}

void paint(LabelMap& labels, const Polygon& polygon, std::uint8_t label = building) {
  fill_polygon(labels.labels, labels.frame, polygon, label);
}

void expect_right_angles(const Polygon& footprint) {
  const auto check = [](const Ring& r) {
    for (std::size_t i = 0; i < r.size(); ++i) {
      const Vec2 a = normalized(r[(i + 1) % r.size()] - r[i]),
                 b = normalized(r[(i + 2) % r.size()] - r[(i + 1) % r.size()]);
      EXPECT_NEAR(dot(a, b) * cross(a, b), 0.0, 1e-6) << "neither straight nor at right angles";
    }
  };
  check(footprint.outer);
  for (const Ring& hole : footprint.holes) check(hole);
}

/// Share of the ground that one of both has alone, by pixels.
double difference(const LabelMap& labels, const Polygon& a, const Polygon& b) {
  Raster<std::uint8_t> in_a(400, 400), in_b(400, 400);
  fill_polygon(in_a, labels.frame, a, std::uint8_t{1});
  fill_polygon(in_b, labels.frame, b, std::uint8_t{1});
  int one = 0, both = 0;
  for (std::size_t i = 0; i < in_a.data.size(); ++i)
    one += in_a.data[i] != in_b.data[i], both += in_a.data[i] & in_b.data[i];
  return static_cast<double>(one) / (both + one);
}

TEST(LabelFootprints, a_turned_rectangle_comes_back_with_four_corners) {
  for (const double angle : {0.0, 0.3, 0.8, 1.3, 2.9}) {
    LabelMap labels = bare_ground();
    const Polygon truth = turned({{-12, -6}, {12, -6}, {12, 6}, {-12, 6}}, {100, 100}, angle);
    paint(labels, truth);
    const auto found = footprints_of_labels(labels, {});
    ASSERT_EQ(found.size(), 1U);
    EXPECT_NEAR(area_m2(found[0].footprint), 288.0, 20.0);
    EXPECT_LT(difference(labels, found[0].footprint, truth), 0.08);
    expect_right_angles(found[0].footprint);
  }
}

TEST(LabelFootprints, an_l_stays_an_l_though_its_border_is_frayed) {
  LabelMap labels = bare_ground();
  const Polygon truth = turned({{0, 0}, {30, 0}, {30, 10}, {10, 10}, {10, 25}, {0, 25}}, {80, 80}, 0.4);
  paint(labels, truth);
  Random random(3);
  for (int i = 0; i < 300; ++i) {  // specks on and off the border
    const auto at = truth.outer[random.below(6)] + Vec2{random.uniform(-3.0, 3.0), random.uniform(-3.0, 3.0)};
    const Vec2 p = labels.frame.pixel_from_world(at);
    labels.labels.at(static_cast<int>(p.x), static_cast<int>(p.y)) = random.below(2) ? building : 0;
  }
  const auto found = footprints_of_labels(labels, {});
  ASSERT_EQ(found.size(), 1U);
  EXPECT_LT(difference(labels, found[0].footprint, truth), 0.15);
  EXPECT_LE(found[0].footprint.outer.size(), 14U);
  expect_right_angles(found[0].footprint);
}

TEST(LabelFootprints, what_the_map_knows_is_not_found_again) {
  LabelMap labels = bare_ground();
  const Polygon known = turned({{0, 0}, {20, 0}, {20, 12}, {0, 12}}, {50, 50}, 0.2);
  paint(labels, turned({{2, 2}, {23, 2}, {23, 14}, {2, 14}}, {50, 50}, 0.2));  // its roof leans
  paint(labels, turned({{0, 0}, {20, 0}, {20, 12}, {0, 12}}, {120, 120}, 0.2));
  const auto found = footprints_of_labels(labels, std::vector<Building>{{.footprint = known}});
  ASSERT_EQ(found.size(), 1U);
  EXPECT_GT(found[0].footprint.outer[0].x, corner.x + 100.0);
}

TEST(LabelFootprints, small_thin_and_ragged_patches_are_no_buildings) {
  LabelMap labels = bare_ground();
  paint(labels, turned({{0, 0}, {6, 0}, {6, 6}, {0, 6}}, {20, 20}, 0.0));    // 36 m2
  paint(labels, turned({{0, 0}, {80, 0}, {80, 3}, {0, 3}}, {20, 50}, 0.3));  // a wall, a pavement
  for (int i = 0; i < 4; ++i) paint(labels, turned({{0, 0}, {40, 0}, {40, 4}, {0, 4}}, {140, 140}, 0.8 * i));  // a star
  paint(labels, turned({{0, 0}, {20, 0}, {20, 20}, {0, 20}}, {150, 40}, 0.0), green);
  EXPECT_TRUE(footprints_of_labels(labels, {}).empty());
  EXPECT_TRUE(footprints_of_labels(bare_ground(), {}).empty());
}

TEST(LabelFootprints, courtyards_stay_open) {
  LabelMap labels = bare_ground();
  paint(labels, turned({{0, 0}, {40, 0}, {40, 40}, {0, 40}}, {60, 60}, 0.0));
  paint(labels, turned({{12, 12}, {28, 12}, {28, 28}, {12, 28}}, {60, 60}, 0.0), 0);
  const auto found = footprints_of_labels(labels, {});
  ASSERT_EQ(found.size(), 1U);
  ASSERT_EQ(found[0].footprint.holes.size(), 1U);
  EXPECT_NEAR(area_m2(found[0].footprint), 1600.0 - 256.0, 80.0);
  expect_right_angles(found[0].footprint);
}

TEST(LabelFootprints, a_map_that_is_all_building_is_one) {
  LabelMap labels = bare_ground();
  std::ranges::fill(labels.labels.data, building);
  EXPECT_EQ(footprints_of_labels(labels, {}).size(), 1U);
  std::ranges::fill(labels.labels.data, label_nodata);
  EXPECT_TRUE(footprints_of_labels(labels, {}).empty());
}

}  // namespace
}  // namespace orthodrive::scene
