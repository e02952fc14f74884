// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/elevate/logs/sensor_model.hpp"

#include <algorithm>
#include <cmath>

#include "orthodrive/elevate/logs/given_profile.hpp"

namespace orthodrive::elevate {
namespace {

using enum FusionColumns::Parameter;

constexpr double gravity_mps2 = 9.81;
constexpr double slowest_climb_mps = 2.0;         // below, climb over speed is noise
constexpr double height_offset_sigma_m = 1000.0;  // datum, geoid and antenna: not known at all
constexpr double gyro_bias_sigma_radps = 0.01;    // of an uncalibrated MEMS gyroscope
constexpr double yaw_mounting_sigma_rad = 0.05;
constexpr double half_track_m = 0.75;  // wheels of a car from its middle

/// The road below a car, in the direction of travel at the lane that it drives on: as given (index 0), and with the
/// present corrections.
class RoadBelow {
 public:
  RoadBelow(const FusionProblem& problem, const DrivenSample& sample, const std::vector<double>& x)
      : given_(given_profile_at(problem.roads, problem.chains, sample.chain, sample.along_m, problem.options)),
        basis_(problem.columns.spline(sample.chain).at(sample.along_m)),
        z_(problem.columns.z(sample.chain) + basis_.first),
        banking_column_(problem.columns.banking(sample.chain) + basis_.first),
        direction_(sample.direction),
        beside_m_(sample.beside_m) {
    const double d = direction_, t = beside_m_;
    // The crown leans a car beside the ridge; astride of it not at all.
    const double lean = std::clamp(t / half_track_m, -1.0, 1.0) * given_.crown_rad;
    gradient_0 = d * (given_.gradient + t * given_.banking_change), banking_0 = d * (given_.banking_rad - lean);
    gradient = gradient_0 + d * (combine(x, z_, basis_.slope) + t * combine(x, banking_column_, basis_.slope));
    banking = banking_0 + d * combine(x, banking_column_, basis_.value);
  }

  double gradient_0, banking_0, gradient, banking;

  void add_gradient(Entries& entries, double scale) const {
    append(entries, z_, basis_.slope, direction_ * scale);
    append(entries, banking_column_, basis_.slope, direction_ * beside_m_ * scale);
  }
  void add_banking(Entries& entries) const { append(entries, banking_column_, basis_.value, direction_); }
  void add_height(Entries& entries) const {
    append(entries, z_, basis_.value), append(entries, banking_column_, basis_.value, beside_m_);
  }
  /// How far a measured height lies over the given surface below the car.
  [[nodiscard]] double over_given_m(double z_m) const {
    return z_m - given_.z_m - beside_m_ * given_.banking_rad +
           std::max(half_track_m, std::abs(beside_m_)) * given_.crown_rad;
  }

