// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/train/disturbed_map.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace orthodrive {
namespace {

constexpr ClassSet ground = only(0), road = only(1), parking = only(2);

/// A straight road of `width` pixels whose lower edge lies at row `from`, across the whole crop.
Raster<ClassSet> across(int size, int from, int width) {
  Raster<ClassSet> allowed(size, size, 1, ground);
  for (int row = from; row < from + width; ++row)
    for (int col = 0; col < size; ++col) allowed.at(col, row) = road;
  return allowed;
}

Raster<std::uint8_t> mask_of(const Raster<ClassSet>& allowed) {
  Raster<std::uint8_t> mask(allowed.width, allowed.height);
  for (std::size_t i = 0; i < mask.data.size(); ++i) mask.data[i] = allowed.data[i] == road;
  return mask;
}

TEST(ThinnedLines, FindTheMiddleAndHalfTheWidth) {
  for (const int width : {5, 8, 13}) {
    const Raster<std::uint8_t> mask = mask_of(across(96, 40, width));
    const auto lines = thinned_lines(mask, Raster<std::uint8_t>(96, 96));
    ASSERT_EQ(lines.size(), 1U);
    for (std::size_t i = 12; i + 12 < lines[0].points.size(); ++i) {
      EXPECT_NEAR(lines[0].points[i].y, 40.0 + 0.5 * width, 0.51);
      EXPECT_NEAR(lines[0].half_width[i], 0.5 * width, 0.51);
    }
  }
}

TEST(ThinnedLines, MeetAtCrossingsAndLoseSpurs) {
  Raster<ClassSet> allowed = across(128, 60, 8);
  for (int row = 0; row < 128; ++row)
    for (int col = 60; col < 68; ++col) allowed.at(col, row) = road;
  allowed.at(20, 59) = allowed.at(20, 58) = allowed.at(20, 57) = road;  // a bump in the edge
  const auto lines = thinned_lines(mask_of(allowed), Raster<std::uint8_t>(128, 128));
  int arms = 0;
  for (const ThinnedLine& line : lines) arms += line.points.size() > 40;
  EXPECT_EQ(arms, 4);
  EXPECT_LE(lines.size(), 5U);  // a crossing of even width may keep a bridge between two junction cells
}

TEST(ThinnedLines, KnowNoWidthBesideUnknownPixels) {
  Raster<ClassSet> allowed = across(64, 30, 7);
  Raster<std::uint8_t> unknown(64, 64);
  for (int col = 0; col < 64; ++col) unknown.at(col, 29) = unknown.at(col, 37) = 1;
  const auto lines = thinned_lines(mask_of(allowed), unknown);
  ASSERT_EQ(lines.size(), 1U);
  for (const double w : lines[0].half_width) EXPECT_LT(w, 0.0);
}

TEST(DisturbedMap, TellsTheWayBackToTheTruth) {
  const Raster<ClassSet> allowed = across(192, 90, 12);
  int seen = 0, moved = 0, off = 0;
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    const DisturbedMap map = draw_map(allowed, {}, {.road = road, .maybe_road = parking}, seed);
    for (int row = 0; row < 192; ++row) {
      for (int col = 60; col < 132; ++col) {  // a field may move the ends of the line by 40 px
        const AlignmentTruth& t = map.truth.at(col, row);
        if (!t.known) continue;
        // From the pixel along the normal of the drawn line: there is the middle, row 96.
        const Vec2 truth = Vec2{col + 0.5, row + 0.5} + Vec2{t.normal_x, t.normal_y} * t.offset;
        if (std::abs(t.normal_y) < 0.95) continue;
        // Waves tilt the line: along its normal lies another place than straight across.
        off += std::abs(truth.y - 96.0) > 1.1 + std::abs(t.offset) * (1.0 - t.normal_y * t.normal_y);
        EXPECT_NEAR(t.half_width, 6.0, 0.6);
        ++seen;
        const double to_line = (map.map.at(col, row, 1) - 128) / 4.0;
        moved += std::abs(t.normal_y * t.offset - to_line) > 4.0;
      }
    }
  }
  EXPECT_GT(seen, 50000);
  EXPECT_GT(moved, seen / 10);
  EXPECT_LT(off, seen / 1000);  // beside bends of coarse lines, where the nearest place is a corner
}

TEST(DisturbedMap, IsTheSameForTheSameSeedOnly) {
  const Raster<ClassSet> allowed = across(128, 60, 10);
  const DisturbedMap a = draw_map(allowed, {}, {.road = road, .maybe_road = parking}, 3);
  EXPECT_EQ(a.map.data, draw_map(allowed, {}, {.road = road, .maybe_road = parking}, 3).map.data);
  EXPECT_NE(a.map.data, draw_map(allowed, {}, {.road = road, .maybe_road = parking}, 4).map.data);
}

TEST(DisturbedMap, InventsRoadsWhereThereAreNoneAndKnowsNothingOfThem) {
  const Raster<ClassSet> allowed(128, 128, 1, ground);
  int with_lines = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    const DisturbedMap map = draw_map(allowed, {}, {.road = road, .maybe_road = parking}, seed);
    bool any = false;
    for (std::size_t i = 0; i < map.truth.data.size(); ++i) any = any || map.map.data[4 * i + 2] > 0;
    with_lines += any;
    EXPECT_TRUE(std::ranges::none_of(map.truth.data, &AlignmentTruth::known));
  }
  EXPECT_GT(with_lines, 5);
  EXPECT_LT(with_lines, 35);
}

TEST(DisturbedMap, ShowsARealMapInHalfOfTheCropsAndKnowsNothingOfIt) {
  const Raster<ClassSet> allowed = across(192, 90, 12);  // the real map has another road
  const std::vector<RoadLine> real{{{{96.0, -50.0}, {96.0, 250.0}}, 5.0}};
  int shown = 0;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    const DisturbedMap map = draw_map(allowed, real, {.road = road, .maybe_road = parking}, seed);
    const auto half_width = [&](int col, int row) { return map.map.at(col, row, 3); };
    bool upright = true;
    for (int row = 5; row < 187; ++row) {
      bool any = false;
      for (int col = 60; col < 132; ++col) any = any || half_width(col, row) == 40;
      upright = upright && any;
    }
    if (!upright) continue;
    ++shown;
    EXPECT_TRUE(std::ranges::none_of(map.truth.data, &AlignmentTruth::known));
  }
  EXPECT_GT(shown, 18);
  EXPECT_LT(shown, 42);
}

/// Aisles of car parks are ways of maps, too; they are no roads whose place is known.
TEST(DisturbedMap, DrawsAislesOnHalfOfTheCarParks) {
  Raster<ClassSet> allowed(128, 128, 1, ground);
  for (int row = 50; row < 80; ++row)
    for (int col = 20; col < 110; ++col) allowed.at(col, row) = parking;
  int along = 0, empty = 0;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    const auto lines = draw_lines(allowed, {.road = road, .maybe_road = parking}, seed);
    empty += lines.empty();
    const DisturbedMap map = draw_map(allowed, {}, {.road = road, .maybe_road = parking}, seed);
    EXPECT_TRUE(std::ranges::none_of(map.truth.data, &AlignmentTruth::known));
    along += std::ranges::any_of(lines, [](const RoadLine& line) {
      return std::ranges::all_of(line.points,
                                 [](Vec2 p) { return p.x > 0.0 && p.x < 128.0 && p.y > 20.0 && p.y < 110.0; });
    });
  }
  EXPECT_GT(along, 15);
  EXPECT_LT(along, 50);
  EXPECT_GT(empty, 0);
}

}  // namespace
}  // namespace orthodrive
