// SPDX-License-Identifier: Apache-2.0
// What a wheel finds beside its road.

#include "orthodrive/drive/car/monitored_road.hpp"

#include <gtest/gtest.h>

#include <array>

#include "drive/roads.hpp"

namespace orthodrive {
namespace {

using namespace test;

/// A street at height 0 with its edges 2.5 m off the x axis, and 4.5 m above it a bridge along the y axis.
RoadMap street_below_bridge() {
  return map_of({make_road(1, {0.0, -50.0, 0.0, 0.0, 100.0, Line{}}, 0.0, 2.5),
                 make_road(2, {0.0, 0.0, -50.0, 0.5 * std::numbers::pi, 100.0, Line{}}, 4.5)});
}

TEST(MonitoredRoad, a_wheel_that_leaves_its_street_below_a_bridge_is_not_lifted_onto_it) {
  const roadquery::RoadQuery query(street_below_bridge());
  MonitoredRoad road(query);
  EXPECT_TRUE(road.at(0, 0.0, 2.4, 0.3).on_road);
  const vehicle::GroundPoint beside = road.at(0, 0.0, 2.6, 0.3);
  EXPECT_FALSE(beside.on_road);
  EXPECT_NEAR(beside.z_m, 0.0, 1e-6);
  const MonitoredRoad::Seen seen = road.take();
  EXPECT_EQ(seen.missed, 1);
  EXPECT_NEAR(seen.step_m, 0.0, 1e-6);
  EXPECT_TRUE(road.at(0, 0.0, 2.4, 0.3).on_road) << "back on the street";
}

TEST(MonitoredRoad, a_wheel_that_leaves_a_bridge_does_not_fall_onto_the_street_below) {
  const roadquery::RoadQuery query(street_below_bridge());
  MonitoredRoad road(query);
  EXPECT_TRUE(road.at(0, 3.4, 0.0, 4.8).on_road);
  const vehicle::GroundPoint beside = road.at(0, 3.6, 0.0, 4.8);
  EXPECT_FALSE(beside.on_road);
  EXPECT_NEAR(beside.z_m, 4.5, 1e-6);
}

}  // namespace
}  // namespace orthodrive
