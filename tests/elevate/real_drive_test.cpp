// SPDX-License-Identifier: Apache-2.0
// One real minute of driving (comma2k19): the halves of its information must agree. There is no map and no terrain of
// the place, so the road is drawn along the drive itself, with a height profile as coarse as a poor terrain model's.
// Prints numbers of docs/measured/drive_logs.md (tools/measure drive-logs).

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <filesystem>
#include <vector>

#include "elevate/record_measured.hpp"
#include "orthodrive/elevate/logs/fuse_drive_logs.hpp"
#include "orthodrive/io/opendrive/drive_log_io.hpp"
#include "paths.hpp"

namespace orthodrive {
namespace {

struct Agreement {
  double correlation = 0.0, rms = 0.0, mean = 0.0;
};
/// Of pairs: correlation, mean of b - a, root mean square of what is left without the mean.
Agreement agreement(const std::vector<double>& a, const std::vector<double>& b) {
  const double n = static_cast<double>(a.size());
  double ma = 0, mb = 0, aa = 0, bb = 0, ab = 0, dd = 0;
  for (std::size_t i = 0; i < a.size(); ++i) ma += a[i] / n, mb += b[i] / n;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const double x = a[i] - ma, y = b[i] - mb;
    aa += x * x, bb += y * y, ab += x * y, dd += (y - x) * (y - x);
  }
  return {ab / std::sqrt(aa * bb), std::sqrt(dd / n), mb - ma};
}

class RealDrive : public testing::Test {
 protected:
  void SetUp() override {
    const std::filesystem::path folder = paths::in_source("../shared/data/drives/comma2k19");
    if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no " << folder;
    const SiteFrame site{Crs{"EPSG:32610"},
                         {{{545000, 4173000}, {548000, 4173000}, {548000, 4178000}, {545000, 4178000}}, {}}};
    log = io::read_drive_logs({folder}, site).log;
    const auto& poses = log.recordings.at(0).poses;
    s.assign(poses.size(), 0.0);
    for (std::size_t i = 1; i < poses.size(); ++i) s[i] = s[i - 1] + distance(poses[i - 1].p, poses[i].p);
    roads = {site.crs, {{.osm_id = 1, .highway = "secondary"}}};
    for (double at = 0.0; at < s.back(); at += 2.0) {
      double x = 0, y = 0, n = 0;
      for (std::size_t i = 0; i < poses.size(); ++i)
        if (std::abs(s[i] - at) < 4.0) x += poses[i].p.x, y += poses[i].p.y, n += 1.0;
      roads.paths[0].nodes.push_back({.p = {x / n, y / n},
                                      .width_m = 8.0,
                                      .z_m = coarse_height(at),
                                      .sigma_z_m = 1.5,
                                      .banking_source = BankingSource::none});
    }
    auto& nodes = roads.paths[0].nodes;
    const auto along = arc_lengths_m(centerline(roads.paths[0]));
    for (std::size_t n = 0; n < nodes.size(); ++n) nodes[n].s_m = along[n];
    for (std::size_t n = 1; n + 1 < nodes.size(); ++n)
      nodes[n].gradient = (nodes[n + 1].z_m - nodes[n - 1].z_m) / (nodes[n + 1].s_m - nodes[n - 1].s_m);
  }

  /// Height of the log at a place, linear between poses.
  [[nodiscard]] double log_height(double at) const {
    const auto& poses = log.recordings[0].poses;
    const auto k = std::clamp<std::ptrdiff_t>(std::lower_bound(s.begin(), s.end(), at) - s.begin(), 1,
                                              static_cast<std::ptrdiff_t>(s.size()) - 1);
    const double f = std::clamp((at - s[k - 1]) / (s[k] - s[k - 1]), 0.0, 1.0);
    return poses[k - 1].z_m * (1.0 - f) + poses[k].z_m * f;
  }
  /// Mean over 160 m: what is shorter is for the drive to say.
  [[nodiscard]] double coarse_height(double at) const {
    double sum = 0.0;
    for (int k = -40; k <= 40; ++k) sum += log_height(std::clamp(at + 2.0 * k, 0.0, s.back())) / 81.0;
    return sum;
  }

