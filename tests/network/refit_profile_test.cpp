// SPDX-License-Identifier: Apache-2.0
// Profiles of connecting roads on surfaces of which the heights are known.

#include "orthodrive/network/junctions/refit_profile.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "roadquery/make_road.hpp"
#include "roadquery/surface/junction_surface.hpp"

namespace orthodrive::network {
namespace {

using roadquery::JunctionSurface;
using roadquery::Road;

JunctionSurface surface_of(const std::function<double(double, double)>& z) {
  JunctionSurface surface{.boundary = {{-5, -10}, {35, -10}, {35, 10}, {-5, 10}},
                          .x = -5,
                          .y = -10,
                          .spacing_m = 0.5,
                          .columns = 81,
                          .rows = 41};
  for (int row = 0; row < surface.rows; ++row)
    for (int column = 0; column < surface.columns; ++column)
      surface.z.push_back(z(surface.x + 0.5 * column, surface.y + 0.5 * row));
  return surface;
}

Road on(const JunctionSurface& surface) {
  const Road road = roadquery::test::make_road(1, {0.0, 0.0, 0.0, 0.0, 30.0, roadquery::Line{}});
  return refitted(road, surface, {end_on(road, surface, false), end_on(road, surface, true)});
}

TEST(RefitProfile, of_a_plane_is_one_piece) {
  const Road road = on(surface_of([](double x, double y) { return 10.0 + 0.05 * x - 0.03 * y; }));
  ASSERT_EQ(road.elevation.size(), 1u);
  EXPECT_NEAR(road.elevation[0].b, 0.05, 1e-6);
  ASSERT_LE(road.superelevation.size(), 1u);
  // The cross section is pitched by the slope: rolled a little less it has that slope in plan.
  EXPECT_NEAR(std::tan(roadquery::superelevation(road, 17.0)) * std::hypot(1.0, 0.05), -0.03, 1e-6);
}

TEST(RefitProfile, beside_a_banked_road_on_a_slope_the_frame_is_the_same) {
  // A plane: whoever begins anywhere on its last cross section has its roll, its pitch and its plane.
  Road road = roadquery::test::make_road(1, {0.0, 0.0, 0.0, 0.4, 30.0, roadquery::Line{}}, 0.0, 6.0);
  road.elevation = {{.s = 0.0, .a = 10.0, .b = 0.12}};
  road.superelevation = {{.s = 0.0, .a = 0.12}};
  for (const double sign : {1.0, -1.0}) {
    const ProfileEnd end = end_beside(road, true, sign, -3.0, {1.0, -5.0});
    EXPECT_NEAR(end.banking, 0.12 * sign, 1e-12);
    EXPECT_NEAR(end.gradient, 0.12 * sign, 1e-12);
    EXPECT_NEAR(end.z, roadquery::surface_height(road, 30.0, -3.0 * sign), 1e-12);
  }
}

TEST(RefitProfile, takes_no_more_pieces_than_five_millimetres_ask_for) {
  // Rises and falls in the first half, a plane in the second: there nothing is needed.
  const auto bump = [](double x) { return x < 15.0 ? 0.1 * std::pow(std::sin(x * 3.14159265358979 / 15.0), 4) : 0.0; };
  const JunctionSurface surface = surface_of([&](double x, double y) { return 10.0 + bump(x) * (1.0 + 0.1 * y); });
  const Road road = on(surface);
  EXPECT_LT(distance_from_surface_m(road, surface), 0.0051);
  EXPECT_LE(road.elevation.size() + road.superelevation.size(), 11u);
  for (std::size_t i = 1; i < road.elevation.size(); ++i) {
    const roadquery::Cubic &a = road.elevation[i - 1], &b = road.elevation[i];
    const double ds = b.s - a.s;
    EXPECT_NEAR(a.a + ds * (a.b + ds * (a.c + ds * a.d)), b.a, 1e-9) << b.s;
    EXPECT_NEAR(a.b + ds * (2.0 * a.c + 3.0 * ds * a.d), b.b, 1e-9) << b.s;
  }
}

}  // namespace
}  // namespace orthodrive::network
