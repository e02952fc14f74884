// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/geo/spatial_index.hpp"

#include <gmock/gmock.h>

#include <algorithm>

#include "orthodrive/core/random.hpp"

namespace orthodrive {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

/// Boxes of UTM coordinates: some small, some long, some without area, some twice.
std::vector<Box2> many_boxes(int count) {
  Random random(3);
  std::vector<Box2> boxes;
  for (int i = 0; i < count; ++i) {
    const double x = 5e5 + random.uniform(0.0, 1000.0), y = 6.4e6 + random.uniform(0.0, 1000.0);
    const double width = i % 7 == 0 ? 400.0 : i % 5 == 0 ? 0.0 : random.uniform(0.0, 10.0);
    boxes.push_back({x, y, x + width, y + (i % 3 == 0 ? 0.0 : random.uniform(0.0, 10.0))});
    if (i % 11 == 0) boxes.push_back(boxes.back());
  }
  return boxes;
}

TEST(SpatialIndex, finds_what_a_look_at_every_box_finds_in_ascending_order) {
  const std::vector<Box2> boxes = many_boxes(2000);
  const SpatialIndex index(boxes);
  Random random(4);
  std::size_t found = 0;
  for (int k = 0; k < 300; ++k) {
    const double x = 5e5 + random.uniform(-50.0, 1050.0), y = 6.4e6 + random.uniform(-50.0, 1050.0);
    const Box2 asked{x, y, x + random.uniform(0.0, 60.0), y + random.uniform(0.0, 60.0)};
    std::vector<std::uint32_t> all;
    for (std::size_t i = 0; i < boxes.size(); ++i)
      if (boxes[i].overlaps(asked)) all.push_back(static_cast<std::uint32_t>(i));
    EXPECT_EQ(index.touching(asked), all);
    found += all.size();
  }
  EXPECT_GT(found, 1000U);
}

TEST(SpatialIndex, borders_belong_to_a_box_and_rounding_loses_none) {
  const std::vector<Box2> boxes = {{0, 0, 1, 1}, {1, 0, 2, 1}, {3, 0, 4, 1}};
  const SpatialIndex index(boxes);
  EXPECT_THAT(index.near({1.0, 0.5}, 0.0), ElementsAre(0, 1));
  EXPECT_THAT(index.near({2.5, 0.5}, 0.5), ElementsAre(1, 2));
  EXPECT_THAT(index.near({2.5, 0.5}, 0.5 - 1e-9), ElementsAre(1, 2));
  EXPECT_THAT(index.near({2.5, 0.5}, 0.49), IsEmpty());
}

TEST(SpatialIndex, without_boxes_nothing_is_near) {
  EXPECT_THAT(SpatialIndex().near({0, 0}, 1e9), IsEmpty());
  EXPECT_THAT(SpatialIndex(std::span<const Box2>{}).near({0, 0}, 1e9), IsEmpty());
}

TEST(SegmentIndex, names_lines_and_segments_in_order) {
  // The second line has one point and no segment; the third runs along the first.
  const std::vector<Polyline> lines = {
      {{0, 0}, {10, 0}, {20, 0}, {30, 0}}, {{5, 5}}, {{30, 1}, {0, 1}}, {{100, 100}, {110, 100}}};
  const SegmentIndex index(lines);
  using Segment = SegmentIndex::Segment;
  EXPECT_THAT(index.near({15, 0}, 2.0), ElementsAre(Segment{0, 1}, Segment{2, 0}));
  EXPECT_THAT(index.near({10, 0}, 0.5), ElementsAre(Segment{0, 0}, Segment{0, 1}));
  EXPECT_THAT(index.touching({0, 1, 200, 200}), ElementsAre(Segment{2, 0}, Segment{3, 0}));
  EXPECT_THAT(SegmentIndex().near({0, 0}, 1.0), IsEmpty());
}

}  // namespace
}  // namespace orthodrive
