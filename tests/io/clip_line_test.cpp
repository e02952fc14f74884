// SPDX-License-Identifier: Apache-2.0
// Lines against areas small enough to draw.

#include "orthodrive/io/support/clip_line.hpp"

#include <gtest/gtest.h>

#include "places.hpp"

namespace orthodrive {
namespace {

TEST(ClipLine, line_inside_stays_whole) {
  const auto pieces = io::clip_line({{1, 1}, {5, 5}, {9, 1}}, rectangle(0, 0, 10, 10));
  ASSERT_EQ(pieces.size(), 1u);
  EXPECT_EQ(pieces[0].size(), 3u);
  EXPECT_EQ(pieces[0][2].vertex, 2u);
}

TEST(ClipLine, line_that_leaves_and_returns_gives_two_pieces_cut_at_the_border) {
  const auto pieces = io::clip_line({{5, 5}, {15, 5}, {15, 8}, {5, 8}}, rectangle(0, 0, 10, 10));
  ASSERT_EQ(pieces.size(), 2u);
  EXPECT_EQ(pieces[0].back().p, (Vec2{10, 5}));
  EXPECT_FALSE(pieces[0].back().vertex);
  EXPECT_EQ(pieces[1].front().p, (Vec2{10, 8}));
  EXPECT_EQ(pieces[1].back().vertex, 3u);
}

TEST(ClipLine, segment_across_the_whole_area_without_a_vertex_inside) {
  const auto pieces = io::clip_line({{-5, 4}, {15, 4}}, rectangle(0, 0, 10, 10));
  ASSERT_EQ(pieces.size(), 1u);
  EXPECT_EQ(pieces[0].front().p, (Vec2{0, 4}));
  EXPECT_EQ(pieces[0].back().p, (Vec2{10, 4}));
}

TEST(ClipLine, segment_over_a_hole_and_over_a_notch) {
  Polygon area = rectangle(0, 0, 10, 10);
  area.holes.push_back({{4, 3}, {4, 6}, {6, 6}, {6, 3}});
  const auto pieces = io::clip_line({{1, 5}, {9, 5}}, area);
  ASSERT_EQ(pieces.size(), 2u);
  EXPECT_EQ(pieces[0].back().p, (Vec2{4, 5}));
  EXPECT_EQ(pieces[1].front().p, (Vec2{6, 5}));
}

TEST(ClipLine, touching_a_corner_from_inside_does_not_cut) {
  const Polygon arrow{{{0, 0}, {10, 0}, {5, 4}, {10, 10}, {0, 10}}, {}};  // notch with its point at (5,4)
  const auto pieces = io::clip_line({{5, 1}, {5, 9}}, arrow);
  ASSERT_EQ(pieces.size(), 1u);
  EXPECT_EQ(pieces[0].size(), 2u);
}

TEST(ClipLine, line_outside_or_without_length_gives_nothing) {
  EXPECT_TRUE(io::clip_line({{20, 20}, {30, 20}}, rectangle(0, 0, 10, 10)).empty());
  EXPECT_TRUE(io::clip_line({{1, 1}}, rectangle(0, 0, 10, 10)).empty());
  EXPECT_TRUE(io::clip_line({}, rectangle(0, 0, 10, 10)).empty());
}

}  // namespace
}  // namespace orthodrive
