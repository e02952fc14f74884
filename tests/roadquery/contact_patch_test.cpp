// SPDX-License-Identifier: Apache-2.0
// The mean plane under a rectangle.

#include "roadquery/query/contact_patch.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "make_road.hpp"

namespace roadquery {
namespace {

using test::make_road;

/// Straight along x from (0, 0), rising by 5 %, the left side 0.04 rad higher.
GroundQuery banked_ramp() {
  RoadMap map;
  Road road = make_road(1, {0.0, 0.0, 0.0, 0.0, 100.0, Line{}}, 1000.0);
  road.elevation[0].b = 0.05;
  road.superelevation = {{.s = 0.0, .a = 0.04}};
  map.roads = {road};
  return GroundQuery(std::move(map));
}

TEST(ContactPatch, OfAPlaneIsThatPlaneInAnyDirection) {
  const GroundQuery ground = banked_ramp();
  for (double heading = -3.0; heading < 3.2; heading += 0.37) {
    Cursor cursor;
    const ContactPatch patch = contact_patch(ground, {50.0, 1.0, 1002.0, heading, 0.6, 0.3, 5, 3}, cursor);
    ASSERT_EQ(patch.place, Place::road);
    const double bank = std::tan(0.04), norm = std::sqrt(1.0 + 0.05 * 0.05 + bank * bank);
    EXPECT_NEAR(patch.z, 1002.5 + bank, 1e-3);  // within the bound of the baked tables
    EXPECT_NEAR(patch.normal[0], -0.05 / norm, 1e-3);
    EXPECT_NEAR(patch.normal[1], -bank / norm, 1e-3);
    EXPECT_NEAR(patch.normal[2], 1.0 / norm, 1e-4);
    EXPECT_LT(patch.residual_m, 1e-4);
    EXPECT_EQ(patch.covered, 1.0);
    EXPECT_FALSE(patch.partial);
  }
}

/// A height t^2 / 10 over t: its least-squares plane over [-w/2, w/2] about t0 has the slope t0 / 5 (the parabola is
/// symmetric about its mean slope) and lies over the centre by the mean of u^2 / 10 of the raster.
TEST(ContactPatch, OfAParabolaIsTheLeastSquaresPlane) {
  RoadMap map;
  Road road = make_road(1, {0.0, 0.0, 0.0, 0.0, 100.0, Line{}}, 0.0);
  road.shape = {{.s = 0.0, .t = -4.0, .a = 1.6, .b = -0.8, .c = 0.1}};
  map.roads = {road};
  const GroundQuery ground(std::move(map));
  Cursor cursor;
  constexpr double t0 = 1.0, width = 2.0;
  const ContactPatch patch = contact_patch(ground, {50.0, t0, 0.0, 0.0, 1.0, width, 3, 4}, cursor);
  double mean = 0.0, mean_square = 0.0;
  for (const double v : {-0.75, -0.25, 0.25, 0.75}) mean += 0.1 * v * v / 4.0;
  for (const double v : {-0.75, -0.25, 0.25, 0.75}) mean_square += std::pow(0.1 * v * v - mean, 2) / 4.0;
  EXPECT_NEAR(patch.z, 0.1 * t0 * t0 + mean, 2e-4);
  EXPECT_NEAR(patch.normal[1] / patch.normal[2], -0.2 * t0, 4e-4);
  EXPECT_NEAR(patch.normal[0], 0.0, 4e-4);
  EXPECT_NEAR(patch.residual_m, std::sqrt(mean_square), 2e-4);
}

TEST(ContactPatch, SaysHowMuchIsOffTheRoad) {
  const GroundQuery ground = banked_ramp();
  Cursor cursor;
  const ContactPatch half = contact_patch(ground, {50.0, 3.497, 1002.5, 0.0, 0.4, 0.4, 4, 4}, cursor);
  EXPECT_EQ(half.place, Place::road);
  EXPECT_TRUE(half.partial);
  EXPECT_EQ(half.covered, 0.5);
  EXPECT_NEAR(half.z, 1002.5 + 3.497 * std::tan(0.04), 2e-3);  // the plane goes on over the part that is missing
  const ContactPatch corner = contact_patch(ground, {50.0, 3.6, 1002.5, 0.0, 0.4, 0.8, 4, 2}, cursor);
  EXPECT_EQ(corner.covered, 0.5);
  EXPECT_EQ(corner.place, Place::none);  // one row of points: a line
  const ContactPatch none = contact_patch(ground, {50.0, 9.0, 1002.5, 0.0, 0.4, 0.4, 4, 4}, cursor);
  EXPECT_EQ(none.place, Place::none);
  EXPECT_EQ(none.covered, 0.0);
  EXPECT_FALSE(std::isnan(none.z));
}

/// Two decks: all points of the patch stay on the one under the centre, though the guess lies nearer to the other for
/// some of them.
TEST(ContactPatch, StaysOnOneDeck) {
  RoadMap map;
  Road low = make_road(1, {0.0, 0.0, 0.0, 0.0, 100.0, Line{}}, 0.0);
  low.elevation[0].b = 0.3;
  map.roads = {low, make_road(2, {0.0, 0.0, 0.0, 0.0, 100.0, Line{}}, 20.0)};
  const GroundQuery ground(std::move(map));
  Cursor cursor;
  const ContactPatch patch = contact_patch(ground, {40.0, 0.0, 12.0 + 3.9, 0.0, 4.0, 2.0, 9, 3}, cursor);
  EXPECT_NEAR(patch.z, 12.0, 1e-3);
  EXPECT_LT(patch.residual_m, 1e-3);
}

}  // namespace
}  // namespace roadquery
