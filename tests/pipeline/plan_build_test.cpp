// SPDX-License-Identifier: Apache-2.0
// Estimates of a build: what they grow with, and how the speed of the machine counts.
#include "orthodrive/pipeline/build/plan_build.hpp"

#include <gtest/gtest.h>

namespace orthodrive {
namespace {

constexpr SiteSize town{.area_km2 = 10.0, .megapixels = 40.0, .road_km = 100.0};
constexpr MachineSpeed machine{.seconds_of_one = 0.1, .seconds_of_all = 0.1, .threads = 2};

TEST(EstimateBuild, a_machine_of_half_the_speed_takes_twice_the_time_and_as_much_memory) {
  MachineSpeed slow = machine;
  slow.seconds_of_one *= 2.0;
  slow.seconds_of_all *= 2.0;
  const BuildEstimate fast_build = estimate_build(town, machine), slow_build = estimate_build(town, slow);
  EXPECT_NEAR(slow_build.seconds, 2.0 * fast_build.seconds, 1e-9);
  EXPECT_NEAR(slow_build.speed, 0.5 * fast_build.speed, 1e-9);
  EXPECT_EQ(slow_build.memory_mb, fast_build.memory_mb);
  EXPECT_EQ(slow_build.disk_mb, fast_build.disk_mb);
}

TEST(EstimateBuild, more_cores_help_with_what_is_shared_and_busy_ones_do_not) {
  MachineSpeed many = machine, busy = machine;
  many.threads = 16;
  busy.threads = 16;
  busy.seconds_of_all = 0.8;  // 16 threads on what two cores have left
  const double few_s = estimate_build(town, machine).seconds, many_s = estimate_build(town, many).seconds;
  EXPECT_LT(many_s, 0.5 * few_s);
  EXPECT_GT(many_s, few_s / 8.0);
  EXPECT_NEAR(estimate_build(town, busy).seconds, few_s, 1e-9);
}

TEST(EstimateBuild, grows_with_area_pixels_and_roads) {
  const double town_s = estimate_build(town, machine).seconds;
  for (double SiteSize::*size : {&SiteSize::area_km2, &SiteSize::megapixels, &SiteSize::road_km}) {
    SiteSize larger = town;
    larger.*size *= 2.0;
    EXPECT_GT(estimate_build(larger, machine).seconds, 1.001 * town_s);
  }
}

TEST(MachineSpeed, is_measured_with_as_many_threads_as_asked) {
  const MachineSpeed one = measure_machine_speed(1);
  MachineSpeed three = measure_machine_speed(3);
  // Other work that comes and goes may disturb a measurement, and the next one less.
  for (int again = 0; again < 20 && three.seconds_of_all <= 0.5 * three.seconds_of_one; ++again)
    three = measure_machine_speed(3);
  EXPECT_EQ(one.threads, 1);
  EXPECT_EQ(three.threads, 3);
  EXPECT_GT(one.seconds_of_one, 1e-3);  // no compiler has thrown the work away
  EXPECT_GT(three.seconds_of_all, 0.5 * three.seconds_of_one);
}

}  // namespace
}  // namespace orthodrive
