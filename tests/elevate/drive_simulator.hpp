// SPDX-License-Identifier: Apache-2.0
#pragma once
// A road known exactly, a terrain model's idea of it, and a car that drives on it with sensors as real ones err.

#include <cmath>
#include <cstdint>
#include <functional>
#include <numbers>
#include <vector>

#include "orthodrive/core/random.hpp"
#include "orthodrive/elevate/logs/measure_roughness.hpp"
#include "orthodrive/model/roads/drive_log.hpp"
#include "orthodrive/model/roads/road_network.hpp"

namespace orthodrive {

inline const Crs drive_crs{"EPSG:32633"};
constexpr double standard_gravity = 9.81;

/// A winding, hilly road along +x. Banking leans into the bends.
struct TrueRoad {
  double length_m = 1200.0, bend_1pm = 0.006, hill_m = 6.0;
  double crown_rad = 0.0, crown_end_m = 0.0;  ///< from the begin of the road
  std::vector<Vec2> points;                   ///< every metre

  explicit TrueRoad(double length = 1200.0, double bend = 0.006, double hill = 6.0)
      : length_m(length), bend_1pm(bend), hill_m(hill) {
    Vec2 p{1000.0, 2000.0};
    for (int i = 0; i <= static_cast<int>(length_m) + 50; ++i) {
      points.push_back(p);
      const double h = heading(i + 0.5);
      p = p + Vec2{std::cos(h), std::sin(h)};
    }
  }
  [[nodiscard]] double curvature(double s) const { return bend_1pm * std::sin(2.0 * std::numbers::pi * s / 400.0); }
  [[nodiscard]] double heading(double s) const {
    return -bend_1pm * 400.0 / (2.0 * std::numbers::pi) * std::cos(2.0 * std::numbers::pi * s / 400.0);
  }
  [[nodiscard]] double z(double s) const {
    return 50.0 + hill_m * std::sin(2.0 * std::numbers::pi * s / 500.0) +
           0.8 * std::sin(2.0 * std::numbers::pi * s / 110.0);
  }
  [[nodiscard]] double gradient(double s) const {
    const double w = 2.0 * std::numbers::pi;
    return hill_m * w / 500.0 * std::cos(w * s / 500.0) + 0.8 * w / 110.0 * std::cos(w * s / 110.0);
  }
  [[nodiscard]] double banking(double s) const { return bend_1pm > 0.0 ? -0.05 * curvature(s) / bend_1pm : 0.0; }
  [[nodiscard]] double banking_change(double s) const { return (banking(s + 0.5) - banking(s - 0.5)); }
  [[nodiscard]] double crown(double s) const { return s < crown_end_m ? crown_rad : 0.0; }
  [[nodiscard]] Vec2 at(double s, double t = 0.0) const {
    const double x = std::max(0.0, s);
    const auto i = std::min(points.size() - 2, static_cast<std::size_t>(x));
    const double h = heading(s);
    return points[i] + (points[i + 1] - points[i]) * (x - static_cast<double>(i)) + Vec2{-std::sin(h), std::cos(h)} * t;
  }
};

/// A stationary process of the covariance that the fusion assumes (Matern 5/2), as a sum of waves.
class TerrainError {
 public:
  TerrainError(double sigma_m, double length_m, std::uint64_t seed) {
    Random random(seed);
    constexpr int waves = 200;
    for (int i = 0; i < waves; ++i) {  // its spectrum is Student's t with five degrees of freedom
      double squares = 0.0;
      for (int k = 0; k < 5; ++k) squares += std::pow(random.normal(), 2);
      const double t = random.normal() / std::sqrt(squares / 5.0);
      wave_.push_back({std::abs(t) / length_m, random.uniform(0.0, 2.0 * std::numbers::pi)});
    }
    amplitude_ = sigma_m * std::sqrt(2.0 / waves);
  }
  [[nodiscard]] double value(double s) const {
    double sum = 0.0;
    for (const auto& [w, phase] : wave_) sum += std::cos(w * s + phase);
    return amplitude_ * sum;
  }
  [[nodiscard]] double slope(double s) const {
    double sum = 0.0;
    for (const auto& [w, phase] : wave_) sum -= w * std::sin(w * s + phase);
    return amplitude_ * sum;
  }

 private:
  std::vector<std::pair<double, double>> wave_;
  double amplitude_;
};

/// The road as the stage elevate leaves it: nodes every 2 m, heights with the terrain's errors, no banking.
inline RoadNetwork road_from_terrain(const TrueRoad& road, double sigma_z_m, std::uint64_t seed = 1) {
  const TerrainError error(sigma_z_m, 30.0, seed);
  RoadPath path{.osm_id = 7, .highway = "secondary"};
  for (double s = 0.0; s <= road.length_m; s += 2.0)
    path.nodes.push_back({.p = road.at(s),
                          .s_m = s,
                          .width_m = 7.0,
                          .z_m = road.z(s) + error.value(s),
                          .gradient = road.gradient(s) + error.slope(s),
                          .crown = road.crown(s),
                          .sigma_z_m = sigma_z_m,
                          .banking_source = BankingSource::none});
  path.nodes.front().osm_node = 1, path.nodes.back().osm_node = 2;
  return {drive_crs, {path}};
}

/// First-order Gauss-Markov noise.
class Drift {
 public:
  Drift(double sigma, double correlation_s, std::uint64_t seed)
      : sigma_(sigma), correlation_s_(correlation_s), random_(seed), value_(sigma * random_.normal()) {}
  double next(double step_s) {
    const double f = std::exp(-step_s / correlation_s_);
    const double now = value_;
    value_ = f * value_ + sigma_ * std::sqrt(1.0 - f * f) * random_.normal();
    return now;
  }

