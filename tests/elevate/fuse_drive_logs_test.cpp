// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/elevate/logs/fuse_drive_logs.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "elevate/drive_simulator.hpp"
#include "elevate/record_measured.hpp"
#include "orthodrive/core/error.hpp"
#include "orthodrive/math/uniform_spline.hpp"

namespace orthodrive {
namespace {

/// Mean absolute errors against the true road, ends left out where nobody drove.
struct ProfileErrors {
  double z_m = 0.0, gradient = 0.0, banking_rad = 0.0, worst_gradient = 0.0, worst_banking_rad = 0.0;
};
ProfileErrors errors_of(const RoadPath& path, const TrueRoad& road) {
  ProfileErrors e;
  double count = 0.0;
  for (const RoadNode& node : path.nodes) {
    if (node.s_m < 20.0 || node.s_m > road.length_m - 20.0) continue;
    const double gradient = std::abs(node.gradient - road.gradient(node.s_m)),
                 banking = std::abs(node.banking - road.banking(node.s_m));
    e.z_m += std::abs(node.z_m - road.z(node.s_m)), e.gradient += gradient, e.banking_rad += banking, count += 1.0;
    e.worst_gradient = std::max(e.worst_gradient, gradient),
    e.worst_banking_rad = std::max(e.worst_banking_rad, banking);
  }
  e.z_m /= count, e.gradient /= count, e.banking_rad /= count;
  return e;
}
void show(const char* name, const ProfileErrors& e) {
  test::record_measured("%-28s z %.3f m, gradient %.3f %% (worst %.2f), banking %.3f %% (worst %.2f)", name, e.z_m,
                        100 * e.gradient, 100 * e.worst_gradient, 100 * e.banking_rad, 100 * e.worst_banking_rad);
}

TEST(FuseDriveLogs, a_drive_corrects_gradient_and_banking) {
  const TrueRoad road;
  const RoadNetwork terrain = road_from_terrain(road, 0.3);
  const auto result = fuse_drive_logs(terrain, log_of({simulate_drive(road, {})}));
  const ProfileErrors before = errors_of(terrain.paths[0], road), after = errors_of(result.roads.paths[0], road);
  show("terrain", before), show("with a drive", after);
  const DriveCalibration& c = result.calibration[0];
  test::record_measured(
      "calibration mount pitch %.4f +- %.4f roll %.4f +- %.4f pitch gain %.4f +- %.4f roll gain %.4f +- "
      "%.4f",
      c.mount_pitch_rad, c.sigma_mount_pitch_rad, c.mount_roll_rad, c.sigma_mount_roll_rad, c.pitch_rad_per_mps2,
      c.sigma_pitch_rad_per_mps2, c.roll_rad_per_mps2, c.sigma_roll_rad_per_mps2);
  EXPECT_TRUE(result.solve.converged);
  EXPECT_GT(before.gradient, 0.007);
  EXPECT_LT(after.gradient, 0.0035);
  EXPECT_LT(after.banking_rad, 0.005);
  EXPECT_LT(after.z_m, 0.7 * before.z_m);
}

TEST(FuseDriveLogs, the_sensors_mounting_and_the_cars_body_are_found) {
  const TrueRoad road;
  SimulatedDrive drive;
  const auto result = fuse_drive_logs(road_from_terrain(road, 0.3), log_of({simulate_drive(road, drive)}));
  ASSERT_EQ(result.calibration.size(), 1u);
  const DriveCalibration& c = result.calibration[0];
  EXPECT_NEAR(c.mount_pitch_rad, drive.mount_pitch_rad, 0.002);
  EXPECT_NEAR(c.mount_pitch_rad, drive.mount_pitch_rad, 3.0 * c.sigma_mount_pitch_rad);
  EXPECT_NEAR(c.mount_roll_rad, drive.mount_roll_rad, 3.0 * c.sigma_mount_roll_rad);
  EXPECT_NEAR(c.pitch_rad_per_mps2, drive.pitch_rad_per_mps2, 3.0 * c.sigma_pitch_rad_per_mps2);
  EXPECT_LT(c.sigma_pitch_rad_per_mps2, 0.001);
  EXPECT_NEAR(c.roll_rad_per_mps2, drive.roll_rad_per_mps2, 3.0 * c.sigma_roll_rad_per_mps2);
}

TEST(FuseDriveLogs, standard_deviations_hold) {
  const TrueRoad road(2400.0);
  double z2 = 0.0, gradient2 = 0.0, banking2 = 0.0, count = 0.0;
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const auto result = fuse_drive_logs(road_from_terrain(road, 0.3, seed),
                                        log_of({simulate_drive(road, {.end_m = 2395.0, .seed = 100 + seed})}));
    for (const DrivenNode& driven : result.driven) {
      const RoadNode& node = result.roads.paths[driven.path].nodes[driven.node];
      EXPECT_LT(node.sigma_z_m, 0.3);
      z2 += std::pow((node.z_m - road.z(node.s_m)) / node.sigma_z_m, 2);
      gradient2 += std::pow((node.gradient - road.gradient(node.s_m)) / driven.sigma_gradient, 2);
      banking2 += std::pow((node.banking - road.banking(node.s_m)) / node.sigma_banking, 2);
      count += 1.0;
    }
  }
  test::record_measured("rms error over sigma: z %.2f, gradient %.2f, banking %.2f", std::sqrt(z2 / count),
                        std::sqrt(gradient2 / count), std::sqrt(banking2 / count));
  EXPECT_LT(std::sqrt(z2 / count), 1.6);
  EXPECT_GT(std::sqrt(z2 / count), 0.4);
  EXPECT_LT(std::sqrt(gradient2 / count), 1.6);
  EXPECT_GT(std::sqrt(gradient2 / count), 0.4);
  EXPECT_LT(std::sqrt(banking2 / count), 1.6);
  EXPECT_GT(std::sqrt(banking2 / count), 0.3);
}

TEST(FuseDriveLogs, a_known_crown_is_no_banking) {
  TrueRoad road;  // a roof as far as its middle, a plane beyond
  road.crown_rad = 0.025, road.crown_end_m = 600.0;
  const RoadNetwork terrain = road_from_terrain(road, 0.3);
  RoadNetwork unknown = terrain;
  for (RoadNode& node : unknown.paths[0].nodes) node.crown = 0.0;
  const DriveLog log = log_of({simulate_drive(road, {})});
  const auto result = fuse_drive_logs(terrain, log), blind = fuse_drive_logs(unknown, log);
  show("crowned half", errors_of(result.roads.paths[0], road));
  EXPECT_LT(errors_of(result.roads.paths[0], road).banking_rad, 0.005);
  EXPECT_GT(errors_of(blind.roads.paths[0], road).banking_rad, 0.008);
  EXPECT_NEAR(result.calibration[0].mount_roll_rad, SimulatedDrive{}.mount_roll_rad, 0.004);
}

TEST(FuseDriveLogs, banking_weighs_by_its_standard_deviation) {
  const TrueRoad road;
  const DriveLog log = log_of({simulate_drive(road, {})});
  RoadNetwork terrain = road_from_terrain(road, 0.3);
  for (RoadNode& node : terrain.paths[0].nodes) {  // measured well, but 1 % off for 60 m
    node.banking = road.banking(node.s_m) + (node.s_m > 500.0 && node.s_m < 560.0 ? 0.01 : 0.0);
    node.banking_source = BankingSource::dtm, node.sigma_banking = 0.002;
  }
  const auto sure = fuse_drive_logs(terrain, log);
  EXPECT_LT(errors_of(sure.roads.paths[0], road).banking_rad, 0.0015);
  EXPECT_GT(std::abs(sure.roads.paths[0].nodes[265].banking - road.banking(530.0)), 0.006);
  for (RoadNode& node : terrain.paths[0].nodes) node.sigma_banking = 0.03;
  const auto doubtful = fuse_drive_logs(terrain, log);
  EXPECT_LT(std::abs(doubtful.roads.paths[0].nodes[265].banking - road.banking(530.0)), 0.006);
  for (std::size_t n = 10; n + 10 < terrain.paths[0].nodes.size(); n += 10) {
    const RoadNode &a = sure.roads.paths[0].nodes[n], &b = doubtful.roads.paths[0].nodes[n];
    EXPECT_EQ(a.banking_source, BankingSource::log);
    EXPECT_LT(a.sigma_banking, 0.002);
    EXPECT_LT(b.sigma_banking, 0.015);
    EXPECT_GT(b.sigma_banking, 0.002);
  }
}

TEST(FuseDriveLogs, driving_the_other_way_gives_the_same_signs) {
  const TrueRoad road;
  const auto result = fuse_drive_logs(road_from_terrain(road, 0.3), log_of({simulate_drive(road, {.forward = false})}));
  const ProfileErrors after = errors_of(result.roads.paths[0], road);
  show("driven backwards", after);
  EXPECT_LT(after.gradient, 0.0035);
  EXPECT_LT(after.banking_rad, 0.005);
  EXPECT_NEAR(result.calibration[0].mount_pitch_rad, SimulatedDrive{}.mount_pitch_rad, 0.002);
}

TEST(FuseDriveLogs, a_path_drawn_the_other_way_has_the_opposite_signs) {
  const TrueRoad road;
  RoadNetwork turned = road_from_terrain(road, 0.3);
  const auto log = log_of({simulate_drive(road, {})});
  const auto straight = fuse_drive_logs(turned, log);
  auto& nodes = turned.paths[0].nodes;
  std::reverse(nodes.begin(), nodes.end());
  for (RoadNode& node : nodes) node.s_m = road.length_m - node.s_m, node.gradient = -node.gradient;
  const auto reversed = fuse_drive_logs(turned, log);
  for (std::size_t n = 20; n + 20 < nodes.size(); n += 10) {
    const RoadNode &a = straight.roads.paths[0].nodes[n], &b = reversed.roads.paths[0].nodes[nodes.size() - 1 - n];
    EXPECT_NEAR(a.z_m, b.z_m, 0.01);
    EXPECT_NEAR(a.gradient, -b.gradient, 0.001);
    EXPECT_NEAR(a.banking, -b.banking, 0.001);
  }
}

TEST(FuseDriveLogs, two_drives_count_together) {
  const TrueRoad road;
  const RoadNetwork terrain = road_from_terrain(road, 0.3);
  const SimulatedDrive one{.seed = 21};
  const SimulatedDrive other{.mount_pitch_rad = 0.03, .mount_roll_rad = -0.01, .seed = 22};
  const auto single = fuse_drive_logs(terrain, log_of({simulate_drive(road, one)}));
  const auto both = fuse_drive_logs(terrain, log_of({simulate_drive(road, one), simulate_drive(road, other)}));
  const ProfileErrors e1 = errors_of(single.roads.paths[0], road), e2 = errors_of(both.roads.paths[0], road);
  show("one drive", e1), show("two cars", e2);
  EXPECT_LT(e2.gradient, e1.gradient);
  ASSERT_EQ(single.driven.size(), both.driven.size());
  for (std::size_t i = 25; i + 25 < single.driven.size(); i += 25) {
    EXPECT_LT(both.driven[i].sigma_gradient, 0.9 * single.driven[i].sigma_gradient);
    EXPECT_GT(both.driven[i].sigma_gradient,
              0.6 * single.driven[i].sigma_gradient);  // less than root 2: the terrain counts once
  }
  EXPECT_NEAR(both.calibration[1].mount_pitch_rad, other.mount_pitch_rad, 0.003);
}

TEST(FuseDriveLogs, there_and_back_tells_the_tilt_of_the_sensor_from_that_of_the_road) {
  const TrueRoad road;
  const RoadNetwork terrain = road_from_terrain(road, 0.3);
  const SimulatedDrive there{.seed = 21}, back{.forward = false, .seed = 22};
  DriveLog log = log_of({simulate_drive(road, there), simulate_drive(road, back)});
  log.recordings[1].source = 0, log.sources.resize(1);  // one car that turns round
  const auto single = fuse_drive_logs(terrain, log_of({simulate_drive(road, there)})),
             both = fuse_drive_logs(terrain, log);
  show("there and back", errors_of(both.roads.paths[0], road));
  EXPECT_LT(both.calibration[0].sigma_mount_roll_rad, 0.5 * single.calibration[0].sigma_mount_roll_rad);
  EXPECT_NEAR(both.calibration[0].mount_roll_rad, there.mount_roll_rad, 0.003);
  EXPECT_LT(errors_of(both.roads.paths[0], road).banking_rad, 0.003);
}

TEST(FuseDriveLogs, weights_follow_the_stated_accuracies) {
  const TrueRoad road;
  const DriveLog log = log_of({simulate_drive(road, {})});
  // A terrain model of 2 cm stays as it is; a log that says it knows nothing changes nothing.
  const RoadNetwork good = road_from_terrain(road, 0.02), coarse = road_from_terrain(road, 0.3);
  const auto kept = fuse_drive_logs(good, log);
  FuseDriveLogsOptions blind;
  blind.accuracy = {.pitch_rad = 10, .roll_rad = 10, .climb_mps = 1000, .lateral_mps2 = 1000, .height_m = 1000};
  const auto unmoved = fuse_drive_logs(coarse, log, blind);
  for (std::size_t n = 0; n < good.paths[0].nodes.size(); n += 20) {
    EXPECT_NEAR(kept.roads.paths[0].nodes[n].z_m, good.paths[0].nodes[n].z_m, 0.06);
    EXPECT_NEAR(unmoved.roads.paths[0].nodes[n].z_m, coarse.paths[0].nodes[n].z_m, 0.01);
    EXPECT_NEAR(unmoved.roads.paths[0].nodes[n].banking, 0.0, 0.001);
  }
}

TEST(FuseDriveLogs, the_correction_is_as_smooth_as_a_spline) {
  // Second differences of the correction, divided by the square of the spacing, change by little from node to node: C2.
  const TrueRoad road;
  const RoadNetwork terrain = road_from_terrain(road, 0.3);
  const auto result = fuse_drive_logs(terrain, log_of({simulate_drive(road, {.begin_m = 300.0, .end_m = 700.0})}));
  const auto& nodes = result.roads.paths[0].nodes;
  const auto dz = [&](std::size_t n) { return nodes[n].z_m - terrain.paths[0].nodes[n].z_m; };
  const auto dg = [&](std::size_t n) { return nodes[n].gradient - terrain.paths[0].nodes[n].gradient; };
  double worst_jump = 0.0;
  for (std::size_t n = 2; n + 2 < nodes.size(); ++n) {
    EXPECT_NEAR(dg(n), (dz(n + 1) - dz(n - 1)) / 4.0, 1e-3) << "the gradient is the derivative of the height";
    const double bend = (dg(n + 1) - dg(n)) / 2.0, before = (dg(n) - dg(n - 1)) / 2.0;
    worst_jump = std::max(worst_jump, std::abs(bend - before));
  }
  EXPECT_LT(worst_jump, 2e-3);
  EXPECT_NEAR(dz(0), 0.0, 1e-3);  // nothing moves far from where somebody drove
  EXPECT_EQ(nodes[0].banking_source, BankingSource::none);
  EXPECT_EQ(nodes[250].banking_source, BankingSource::log);
  EXPECT_NEAR(nodes[0].sigma_z_m, 0.3, 1e-3);
}

TEST(UniformSpline, it_is_c2_and_its_derivatives_are_its_own) {
  const UniformSpline spline(100.0, 6.0);
  std::vector<double> c;
  for (int i = 0; i < spline.coefficients(); ++i) c.push_back(std::sin(1.7 * i * i));
  const auto value = [&](double s, std::array<double, 4> UniformSpline::Basis::*of) {
    const auto basis = spline.at(s);
    double sum = 0.0;
    for (std::size_t k = 0; k < 4; ++k) sum += (basis.*of)[k] * c[static_cast<std::size_t>(basis.first) + k];
    return sum;
  };
  using B = UniformSpline::Basis;
  constexpr double h = 1e-4;
  for (int i = 1; i < spline.intervals; ++i) {
    const double knot = i * spline.step_m(), e = 1e-9;
    for (const auto of : {&B::value, &B::slope, &B::bend})
      EXPECT_NEAR(value(knot - e, of), value(knot + e, of), 1e-7) << i;
    EXPECT_GT(std::abs(value(knot - e, &B::jerk) - value(knot + e, &B::jerk)),
              1e-4);  // there is a knot to be smooth at
    const double s = knot + 1.3;
    EXPECT_NEAR(value(s, &B::slope), (value(s + h, &B::value) - value(s - h, &B::value)) / (2 * h), 1e-7);
    EXPECT_NEAR(value(s, &B::bend), (value(s + h, &B::slope) - value(s - h, &B::slope)) / (2 * h), 1e-7);
    EXPECT_NEAR(value(s, &B::jerk), (value(s + h, &B::bend) - value(s - h, &B::bend)) / (2 * h), 1e-7);
  }
}

TEST(FuseDriveLogs, side_roads_keep_their_height_and_angle) {
  const TrueRoad road(1200.0, 0.0, 6.0);  // straight along +x
  RoadNetwork terrain = road_from_terrain(road, 0.3);
  terrain.paths[0].nodes[300].osm_node = 5;
  RoadPath side{.osm_id = 8, .highway = "residential"};
  const RoadNode& corner = terrain.paths[0].nodes[300];
  for (int i = 0; i <= 50; ++i) {  // away to the north-east, in the plane of the road at the corner
    const double s = 2.0 * i;
    side.nodes.push_back({.p = corner.p + Vec2{std::sqrt(0.5), std::sqrt(0.5)} * s,
                          .s_m = s,
                          .width_m = 5.0,
                          .z_m = corner.z_m + std::sqrt(0.5) * corner.gradient * s,
                          .gradient = std::sqrt(0.5) * corner.gradient,
                          .banking = -std::sqrt(0.5) * corner.gradient,
                          .sigma_z_m = 0.3});
  }
  side.nodes.front().osm_node = 5;
  terrain.paths.push_back(side);
  const auto result = fuse_drive_logs(terrain, log_of({simulate_drive(road, {})}));
  const RoadNode &main = result.roads.paths[0].nodes[300], &first = result.roads.paths[1].nodes[0];
  EXPECT_GT(std::abs(main.z_m - corner.z_m), 0.02);
  EXPECT_NEAR(first.z_m, main.z_m, 1e-3);
  EXPECT_NEAR(first.gradient, std::sqrt(0.5) * (main.gradient + std::tan(main.banking)), 1e-3);
  EXPECT_NEAR(std::tan(first.banking), std::sqrt(0.5) * (std::tan(main.banking) - main.gradient), 1e-3);
  EXPECT_NE(first.banking_source, BankingSource::log);
}

TEST(FuseDriveLogs, ways_that_continue_each_other_stay_without_a_kink) {
  const TrueRoad road;
  RoadNetwork terrain = road_from_terrain(road, 0.3);
  RoadPath second = terrain.paths[0];  // cut at 600 m, the second half drawn against the first
  second.osm_id = 9;
  terrain.paths[0].nodes.resize(301), terrain.paths[0].nodes.back().osm_node = 4;
  second.nodes.erase(second.nodes.begin(), second.nodes.begin() + 300);
  std::reverse(second.nodes.begin(), second.nodes.end());
  for (RoadNode& node : second.nodes) node.s_m = road.length_m - node.s_m, node.gradient = -node.gradient;
  second.nodes.back().osm_node = 4;
  terrain.paths.push_back(second);
  const auto result = fuse_drive_logs(terrain, log_of({simulate_drive(road, {})}));
  EXPECT_GT(result.matched_m, 1150.0);
  const RoadNode &a = result.roads.paths[0].nodes.back(), &b = result.roads.paths[1].nodes.back();
  EXPECT_NEAR(a.z_m, b.z_m, 1e-9);
  EXPECT_NEAR(a.gradient, -b.gradient, 1e-9);
  EXPECT_NEAR(a.banking, -b.banking, 1e-9);
}

TEST(FuseDriveLogs, a_log_elsewhere_changes_nothing_and_is_reported) {
  const TrueRoad road;
  const RoadNetwork terrain = road_from_terrain(road, 0.3);
  DriveRecording away = simulate_drive(road, {});
  for (DrivePose& pose : away.poses) pose.p = pose.p + Vec2{0.0, 300.0};
  const auto result = fuse_drive_logs(terrain, log_of({away}));
  ASSERT_EQ(result.findings.size(), 1u);
  EXPECT_EQ(result.findings[0].code, "drive_log.no_match");
  EXPECT_EQ(result.matched_m, 0.0);
  for (std::size_t n = 0; n < terrain.paths[0].nodes.size(); ++n)
    EXPECT_EQ(result.roads.paths[0].nodes[n].z_m, terrain.paths[0].nodes[n].z_m);
  EXPECT_TRUE(result.driven.empty());
  EXPECT_TRUE(result.roughness.empty());
}

TEST(FuseDriveLogs, gaps_and_steps_in_height_do_not_reach_the_road) {
  // As read_drive_logs leaves them: parts of one source, each with its own offset in height.
  const TrueRoad road;
  const DriveRecording whole = simulate_drive(road, {});
  DriveLog log = log_of({});
  log.sources = {"drive"};
  const std::size_t n = whole.poses.size();
  struct Part {
    std::size_t from, to;
    double step_m;
  };
  for (const auto& [from, to, step_m] :
       std::vector<Part>{{0, n / 3, 0.0}, {n / 3 + 40, 2 * n / 3, 25.0}, {2 * n / 3 + 1, n, -40.0}}) {
    DriveRecording part{.source = 0,
                        .poses = {whole.poses.begin() + static_cast<std::ptrdiff_t>(from),
                                  whole.poses.begin() + static_cast<std::ptrdiff_t>(to)}};
    for (DrivePose& pose : part.poses) pose.z_m += step_m;
    for (const DriveImu& imu : whole.imu)
      if (imu.time_s >= part.poses.front().time_s && imu.time_s <= part.poses.back().time_s) part.imu.push_back(imu);
    log.recordings.push_back(part);
  }
  const auto result = fuse_drive_logs(road_from_terrain(road, 0.3), log);
  const ProfileErrors after = errors_of(result.roads.paths[0], road);
  show("in three parts", after);
  EXPECT_LT(after.gradient, 0.0035);
  EXPECT_LT(after.z_m, 0.25);
  EXPECT_EQ(result.calibration.size(), 1u);
}

TEST(FuseDriveLogs, logs_without_attitude_or_sensors_still_help) {
  const TrueRoad road;
  const RoadNetwork terrain = road_from_terrain(road, 0.3);
  DriveRecording positions = simulate_drive(road, {.poses_hz = 5.0}), attitude = positions;
  positions.imu.clear(), attitude.imu.clear();
  for (DrivePose& pose : positions.poses)
    pose.roll_rad = pose.pitch_rad = pose.heading_rad = pose.speed_mps = pose.climb_mps = not_recorded;
  for (DrivePose& pose : attitude.poses) pose.z_m = pose.climb_mps = not_recorded;
  const double before = errors_of(terrain.paths[0], road).gradient;
  const auto a = fuse_drive_logs(terrain, log_of({positions})), b = fuse_drive_logs(terrain, log_of({attitude}));
  show("positions only", errors_of(a.roads.paths[0], road)),
      show("attitude and speed only", errors_of(b.roads.paths[0], road));
  EXPECT_LT(errors_of(a.roads.paths[0], road).gradient, 0.85 * before);
  EXPECT_LT(errors_of(b.roads.paths[0], road).gradient, 0.4 * before);
  EXPECT_LT(errors_of(b.roads.paths[0], road).banking_rad, 0.01);
}

TEST(FuseDriveLogs, bursts_of_wrong_pitch_are_cut_off) {
  const TrueRoad road;
  DriveRecording drive = simulate_drive(road, {});
  for (std::size_t i = 0; i < drive.poses.size(); ++i)
    if (i % 200 < 10) drive.poses[i].pitch_rad += 0.15;  // a speed bump, a hand on the phone
  const auto result = fuse_drive_logs(road_from_terrain(road, 0.3), log_of({drive}));
  const ProfileErrors after = errors_of(result.roads.paths[0], road);
  show("with bursts", after);
  EXPECT_LT(after.gradient, 0.004);
}

TEST(FuseDriveLogs, wrong_input_is_told) {
  const TrueRoad road;
  RoadNetwork terrain = road_from_terrain(road, 0.3);
  DriveLog log = log_of({simulate_drive(road, {.end_m = 100.0})});
  EXPECT_THROW((void)fuse_drive_logs(terrain, log, {.knot_spacing_m = 0.0}), OptionError);
  log.crs = {"EPSG:32632"};
  EXPECT_THROW((void)fuse_drive_logs(terrain, log), OptionError);
  log.crs = drive_crs;
  terrain.paths[0].nodes[3].z_m = not_recorded;
  EXPECT_THROW((void)fuse_drive_logs(terrain, log), OptionError);
}

}  // namespace
}  // namespace orthodrive
