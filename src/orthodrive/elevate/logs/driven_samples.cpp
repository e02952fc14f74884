// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/elevate/logs/driven_samples.hpp"

#include <algorithm>
#include <cmath>

#include "orthodrive/geo/angle.hpp"

namespace orthodrive::elevate {
namespace {

constexpr double sample_m = 2.0;  // shorter curvature of a road is not resolved
constexpr double longest_sample_s = 2.0;
constexpr double shortest_imu_s = 0.2;  // engine and wheels shake a sensor: inertial values are means over this time
constexpr double change_reach_s = 0.5;  // to each side of a pose

/// Mean of the values that were recorded.
class Mean {
 public:
  void add(double value) {
    if (!std::isnan(value)) sum_ += value, count_ += 1.0;
  }
  [[nodiscard]] double value() const { return count_ > 0.0 ? sum_ / count_ : not_recorded; }

 private:
  double sum_ = 0.0, count_ = 0.0;
};

using Places = std::vector<std::optional<LogPlace>>;

/// Poses [begin, end) of a recording.
struct PoseRange {
  std::size_t begin = 0, end = 0;
};

/// Rate of change of an angle (heading) or a plain value (speed) around a pose, for logs without that sensor.
double change_per_s(const std::vector<DrivePose>& poses, std::size_t i, double DrivePose::*member, bool angle) {
  std::size_t a = i, b = i;
  while (a > 0 && poses[i].time_s - poses[a].time_s < change_reach_s) --a;
  while (b + 1 < poses.size() && poses[b].time_s - poses[i].time_s < change_reach_s) ++b;
  if (a == b) return not_recorded;
  const double change = poses[b].*member - poses[a].*member;
  return (angle ? wrapped_angle(change) : change) / (poses[b].time_s - poses[a].time_s);
}

double speed_from_positions(const std::vector<DrivePose>& poses, std::size_t i) {
  const std::size_t a = i > 0 ? i - 1 : i, b = std::min(i + 1, poses.size() - 1);
  return a == b ? not_recorded : distance(poses[a].p, poses[b].p) / (poses[b].time_s - poses[a].time_s);
}

/// The poses from `begin` on that lie within one sample: same path, same direction, 2 m, 2 s.
PoseRange range_from(const std::vector<DrivePose>& poses, const Places& places, std::size_t begin) {
  std::size_t end = begin + 1;
  const auto same = [&](std::size_t i) {
    return places[i] && places[i]->path == places[begin]->path && places[i]->forward == places[begin]->forward &&
           std::abs(places[i]->s_m - places[begin]->s_m) < sample_m &&
           poses[i].time_s - poses[begin].time_s < longest_sample_s;
  };
  while (end < poses.size() && same(end)) ++end;
  return {begin, end};
}

/// Where the sample lies on its chain.
void locate(const LogChains& chains, const Places& places, PoseRange range, DrivenSample& sample) {
  Mean along, beside;
  // NOLINTBEGIN(bugprone-unchecked-optional-access): all poses of a range lie on a road
  for (std::size_t i = range.begin; i < range.end; ++i) along.add(places[i]->s_m), beside.add(places[i]->offset_m);
  const LogPlace& place = *places[range.begin];
  // NOLINTEND(bugprone-unchecked-optional-access)
  const double sign = chains.sign(place.path);
  sample.chain = chains.chain_of[place.path];
  sample.along_m = chains.along_m(place.path, along.value());
  sample.beside_m = sign * beside.value();
  sample.direction = place.forward ? sign : -sign;
}

/// Means of what the poses hold: attitude, height, speed.
void average_poses(const std::vector<DrivePose>& poses, PoseRange range, DrivenSample& sample) {
  Mean time, z, nose_up, roll, speed, climb, yaw, acceleration;
  for (std::size_t i = range.begin; i < range.end; ++i) {
    const DrivePose& pose = poses[i];
    time.add(pose.time_s), z.add(pose.z_m);
    nose_up.add(-pose.pitch_rad), roll.add(pose.roll_rad), climb.add(pose.climb_mps);
    speed.add(std::isnan(pose.speed_mps) ? speed_from_positions(poses, i) : pose.speed_mps);
    yaw.add(change_per_s(poses, i, &DrivePose::heading_rad, true));
    acceleration.add(change_per_s(poses, i, &DrivePose::speed_mps, false));
  }
  sample.time_s = time.value();
  sample.z_m = z.value(), sample.nose_up_rad = nose_up.value(), sample.roll_rad = roll.value();
  sample.speed_mps = speed.value(), sample.climb_mps = climb.value();
  sample.acceleration_mps2 = acceleration.value();
  sample.yaw_rate_radps = yaw.value();  // unless a gyroscope measured it
}

/// The time that the sample covers, and means of what the inertial sensors measured in it.
void average_imu(const DriveRecording& recording, PoseRange range, DrivenSample& sample) {
  const auto& poses = recording.poses;
  const std::size_t last = poses.size() - 1;  // half way to the poses beside the sample
  const double from_s = 0.5 * (poses[range.begin > 0 ? range.begin - 1 : 0].time_s + poses[range.begin].time_s),
               to_s = 0.5 * (poses[range.end - 1].time_s + poses[std::min(range.end, last)].time_s);
  sample.span_s = to_s - from_s, sample.step_s = sample.span_s / static_cast<double>(range.end - range.begin);
  Mean forward, left, rate;
  const double margin_s = std::max(0.0, 0.5 * (shortest_imu_s - sample.span_s));
  auto imu = std::lower_bound(recording.imu.begin(), recording.imu.end(), from_s - margin_s,
                              [](const DriveImu& m, double t) { return m.time_s < t; });
  for (; imu != recording.imu.end() && imu->time_s <= to_s + margin_s; ++imu)
    forward.add(imu->specific_force_mps2.x), left.add(imu->specific_force_mps2.y), rate.add(imu->yaw_rate_radps);
  sample.forward_mps2 = forward.value(), sample.left_mps2 = left.value();
  if (!std::isnan(rate.value())) sample.yaw_rate_radps = rate.value();
}

}  // namespace

std::vector<DrivenSample> driven_samples(const LogChains& chains, const DriveRecording& recording, std::size_t number,
                                         const Places& places) {
  std::vector<DrivenSample> samples;
  const auto& poses = recording.poses;
  for (std::size_t i = 0; i < poses.size();) {
    if (!places[i]) {
      ++i;
      continue;
    }
    const PoseRange range = range_from(poses, places, i);
    DrivenSample sample{.recording = number, .source = recording.source};
    locate(chains, places, range, sample);
    average_poses(poses, range, sample);
    average_imu(recording, range, sample);
    samples.push_back(sample);
    i = range.end;
  }
  return samples;
}

double sigma_of_mean(double sigma, double correlation_s, const DrivenSample& sample) {
  const double independent = sample.span_s / std::max(correlation_s, std::max(1e-3, sample.step_s));
  return sigma / std::sqrt(std::clamp(independent, 1e-3, 4.0));  // a car at rest measures the same error again
}

}  // namespace orthodrive::elevate