 private:
  double sigma_, correlation_s_;
  Random random_;
  double value_;
};

struct SimulatedDrive {
  bool forward = true;
  double lane_m = 1.75;  ///< to the right of the centre line, in the direction of travel
  double begin_m = 5.0, end_m = 1195.0;
  double mount_pitch_rad = -0.06, mount_roll_rad = 0.02;  ///< nose up, left side up
  double pitch_rad_per_mps2 = 0.004, roll_rad_per_mps2 = 0.006;
  double height_offset_m = -31.0, height_drift_m = 1.5, position_drift_m = 1.2;
  double pitch_noise_rad = 0.003, roll_noise_rad = 0.004, climb_noise_mps = 0.06;
  double lateral_noise_mps2 = 0.15, gyro_bias_radps = 0.003;
  double poses_hz = 20.0, imu_hz = 100.0, speed_mps = 15.0;
  std::uint64_t seed = 11;
};

/// What the sensors of that car record. No roughness.
inline DriveRecording simulate_drive(const TrueRoad& road, const SimulatedDrive& drive) {
  DriveRecording recording;
  const double d = drive.forward ? 1.0 : -1.0, t = -d * drive.lane_m;
  Drift east(drive.position_drift_m, 120.0, derive_seed(drive.seed, 1)),
      north(drive.position_drift_m, 120.0, derive_seed(drive.seed, 2)),
      height(drive.height_drift_m, 120.0, derive_seed(drive.seed, 3)),
      pitch(drive.pitch_noise_rad, 0.5, derive_seed(drive.seed, 4)),
      roll(drive.roll_noise_rad, 0.5, derive_seed(drive.seed, 5)),
      climb(drive.climb_noise_mps, 0.7, derive_seed(drive.seed, 6)),
      lateral(drive.lateral_noise_mps2, 0.05, derive_seed(drive.seed, 7));
  Random white(drive.seed);
  const double step_s = 1.0 / drive.imu_hz;
  const int pose_every = std::max(1, static_cast<int>(std::lround(drive.imu_hz / drive.poses_hz)));
  double s = drive.forward ? drive.begin_m : drive.end_m, time = 100.0;
  for (int i = 0; s >= drive.begin_m && s <= drive.end_m; ++i, time += step_s) {
    const double w = 2.0 * std::numbers::pi / 20.0;
    const double speed = drive.speed_mps + 3.0 * std::sin(w * time), acceleration = 3.0 * w * std::cos(w * time);
    const double gradient = d * (road.gradient(s) + t * road.banking_change(s)),
                 banking = d * (road.banking(s) - std::copysign(road.crown(s), t));
    const double turn = d * speed * road.curvature(s);
    const double forward_force = acceleration + standard_gravity * gradient,
                 left_force = speed * turn + standard_gravity * banking;
    const double body_roll = banking + drive.roll_rad_per_mps2 * left_force;
    const double lateral_noise = lateral.next(step_s);
    recording.imu.push_back({time,
                             {forward_force + 0.2 * white.normal() + 0.3,
                              speed * turn + standard_gravity * std::sin(body_roll) + 0.1 + lateral_noise,
                              standard_gravity + 0.3 * white.normal()},
                             turn + drive.gyro_bias_radps + 0.002 * white.normal()});
    if (i % pose_every == 0) {
      const double dt = pose_every * step_s;
      DrivePose pose{.time_s = time};
      pose.p = road.at(s, t) + Vec2{east.next(dt), north.next(dt)};
      pose.z_m = road.z(s) + t * road.banking(s) - std::abs(t) * road.crown(s) + drive.height_offset_m +
                 height.next(dt) + 0.02 * white.normal();
      pose.pitch_rad =
          -(std::atan(gradient) + drive.mount_pitch_rad + drive.pitch_rad_per_mps2 * forward_force + pitch.next(dt));
      pose.roll_rad = body_roll + drive.mount_roll_rad + roll.next(dt);
      pose.heading_rad = road.heading(s) + (drive.forward ? 0.0 : std::numbers::pi) + 0.01 * white.normal();
      pose.speed_mps = speed + 0.03 * white.normal();
      pose.climb_mps = speed * gradient + climb.next(dt);
      recording.poses.push_back(pose);
    }
    s += d * speed * step_s;
  }
  while (!recording.imu.empty() && recording.imu.back().time_s > recording.poses.back().time_s)
    recording.imu.pop_back();
  return recording;
}

inline DriveLog log_of(std::vector<DriveRecording> recordings) {
  DriveLog log{.crs = drive_crs};
  for (std::size_t i = 0; i < recordings.size(); ++i) {
    recordings[i].source = i;
    log.sources.push_back("drive " + std::to_string(i));
  }
  log.recordings = std::move(recordings);
  return log;
}

}  // namespace orthodrive
