// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/baselines/mrf_surfaces.hpp"

#include <gtest/gtest.h>

namespace orthodrive {
namespace {

using namespace baselines;

/// Rectangles of 10 m eastwards, each at its own offset.
std::vector<SegmentRectangle> row(const std::vector<double>& offsets, double width_m = 6.0) {
  std::vector<SegmentRectangle> rectangles;
  for (std::size_t i = 0; i < offsets.size(); ++i) {
    const double x = 10.0 * static_cast<double>(i);
    rectangles.push_back({{x, offsets[i]}, {x + 10.0, offsets[i]}, {0.0, 1.0}, width_m});
  }
  return rectangles;
}

TEST(MrfSurfaces, smooth_nodes_are_means_of_the_neighbouring_rectangles) {
  auto rectangles = row({0.0, 1.0, 1.0});
  rectangles[2].width_m = 8.0;
  const NodeSurface surface = smooth_surface(rectangles, false);
  ASSERT_EQ(surface.line.size(), 4u);
  EXPECT_EQ(surface.line[0], (Vec2{0.0, 0.0}));
  EXPECT_EQ(surface.line[1], (Vec2{10.0, 0.5}));
  EXPECT_EQ(surface.line[2], (Vec2{20.0, 1.0}));
  EXPECT_EQ(surface.line[3], (Vec2{30.0, 1.0}));
  EXPECT_EQ(surface.width_m, (std::vector{6.0, 6.0, 7.0, 8.0}));
}

TEST(MrfSurfaces, closed_roads_end_where_they_begin) {
  std::vector<SegmentRectangle> square{{{0, 1}, {10, 1}, {0, 1}, 4.0},
                                       {{9, 0}, {9, 10}, {-1, 0}, 6.0},
                                       {{10, 9}, {0, 9}, {0, -1}, 4.0},
                                       {{1, 10}, {1, 0}, {1, 0}, 6.0}};
  for (const NodeSurface& surface : {smooth_surface(square, true), simplified_surface(square, true, 0.1)}) {
    ASSERT_EQ(surface.line.size(), 5u);
    EXPECT_LT(distance(surface.line.front(), surface.line.back()), 1e-9);
    EXPECT_NEAR(surface.width_m.front(), surface.width_m.back(), 1e-9);
  }
}

TEST(MrfSurfaces, outline_of_a_straight_row_has_four_corners) {
  const Ring ring = simplified_outline(row({0.0, 0.2, -0.2, 0.0}), 0.5);
  ASSERT_EQ(ring.size(), 4u);
  EXPECT_NEAR(signed_area_m2(ring), 240.0, 1e-9);
}

TEST(MrfSurfaces, a_jump_beyond_the_tolerance_stays_in_the_outline) {
  const auto rectangles = row({0.0, 0.0, 3.0, 3.0});
  const Ring ring = simplified_outline(rectangles, 0.5);
  EXPECT_EQ(ring.size(), 8u);
  const Polygon polygon{ring, {}};
  EXPECT_TRUE(contains(polygon, {19.9, -2.9}));
  EXPECT_FALSE(contains(polygon, {20.1, -2.9}));  // a smooth surface would slope here
  EXPECT_FALSE(contains(polygon, {19.9, 3.1}));
  const NodeSurface nodes = simplified_surface(rectangles, false, 0.5);
  EXPECT_NEAR(nodes.line[2].y, 1.5, 1e-9);
  EXPECT_NEAR(nodes.width_m[1], 6.0, 1e-9);
}

TEST(MrfSurfaces, nothing_gives_nothing) {
  EXPECT_TRUE(simplified_outline({}, 0.5).empty());
  EXPECT_TRUE(smooth_surface({}, false).line.empty());
  EXPECT_TRUE(simplified_surface({}, true, 0.5).line.empty());
}

}  // namespace
}  // namespace orthodrive
