// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/refine/shift_field.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "orthodrive/refine/refine_roads.hpp"
#include "refine/road_scene.hpp"

namespace orthodrive {
namespace {

using namespace refine;
using namespace test;

/// Samples every 10 m along a straight road, as a shift of the map would give them.
void add_samples(std::vector<ShiftSample>& samples, Vec2 from, Vec2 to, Vec2 shift) {
  const Vec2 normal = left_normal(normalized(to - from));
  for (double s = 0.0; s <= distance(from, to); s += 10.0)
    samples.push_back({from + normalized(to - from) * s, normal, dot(normal, shift), 1.0});
}

TEST(ShiftField, two_directions_tell_both_components) {
  const Vec2 shift{2.0, -3.0};
  std::vector<ShiftSample> samples;
  add_samples(samples, at(0, 0), at(200, 0), shift);
  add_samples(samples, at(100, -100), at(100, 100), shift);
  const Shift found = shift_at({at(100, 20)}, samples, 1).front();
  EXPECT_NEAR(found.shift_m.x, 2.0, 0.1);
  EXPECT_NEAR(found.shift_m.y, -3.0, 0.1);
  EXPECT_LT(std::sqrt(found.xx_m2), 0.7);
}

TEST(ShiftField, one_direction_says_nothing_along_it) {
  std::vector<ShiftSample> samples;
  add_samples(samples, at(0, 0), at(200, 0), {2.0, -3.0});
  const Shift found = shift_at({at(100, 20)}, samples, 1).front();
  EXPECT_NEAR(found.shift_m.x, 0.0, 1e-9);
  EXPECT_NEAR(found.shift_m.y, -3.0, 0.1);
  EXPECT_NEAR(std::sqrt(found.xx_m2), 4.0, 1e-9);
}

TEST(ShiftField, far_away_nothing_is_known) {
  std::vector<ShiftSample> samples;
  add_samples(samples, at(0, 0), at(200, 0), {2.0, -3.0});
  for (const Shift& found : shift_at({at(0, 600), at(5000, 0)}, samples, 1)) {
    EXPECT_EQ(found.shift_m.x, 0.0);
    EXPECT_EQ(found.shift_m.y, 0.0);
    EXPECT_NEAR(found.yy_m2, 16.0, 1e-9);
  }
  EXPECT_EQ(shift_at({at(0, 0)}, {}, 1).front().shift_m.y, 0.0);
}

TEST(ShiftField, one_way_that_errs_does_not_pull_the_others) {
  std::vector<ShiftSample> samples;
  for (const double y : {0.0, 30.0, 60.0}) add_samples(samples, at(0, y), at(200, y), {0.0, 1.0});
  add_samples(samples, at(0, 40), at(200, 40), {0.0, -6.0});
  EXPECT_NEAR(shift_at({at(100, 40)}, samples, 1).front().shift_m.y, 1.0, 0.25);
}

TEST(ShiftField, hidden_roads_follow_the_roads_around) {
  // The map lies 3 m too far south-west. Trees hide the whole of the middle road.
  RoadScene scene = make_scene(400.0);
  const auto add = [&](std::int64_t id, Vec2 from, Vec2 to) {
    add_truth(scene, straight(from, to), 6.0);
    const Vec2 shift{-2.0, -2.2};
    add_way(scene, id, {{.p = from + shift, .width_m = 5.5}, {.p = to + shift, .width_m = 5.5}});
  };
  add(1, at(20, 140), at(380, 140));
  add(2, at(20, 260), at(380, 260));
  add(3, at(60, 20), at(60, 380));
  add(4, at(340, 20), at(340, 380));
  add(5, at(120, 200), at(280, 200));
  paint(scene.labels, {at(100, 180), at(300, 180), at(300, 220), at(100, 220)}, label_vegetation);
  const auto result = refine_roads(scene.osm, scene.labels);
  const RoadError hidden = compare(result.roads.paths[4], scene.truth[4]);
  EXPECT_LT(hidden.mean_offset_m, 0.4);
  EXPECT_GT(result.roads.paths[4].nodes[40].sigma_offset_m, result.roads.paths[0].nodes[40].sigma_offset_m);
}

}  // namespace
}  // namespace orthodrive