  DriveLog log;
  RoadNetwork roads;
  std::vector<double> s;  ///< [pose] along the drive
};

TEST_F(RealDrive, gradient_of_the_pitch_agrees_with_the_heights) {
  FuseDriveLogsOptions pitch_only;
  pitch_only.accuracy.climb_mps = 1e3, pitch_only.accuracy.height_m = 1e3;
  pitch_only.terrain_error_length_m = 60.0;
  const auto result = fuse_drive_logs(roads, log, pitch_only);
  std::vector<double> pitch, height, coarse;
  const auto& nodes = result.roads.paths[0].nodes;
  for (std::size_t n = 10; n + 10 < nodes.size(); n += 5) {
    const double run = nodes[n + 5].s_m - nodes[n - 5].s_m;
    pitch.push_back((nodes[n + 5].z_m - nodes[n - 5].z_m) / run);
    coarse.push_back((roads.paths[0].nodes[n + 5].z_m - roads.paths[0].nodes[n - 5].z_m) / run);
    height.push_back(
        (log_height(10.0 + 2.0 * static_cast<double>(n)) - log_height(2.0 * static_cast<double>(n) - 10.0)) / 20.0);
  }
  const Agreement with_pitch = agreement(height, pitch), with_coarse = agreement(height, coarse);
  const DriveCalibration& c = result.calibration[0];
  test::record_measured("drive: %.0f m in %.0f s, %.0f m of it on the road; %zu poses, %zu inertial samples",
                        result.length_m, log.recordings[0].poses.back().time_s - log.recordings[0].poses.front().time_s,
                        result.matched_m, log.recordings[0].poses.size(), log.recordings[0].imu.size());
  test::record_measured(
      "gradient of the pitch against height differences over 20 m: correlation %.3f, RMS %.2f %%, mean "
      "%.2f %%",
      with_pitch.correlation, 100 * with_pitch.rms, 100 * with_pitch.mean);
  test::record_measured("gradient of the coarse profile alone: correlation %.3f, RMS %.2f %%", with_coarse.correlation,
                        100 * with_coarse.rms);
  test::record_measured("sensor: nose up by %.2f +- %.2f deg; body: %.2f +- %.2f deg/g when accelerating",
                        c.mount_pitch_rad * 180 / M_PI, c.sigma_mount_pitch_rad * 180 / M_PI,
                        c.pitch_rad_per_mps2 * 9.81 * 180 / M_PI, c.sigma_pitch_rad_per_mps2 * 9.81 * 180 / M_PI);
  EXPECT_GT(result.matched_m, 0.97 * result.length_m);
  EXPECT_GT(with_pitch.correlation, 0.95);
  EXPECT_LT(with_pitch.rms, 0.5 * with_coarse.rms);
}

TEST_F(RealDrive, lateral_force_agrees_with_the_rate_of_turn) {
  // The drive is nearly straight: what is left of the force after the turn is banking, body roll and mounting.
  const DriveRecording& recording = log.recordings[0];
  std::vector<double> turn, force;
  for (std::size_t i = 0, k = 0; i + 10 < recording.poses.size(); i += 10) {  // half a second each
    double f = 0, r = 0, n = 0, v = 0;
    for (std::size_t j = i; j < i + 10; ++j) v += recording.poses[j].speed_mps / 10.0;
    for (; k < recording.imu.size() && recording.imu[k].time_s < recording.poses[i + 10].time_s; ++k)
      f += recording.imu[k].specific_force_mps2.y, r += recording.imu[k].yaw_rate_radps, n += 1.0;
    turn.push_back(v * r / n), force.push_back(f / n);
  }
  const Agreement lateral = agreement(turn, force);
  const auto result = fuse_drive_logs(roads, log);
  double mean = 0, low = 1, high = -1, count = 0;
  for (const DrivenNode& driven : result.driven) {
    const double b = result.roads.paths[driven.path].nodes[driven.node].banking;
    mean += b, count += 1, low = std::min(low, b), high = std::max(high, b);
  }
  test::record_measured(
      "lateral specific force against speed x yaw rate over 0.5 s: correlation %.3f, RMS %.3f m/s2, mean "
      "%.3f m/s2",
      lateral.correlation, lateral.rms, lateral.mean);
  test::record_measured("banking: mean %.2f %%, from %.2f to %.2f %%; left over: roll %.2f deg, lateral force %.2f deg",
                        100 * mean / count, 100 * low, 100 * high, result.residuals.roll_rad * 180 / M_PI,
                        result.residuals.lateral_rad * 180 / M_PI);
  EXPECT_GT(lateral.correlation, 0.5);
  EXPECT_LT(result.residuals.roll_rad, 0.02);
}

TEST_F(RealDrive, all_of_it_together) {
  const auto start = std::chrono::steady_clock::now();
  const auto result = fuse_drive_logs(roads, log);
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  double sigma_gradient = 0, sigma_banking = 0;
  for (const DrivenNode& driven : result.driven)
    sigma_gradient += driven.sigma_gradient / static_cast<double>(result.driven.size()),
        sigma_banking +=
        result.roads.paths[driven.path].nodes[driven.node].sigma_banking / static_cast<double>(result.driven.size());
  test::record_measured(
      "all measurements: left over %.2f deg of pitch, %.2f %% of climb, %.3f m of height; sigma of "
      "gradient %.2f %%, of banking %.2f %%; %d passes",
      result.residuals.pitch_rad * 180 / M_PI, 100 * result.residuals.climb_gradient, result.residuals.height_m,
      100 * sigma_gradient, 100 * sigma_banking, result.solve.iterations);
  fprintf(stderr, "%.2f s\n", seconds);
  for (const RoughnessStretch& stretch : result.roughness)
    test::record_measured("roughness from %.0f to %.0f m: class %c, G_d(n0) %.0fe-6 m3 (factor %.1f), waviness %.1f",
                          stretch.s_begin_m, stretch.s_end_m, stretch.iso_8608_class, 1e6 * stretch.gd_n0_m3,
                          std::exp(stretch.sigma_ln_gd), stretch.waviness);
  EXPECT_TRUE(result.solve.converged);
  EXPECT_GE(result.roughness.size(), 6u);
  for (const RoughnessStretch& stretch : result.roughness) {  // an old asphalt street
    EXPECT_GT(stretch.gd_n0_m3, 2e-6);
    EXPECT_LT(stretch.gd_n0_m3, 512e-6);
  }
}

}  // namespace
}  // namespace orthodrive