 private:
  GivenProfile given_;
  UniformSpline::Basis basis_;
  int z_, banking_column_;
  double direction_, beside_m_;
};

/// Specific force in the car and centripetal acceleration; what was not felt follows from speed and road.
struct CarForces {
  double forward_mps2 = 0.0, left_mps2 = 0.0, turn_mps2 = 0.0;
};

CarForces forces_of(const DrivenSample& sample, const RoadBelow& road) {
  CarForces f{sample.forward_mps2, sample.left_mps2, sample.speed_mps * sample.yaw_rate_radps};
  if (std::isnan(f.forward_mps2))
    f.forward_mps2 =
        (std::isnan(sample.acceleration_mps2) ? 0.0 : sample.acceleration_mps2) + gravity_mps2 * road.gradient;
  if (std::isnan(f.left_mps2))
    f.left_mps2 = (std::isnan(f.turn_mps2) ? 0.0 : f.turn_mps2) + gravity_mps2 * road.banking;
  return f;
}

/// Gradient from the pitch of the attitude (atan(gradient) + mounting + squat) and from the vertical velocity.
void add_gradient_measurements(const FusionProblem& problem, const DrivenSample& sample, const RoadBelow& road,
                               const CarForces& forces, std::vector<Measurement>& list) {
  const DriveLogAccuracy& a = problem.options.accuracy;
  if (!std::isnan(sample.nose_up_rad)) {
    const double slope = 1.0 / (1.0 + road.gradient * road.gradient);
    Measurement m{.value = sample.nose_up_rad - std::atan(road.gradient) + slope * (road.gradient - road.gradient_0),
                  .sigma = a.pitch_rad,
                  .sigma_of_mean = sigma_of_mean(a.pitch_rad, a.pitch_correlation_s, sample),
                  .kind = &DriveResiduals::pitch_rad};
    road.add_gradient(m.entries, slope);
    m.entries.push_back({problem.columns.source(sample.source, mount_pitch), 1.0});
    m.entries.push_back({problem.columns.source(sample.source, pitch_gain), forces.forward_mps2});
    list.push_back(std::move(m));
  }
  if (!std::isnan(sample.climb_mps) && sample.speed_mps > slowest_climb_mps) {
    Measurement m{.value = sample.climb_mps / sample.speed_mps - road.gradient_0,
                  .sigma = a.climb_mps / sample.speed_mps,
                  .sigma_of_mean = sigma_of_mean(a.climb_mps, a.climb_correlation_s, sample) / sample.speed_mps,
                  .kind = &DriveResiduals::climb_gradient};
    road.add_gradient(m.entries, 1.0);
    list.push_back(std::move(m));
  }
}

/// Height of the road below the car + offset + drift (linear between its knots).
void add_height_measurement(const FusionProblem& problem, const DrivenSample& sample, const RoadBelow& road,
                            std::vector<Measurement>& list) {
  if (std::isnan(sample.z_m)) return;
  const DriveLogAccuracy& a = problem.options.accuracy;
  Measurement m{.value = road.over_given_m(sample.z_m),
                .sigma = a.height_m,
                .sigma_of_mean = sigma_of_mean(a.height_m, a.height_correlation_s, sample),
                .kind = &DriveResiduals::height_m};
  road.add_height(m.entries);
  const DriveRecording& recording = problem.log.recordings[sample.recording];
  const int offset = problem.columns.height_offset(sample.recording), last = drift_knots(recording) - 2;
  const double x = (sample.time_s - recording.poses.front().time_s) / drift_step_s;
  const int knot = std::clamp(static_cast<int>(x), 0, std::max(0, last));
  m.entries.push_back({offset, 1.0});
  m.entries.push_back({offset + 1 + knot, 1.0 - (x - knot)});
  if (last >= 0) m.entries.push_back({offset + 2 + knot, x - knot});
  list.push_back(std::move(m));
}

/// Banking from the roll of the attitude, and from g sin(roll) = specific force - speed * yaw rate. A navigation filter
/// computes the roll from those sensors: where a log has both, each counts half.
void add_banking_measurements(const FusionProblem& problem, const DrivenSample& sample, const RoadBelow& road,
                              const CarForces& forces, std::vector<Measurement>& list) {
  const DriveLogAccuracy& a = problem.options.accuracy;
  const auto source = [&](FusionColumns::Parameter p) { return problem.columns.source(sample.source, p); };
  const bool lateral = !std::isnan(forces.turn_mps2) && !std::isnan(sample.left_mps2);
  const double half = !std::isnan(sample.roll_rad) && lateral ? std::sqrt(2.0) : 1.0;
  if (!std::isnan(sample.roll_rad)) {
    Measurement m{.value = sample.roll_rad - road.banking_0,
                  .sigma = a.roll_rad,
                  .sigma_of_mean = half * sigma_of_mean(a.roll_rad, a.roll_correlation_s, sample),
                  .kind = &DriveResiduals::roll_rad};
    road.add_banking(m.entries);
    m.entries.push_back({source(mount_roll), 1.0});
    m.entries.push_back({source(roll_gain), forces.left_mps2});
    list.push_back(std::move(m));
  }
  if (lateral) {
    const double sine = std::clamp((sample.left_mps2 - forces.turn_mps2) / gravity_mps2, -0.5, 0.5);
    Measurement m{.value = std::asin(sine) - road.banking_0,
                  .sigma = a.lateral_mps2 / gravity_mps2,
                  .sigma_of_mean = half * sigma_of_mean(a.lateral_mps2, a.lateral_correlation_s, sample) / gravity_mps2,
                  .kind = &DriveResiduals::lateral_rad};
    road.add_banking(m.entries);
    m.entries.push_back({source(lateral_offset), 1.0});
    m.entries.push_back({source(roll_gain), forces.left_mps2});
    m.entries.push_back({source(gyro_bias), sample.speed_mps / gravity_mps2});
    m.entries.push_back({source(mount_yaw), forces.forward_mps2 / gravity_mps2});
    list.push_back(std::move(m));
  }
}

}  // namespace

double Measurement::residual(const std::vector<double>& x) const {
  double sum = -value;
  for (const auto& [column, factor] : entries) sum += factor * x[static_cast<std::size_t>(column)];
  return sum;
}

std::vector<Measurement> measurements_of(const FusionProblem& problem, const DrivenSample& sample,
                                         const std::vector<double>& x) {
  const RoadBelow road(problem, sample, x);
  const CarForces forces = forces_of(sample, road);
  std::vector<Measurement> list;
  add_gradient_measurements(problem, sample, road, forces, list);
  add_height_measurement(problem, sample, road, list);
  add_banking_measurements(problem, sample, road, forces, list);
  return list;
}

void add_sensor_priors(const FusionProblem& problem, WeightedRows& rows) {
  const DriveLogAccuracy& a = problem.options.accuracy;
  const SuspensionPrior& s = problem.options.suspension;
  for (std::size_t k = 0; k < problem.log.sources.size(); ++k) {
    const auto add = [&](FusionColumns::Parameter p, double mean, double sigma) {
      rows.add({{problem.columns.source(k, p), 1.0}}, mean, 1.0 / sigma);
    };
    add(mount_pitch, 0.0, a.mounting_rad), add(mount_roll, 0.0, a.mounting_rad),
        add(lateral_offset, 0.0, a.mounting_rad);
    add(pitch_gain, s.pitch_rad_per_mps2, s.pitch_sigma), add(roll_gain, s.roll_rad_per_mps2, s.roll_sigma);
    add(gyro_bias, 0.0, gyro_bias_sigma_radps), add(mount_yaw, 0.0, yaw_mounting_sigma_rad);
  }
  // d(t + dt) = f d(t) + N(0, sigma^2 (1 - f^2)), f = exp(-dt / tau)
  const double f = std::exp(-drift_step_s / a.height_drift_s), step_sigma = a.height_drift_m * std::sqrt(1.0 - f * f);
  for (std::size_t r = 0; r < problem.log.recordings.size(); ++r) {
    const int offset = problem.columns.height_offset(r), knots = drift_knots(problem.log.recordings[r]);
    rows.add({{offset, 1.0}}, 0.0, 1.0 / height_offset_sigma_m);
    rows.add({{offset + 1, 1.0}}, 0.0, 1.0 / a.height_drift_m);
    for (int i = 1; i < knots; ++i) rows.add({{offset + i, -f}, {offset + i + 1, 1.0}}, 0.0, 1.0 / step_sigma);
  }
}

}  // namespace orthodrive::elevate
