// SPDX-License-Identifier: Apache-2.0
// The steps of fuse_drive_logs one by one: samples, meetings, the given profile, rows.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "orthodrive/elevate/logs/driven_samples.hpp"
#include "orthodrive/elevate/logs/fusion_problem.hpp"
#include "orthodrive/elevate/logs/given_profile.hpp"
#include "orthodrive/elevate/logs/road_meetings.hpp"
#include "orthodrive/elevate/logs/sensor_model.hpp"
#include "test_roads.hpp"

namespace orthodrive::elevate {
namespace {

using test::straight_road;

/// 10 Hz along y = 1.5 at 10 m/s, on path 0 where `on_road`.
struct Drive {
  explicit Drive(
      int poses, const std::function<bool(int)>& on_road = [](int) { return true; }) {
    for (int i = 0; i < poses; ++i) {
      recording.poses.push_back(
          {.time_s = 0.1 * i, .p = {static_cast<double>(i), 1.5}, .pitch_rad = -0.02, .heading_rad = 0.0});
      places.push_back(on_road(i) ? std::optional<LogPlace>({0, static_cast<double>(i), 1.5, true}) : std::nullopt);
    }
  }
  DriveRecording recording;
  std::vector<std::optional<LogPlace>> places;
};

TEST(DrivenSamples, are_means_over_2_m) {
  const RoadNetwork roads{test::road_crs, {straight_road(1, {0, 0}, {100, 0})}};
  const LogChains chains = make_log_chains(roads);
  const Drive drive(41);
  const auto samples = driven_samples(chains, drive.recording, 3, drive.places);
  ASSERT_EQ(samples.size(), 21U);  // two poses each, and the last one alone
  const DrivenSample& s = samples[5];
  EXPECT_EQ(s.recording, 3U);
  EXPECT_NEAR(s.along_m, 10.5, 1e-9);
  EXPECT_NEAR(s.beside_m, 1.5, 1e-9);
  EXPECT_NEAR(s.speed_mps, 10.0, 1e-9) << "from the positions: the log has none";
  EXPECT_NEAR(s.nose_up_rad, 0.02, 1e-12);
  EXPECT_NEAR(s.span_s, 0.2, 1e-9);
  EXPECT_NEAR(s.step_s, 0.1, 1e-9);
  EXPECT_NEAR(s.yaw_rate_radps, 0.0, 1e-12);
  EXPECT_TRUE(std::isnan(s.z_m) && std::isnan(s.roll_rad) && std::isnan(s.left_mps2));
}

TEST(DrivenSamples, poses_on_no_road_are_left_out_and_a_standing_car_gives_one_every_2_s) {
  const RoadNetwork roads{test::road_crs, {straight_road(1, {0, 0}, {100, 0})}};
  const LogChains chains = make_log_chains(roads);
  const Drive gap(40, [](int i) { return i < 10 || i >= 30; });
  EXPECT_EQ(driven_samples(chains, gap.recording, 0, gap.places).size(), 10U);
  Drive standing(41);
  for (auto& place : standing.places) place->s_m = 20.0;
  EXPECT_EQ(driven_samples(chains, standing.recording, 0, standing.places).size(), 3U);
  EXPECT_TRUE(driven_samples(chains, {}, 0, {}).empty());
}

TEST(DrivenSamples, against_the_chain_sides_and_direction_turn_round) {
  RoadNetwork roads{test::road_crs,
                    {straight_road(1, {0, 0}, {100, 0}, 1, 2), straight_road(2, {200, 0}, {100, 0}, 3, 2)}};
  const LogChains chains = make_log_chains(roads);
  ASSERT_EQ(chains.chains.size(), 1U);
  Drive drive(20);
  for (auto& place : drive.places) place->path = 1;  // forward along path 1, which runs against the chain
  const auto samples = driven_samples(chains, drive.recording, 0, drive.places);
  EXPECT_EQ(samples[0].direction, -1.0);
  EXPECT_NEAR(samples[0].beside_m, -1.5, 1e-9);
  EXPECT_NEAR(samples[0].along_m, 199.5, 1e-9);
}

TEST(DrivenSamples, errors_within_the_correlation_time_are_one_error) {
  const DrivenSample sample{.span_s = 0.2, .step_s = 0.1};
  EXPECT_NEAR(sigma_of_mean(0.01, 1.0, sample), 0.01 * std::sqrt(5.0), 1e-12) << "a fifth of an error";
  EXPECT_NEAR(sigma_of_mean(0.01, 0.1, sample), 0.01 / std::sqrt(2.0), 1e-12) << "two errors";
  EXPECT_NEAR(sigma_of_mean(0.01, 0.1, {.span_s = 100.0, .step_s = 0.1}), 0.005, 1e-12) << "standing: four at most";
}

TEST(RoadMeetings, chains_within_reach_of_the_driven_one) {
  // A driven main road; a side road at its middle, a road at the side road's end 60 m away, one apart from all.
  RoadNetwork roads{test::road_crs,
                    {straight_road(1, {0, 0}, {200, 0}), straight_road(2, {100, 0}, {100, 60}, 5, 6),
                     straight_road(3, {50, 60}, {150, 60}), straight_road(4, {0, 300}, {100, 300})}};
  roads.paths[0].nodes[50].osm_node = 5;
  roads.paths[2].nodes[25].osm_node = 6;
  const LogChains chains = make_log_chains(roads);
  const Meetings meetings = find_meetings(roads, chains);
  EXPECT_EQ(meetings.size(), 2U);
  std::vector<DrivenSample> samples;
  for (double s = 90.0; s <= 110.0; s += 2.0) samples.push_back({.chain = chains.chain_of[0], .along_m = s});
  const DrivenPlaces driven(chains.chains.size(), samples);
  EXPECT_TRUE(driven.near(chains.chain_of[0], 119.0));
  EXPECT_FALSE(driven.near(chains.chain_of[0], 121.0));
  EXPECT_FALSE(driven.near(chains.chain_of[1], 0.0));
  const auto within = [&](double reach_m) { return chains_within(chains, meetings, driven, reach_m).size(); };
  EXPECT_EQ(within(50.0), 2U) << "the driven road and the side road";
  EXPECT_EQ(within(61.0), 3U);
  EXPECT_EQ(within(1e6), 3U) << "never the road that meets none";
}

TEST(GivenProfile, is_the_cubic_of_heights_and_gradients) {
  RoadNetwork roads{test::road_crs, {straight_road(1, {0, 0}, {20, 0})}};
  for (RoadNode& node : roads.paths[0].nodes) {
    const double s = node.s_m;
    node.z_m = 0.001 * s * s * s, node.gradient = 0.003 * s * s;
    node.banking = 0.002 * s, node.crown = 0.02, node.sigma_z_m = 0.3;
  }
  const LogChains chains = make_log_chains(roads);
  const FuseDriveLogsOptions options;
  const GivenProfile p = given_profile_at(roads, chains, 0, 7.3, options);
  EXPECT_NEAR(p.z_m, 0.001 * 7.3 * 7.3 * 7.3, 1e-9) << "a cubic is met between its nodes";
  EXPECT_NEAR(p.banking_rad, 0.0146, 1e-12);
  EXPECT_NEAR(p.banking_change, 0.002, 1e-12);
  EXPECT_NEAR(p.sigma_z_m, 0.3, 1e-12);
  EXPECT_EQ(p.sigma_banking_rad, options.unknown_sigma_banking_rad) << "the nodes have none";
}

TEST(WeightedRows, entries_of_one_unknown_are_added) {
  WeightedRows rows;
  rows.add({{2, 1.0}, {0, 3.0}, {2, 0.5}}, 4.0, 2.0);
  EXPECT_THAT(rows.jacobian.column, testing::ElementsAre(0, 2));
  EXPECT_THAT(rows.jacobian.value, testing::ElementsAre(6.0, 3.0));
  EXPECT_THAT(rows.right, testing::ElementsAre(8.0));
  EXPECT_NEAR(rows.half_square_sum({1.0, 9.0, 2.0}), 0.5 * 16.0, 1e-12);
}

TEST(SensorModel, each_recorded_quantity_is_one_measurement_and_is_met_at_the_truth) {
  RoadNetwork roads{test::road_crs, {straight_road(1, {0, 0}, {100, 0})}};
  for (RoadNode& node : roads.paths[0].nodes)
    node.z_m = 10.0 + 0.04 * node.s_m, node.gradient = 0.04, node.banking = 0.03;
  const LogChains chains = make_log_chains(roads);
  DriveLog log{.crs = test::road_crs, .sources = {"car"}};
  log.recordings.push_back({.source = 0, .poses = {{.time_s = 0.0}, {.time_s = 10.0}}});
  // Level car body, no suspension: pitch and roll are those of the road 2 m left of its middle, in a straight line.
  std::vector<DrivenSample> samples{{.along_m = 50.0, .beside_m = 2.0, .time_s = 5.0, .span_s = 0.2, .step_s = 0.1}};
  DrivenSample& s = samples[0];
  s.nose_up_rad = std::atan(0.04), s.roll_rad = 0.03, s.speed_mps = 10.0, s.climb_mps = 0.4;
  s.z_m = 10.0 + 0.04 * 50.0 + 2.0 * 0.03;
  s.forward_mps2 = 0.0, s.left_mps2 = 9.81 * std::sin(0.03), s.yaw_rate_radps = 0.0;
  const FuseDriveLogsOptions options;
  const FusionProblem problem = make_fusion_problem(roads, chains, log, samples, options);
  const std::vector<double> x(static_cast<std::size_t>(problem.columns.count()), 0.0);
  const auto all = measurements_of(problem, s, x);
  ASSERT_EQ(all.size(), 5U);
  for (const Measurement& m : all) EXPECT_NEAR(m.residual(x), 0.0, 1e-12);
  DrivenSample only_roll = s;
  only_roll.nose_up_rad = only_roll.climb_mps = only_roll.z_m = only_roll.left_mps2 = not_recorded;
  const auto roll = measurements_of(problem, only_roll, x);
  ASSERT_EQ(roll.size(), 1U);
  EXPECT_NEAR(roll[0].sigma_of_mean * std::sqrt(2.0), all[3].sigma_of_mean, 1e-12)
      << "with the lateral force beside it the roll counts half";
  DrivenSample slow = s;
  slow.speed_mps = 1.0;
  EXPECT_EQ(measurements_of(problem, slow, x).size(), 4U) << "climb over speed is noise at walking speed";
}

}  // namespace
}  // namespace orthodrive::elevate
