#include "orthodrive/elevate/fuse_drive_logs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <queue>
#include <set>
#include <utility>

#include "orthodrive/core/error.hpp"
#include "orthodrive/core/normal_matrix.hpp"
#include "orthodrive/elevate/log_chains.hpp"
#include "orthodrive/elevate/uniform_spline.hpp"
#include "orthodrive/model/path_crossings.hpp"

namespace orthodrive {
namespace {

constexpr double gravity_mps2 = 9.81;
constexpr double bin_m = 2.0;  // measurements of 2 m of road are one place; curvature shows no less
constexpr double longest_bin_s = 2.0;
constexpr double slowest_climb_mps = 2.0;  // below, climb over speed is noise
constexpr double drift_step_s = 2.0;
constexpr double height_offset_sigma_m = 1000.0;  // datum, geoid and antenna: not known at all
constexpr double gyro_bias_sigma_radps = 0.01;    // of an uncalibrated MEMS gyroscope
constexpr double yaw_mounting_sigma_rad = 0.05;
constexpr double robust_scale = 3.0;  // residuals beyond so many standard deviations lose their weight (Cauchy)
constexpr double tie_height_m = 2e-5, tie_slope = 5e-4;  // how exactly roads agree where they meet
constexpr double smallest_sigma_z_m = 0.02, smallest_sigma_banking_rad = 0.001;
constexpr double half_track_m = 0.75;  // wheels of a car from its middle
constexpr double driven_reach_m = 10.0;
constexpr int most_passes = 12;
constexpr double settled_m = 5e-4;

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

/// What was measured over some metres of road.
struct Bin {
  std::size_t chain = 0, recording = 0, source = 0;
  double along_m = 0.0;                             ///< on the chain
  double beside_m = 0.0;                            ///< to its left
  double direction = 1.0;                           ///< +1: driven along the chain
  double time_s = 0.0, span_s = 0.0, step_s = 0.0;  ///< span: that these measurements stand for; step: between poses
  double z_m = not_recorded, nose_up_rad = not_recorded, roll_rad = not_recorded, speed_mps = not_recorded,
         climb_mps = not_recorded;
  double forward_mps2 = not_recorded, left_mps2 = not_recorded;  ///< specific force
  double acceleration_mps2 = not_recorded;                       ///< change of speed, where there is no sensor of it
  double yaw_rate_radps = not_recorded;
};

/// The given profile at a place, along its chain.
struct Baseline {
  double z_m, gradient, banking_rad, banking_change, crown_rad, sigma_z_m, sigma_banking_rad;
};

Baseline baseline_at(const RoadNetwork& roads, const LogChains& chains, std::size_t chain, double along_m,
                     const FuseDriveLogsOptions& options) {
  const auto& parts = chains.chains[chain].parts;
  auto part = std::upper_bound(parts.begin(), parts.end(), along_m,
                               [](double s, const LogChain::Part& p) { return s < p.begin_m; });
  if (part != parts.begin()) --part;
  const double sign = part->reversed ? -1.0 : 1.0;
  const double s = std::clamp(part->reversed ? part->begin_m + part->length_m - along_m : along_m - part->begin_m, 0.0,
                              part->length_m);
  const auto& nodes = roads.paths[part->path].nodes;
  const auto after =
      std::upper_bound(nodes.begin() + 1, nodes.end() - 1, s, [](double x, const RoadNode& n) { return x < n.s_m; });
  const RoadNode &a = *(after - 1), &b = *after;
  const double run = std::max(1e-6, b.s_m - a.s_m), u = std::clamp((s - a.s_m) / run, 0.0, 1.0), v = 1.0 - u;
  const auto mixed = [&](double x, double y) { return v * x + u * y; };
  const auto sigma_z = [&](const RoadNode& n) {
    return std::max(smallest_sigma_z_m, n.sigma_z_m > 0.0 ? n.sigma_z_m : options.unknown_sigma_z_m);
  };
  const auto sigma_banking = [&](const RoadNode& n) {
    return std::max(smallest_sigma_banking_rad,
                    n.sigma_banking > 0.0 ? n.sigma_banking : options.unknown_sigma_banking_rad);
  };
  return {v * v * (1.0 + 2.0 * u) * a.z_m + u * u * (3.0 - 2.0 * u) * b.z_m +
              u * v * run * (v * a.gradient - u * b.gradient),  // Hermite
          sign * mixed(a.gradient, b.gradient),
          sign * mixed(a.banking, b.banking),
          (b.banking - a.banking) / run,  // both signs turn round
          mixed(a.crown, b.crown),
          mixed(sigma_z(a), sigma_z(b)),
          mixed(sigma_banking(a), sigma_banking(b))};
}

// --- measurements

/// Rate of turn from the attitude, for logs without a gyroscope; change of speed. Over half a second to each side.
double change_per_s(const std::vector<DrivePose>& poses, std::size_t i, double DrivePose::*member, bool angle) {
  std::size_t a = i, b = i;
  while (a > 0 && poses[i].time_s - poses[a].time_s < 0.5) --a;
  while (b + 1 < poses.size() && poses[b].time_s - poses[i].time_s < 0.5) ++b;
  if (a == b) return not_recorded;
  const double change = poses[b].*member - poses[a].*member;
  return (angle ? std::remainder(change, 2.0 * M_PI) : change) / (poses[b].time_s - poses[a].time_s);
}

class BinMaker {
 public:
  BinMaker(const LogChains& chains, const DriveRecording& recording, std::size_t number, std::vector<Bin>& bins)
      : chains_(chains), recording_(recording), number_(number), bins_(bins) {}

  void make(const std::vector<std::optional<LogPlace>>& places) {
    const auto& poses = recording_.poses;
    for (std::size_t begin = 0; begin < poses.size();) {
      if (!places[begin]) {
        ++begin;
        continue;
      }
      std::size_t end = begin + 1;
      const auto same = [&](std::size_t i) {
        return places[i] && places[i]->path == places[begin]->path && places[i]->forward == places[begin]->forward &&
               std::abs(places[i]->s_m - places[begin]->s_m) < bin_m &&
               poses[i].time_s - poses[begin].time_s < longest_bin_s;
      };
      while (end < poses.size() && same(end)) ++end;
      add_bin(places, begin, end);
      begin = end;
    }
  }

 private:
  void add_bin(const std::vector<std::optional<LogPlace>>& places, std::size_t begin, std::size_t end) {
    const auto& poses = recording_.poses;
    Mean along, beside, time, z, nose_up, roll, speed, climb, yaw, acceleration;
    for (std::size_t i = begin; i < end; ++i) {
      const DrivePose& pose = poses[i];
      along.add(places[i]->s_m), beside.add(places[i]->offset_m), time.add(pose.time_s), z.add(pose.z_m);
      nose_up.add(-pose.pitch_rad), roll.add(pose.roll_rad), climb.add(pose.climb_mps);
      speed.add(std::isnan(pose.speed_mps) ? speed_from_places(i) : pose.speed_mps);
      yaw.add(change_per_s(poses, i, &DrivePose::heading_rad, true));
      acceleration.add(change_per_s(poses, i, &DrivePose::speed_mps, false));
    }
    const LogPlace& place = *places[begin];
    const double sign = chains_.sign(place.path);
    Bin bin{.chain = chains_.chain_of[place.path], .recording = number_, .source = recording_.source};
    bin.along_m = chains_.along_m(place.path, along.value());
    bin.beside_m = sign * beside.value();
    bin.direction = place.forward ? sign : -sign;
    bin.time_s = time.value();
    const std::size_t last = poses.size() - 1;  // half way to the poses beside the bin
    const double from_s = 0.5 * (poses[begin > 0 ? begin - 1 : 0].time_s + poses[begin].time_s),
                 to_s = 0.5 * (poses[end - 1].time_s + poses[std::min(end, last)].time_s);
    bin.span_s = to_s - from_s, bin.step_s = bin.span_s / static_cast<double>(end - begin);
    bin.z_m = z.value(), bin.nose_up_rad = nose_up.value(), bin.roll_rad = roll.value();
    bin.speed_mps = speed.value(), bin.climb_mps = climb.value();
    bin.acceleration_mps2 = acceleration.value();
    Mean forward, left, rate;
    const double margin_s =
        std::max(0.0, 0.5 * (0.2 - bin.span_s));  // engine and wheels shake a sensor: 0.2 s at least
    auto imu = std::lower_bound(recording_.imu.begin(), recording_.imu.end(), from_s - margin_s,
                                [](const DriveImu& m, double t) { return m.time_s < t; });
    for (; imu != recording_.imu.end() && imu->time_s <= to_s + margin_s; ++imu)
      forward.add(imu->specific_force_mps2.x), left.add(imu->specific_force_mps2.y), rate.add(imu->yaw_rate_radps);
    bin.forward_mps2 = forward.value(), bin.left_mps2 = left.value();
    bin.yaw_rate_radps = std::isnan(rate.value()) ? yaw.value() : rate.value();
    bins_.push_back(bin);
  }
  [[nodiscard]] double speed_from_places(std::size_t i) const {
    const auto& poses = recording_.poses;
    const std::size_t a = i > 0 ? i - 1 : i, b = std::min(i + 1, poses.size() - 1);
    return a == b ? not_recorded : distance(poses[a].p, poses[b].p) / (poses[b].time_s - poses[a].time_s);
  }

  const LogChains& chains_;
  const DriveRecording& recording_;
  std::size_t number_;
  std::vector<Bin>& bins_;
};

/// Standard deviation of the mean of a bin, so that bins in a row count as many times as there are independent errors.
double bin_sigma(double sigma, double correlation_s, const Bin& bin) {
  const double independent = bin.span_s / std::max(correlation_s, std::max(1e-3, bin.step_s));
  return sigma / std::sqrt(std::clamp(independent, 1e-3, 4.0));  // a car at rest learns nothing new
}

// --- places where roads meet

struct Meeting {
  std::size_t path = 0, node = 0, chain = 0;
  double along_m = 0.0;
};
/// [osm_node] with two places at least.
using Meetings = std::map<std::int64_t, std::vector<Meeting>>;

Meetings find_meetings(const RoadNetwork& roads, const LogChains& chains) {
  Meetings all;
  for (std::size_t k = 0; k < roads.paths.size(); ++k)
    for (std::size_t n = 0; n < roads.paths[k].nodes.size(); ++n)
      if (const RoadNode& node = roads.paths[k].nodes[n]; node.osm_node > 0)
        all[node.osm_node].push_back({k, n, chains.chain_of[k], chains.along_m(k, node.s_m)});
  std::erase_if(all, [](const auto& entry) { return entry.second.size() < 2; });
  return all;
}

/// Chains with measurements, and those so near to them along the roads that their heights move as well (Dijkstra).
std::vector<std::size_t> chains_within(const LogChains& chains, const Meetings& meetings,
                                       const std::vector<std::vector<double>>& driven, double reach_m) {
  std::vector<std::vector<std::pair<double, std::int64_t>>> along(chains.chains.size());
  for (const auto& [id, places] : meetings)
    for (const Meeting& m : places) along[m.chain].push_back({m.along_m, id});
  std::map<std::int64_t, double> far;
  using Item = std::pair<double, std::int64_t>;
  std::priority_queue<Item, std::vector<Item>, std::greater<>> queue;
  const auto offer = [&](std::int64_t id, double distance_m) {
    const auto [at, fresh] = far.emplace(id, distance_m);
    if (!fresh && at->second <= distance_m) return;
    at->second = distance_m;
    if (distance_m < reach_m) queue.push({distance_m, id});
  };
  std::set<std::size_t> chosen;
  for (std::size_t c = 0; c < driven.size(); ++c) {
    std::sort(along[c].begin(), along[c].end());
    if (driven[c].empty()) continue;
    chosen.insert(c);
    for (const auto& [s, id] : along[c]) {
      const auto at = std::lower_bound(driven[c].begin(), driven[c].end(), s);
      double distance_m = HUGE_VAL;
      if (at != driven[c].end()) distance_m = *at - s;
      if (at != driven[c].begin()) distance_m = std::min(distance_m, s - *(at - 1));
      offer(id, distance_m);
    }
  }
  while (!queue.empty()) {
    const auto [distance_m, id] = queue.top();
    queue.pop();
    if (distance_m > far[id]) continue;
    for (const Meeting& m : meetings.at(id)) {
      chosen.insert(m.chain);
      const auto& stops = along[m.chain];
      const auto here = std::lower_bound(stops.begin(), stops.end(), std::pair(m.along_m, id));
      if (here != stops.begin()) offer((here - 1)->second, distance_m + m.along_m - (here - 1)->first);
      if (here + 1 != stops.end()) offer((here + 1)->second, distance_m + (here + 1)->first - m.along_m);
    }
  }
  return {chosen.begin(), chosen.end()};
}

// --- the least-squares problem

using Entries = std::vector<std::pair<int, double>>;

/// Rows of J and the right side, each already over its standard deviation.
struct Rows {
  SparseJacobian jacobian{.row_start = {0}};
  std::vector<double> right;

  void add(Entries entries, double value, double weight) {
    std::sort(entries.begin(), entries.end());
    for (std::size_t i = 0; i < entries.size(); ++i) {
      if (i > 0 && entries[i].first == entries[i - 1].first) {
        jacobian.value.back() += weight * entries[i].second;
        continue;
      }
      jacobian.column.push_back(entries[i].first);
      jacobian.value.push_back(weight * entries[i].second);
    }
    jacobian.row_start.push_back(static_cast<int>(jacobian.column.size()));
    right.push_back(weight * value);
  }
};

class ProfileProblem {
 public:
  ProfileProblem(const RoadNetwork& roads, const LogChains& chains, const DriveLog& log, const std::vector<Bin>& bins,
                 const FuseDriveLogsOptions& options)
      : roads_(roads),
        chains_(chains),
        log_(log),
        bins_(bins),
        options_(options),
        driven_(chains.chains.size()),
        slot_(chains.chains.size(), -1) {
    for (const Bin& bin : bins) driven_[bin.chain].push_back(bin.along_m);
    for (auto& list : driven_) std::sort(list.begin(), list.end());
    meetings_ = find_meetings(roads, chains);
    members_ = chains_within(chains, meetings_, driven_, 5.0 * options.terrain_error_length_m);
    for (const std::size_t c : members_) {
      slot_[c] = static_cast<int>(splines_.size());
      splines_.emplace_back(std::max(1.0, chains.chains[c].length_m), options.knot_spacing_m);
      first_column_.push_back(columns_);
      columns_ += 2 * splines_.back().coefficients();
    }
    source_column_ = columns_;
    columns_ += static_cast<int>(log.sources.size()) * source_parameters;
    for (const DriveRecording& recording : log.recordings) {
      recording_column_.push_back(columns_);
      columns_ += 1 + drift_knots(recording);
    }
    x_.assign(static_cast<std::size_t>(columns_), 0.0);
    fixed_.jacobian.columns = columns_;
    for (const std::size_t c : members_) add_prior(c);
    add_ties();
    add_sensor_priors();
  }

  /// Gauss-Newton with reweighting: only the arctangent of the gradient, the robust weights and the specific force
  /// where no sensor felt it are not linear.
  SolveSummary solve() {
    SolveSummary summary{.converged = false};
    for (int pass = 0; pass < most_passes && !summary.converged; ++pass) {
      const Rows rows = all_rows();
      const double cost = half_square(rows);
      if (pass == 0) summary.cost_before = cost;
      std::vector<double> x = solve_normal(rows.jacobian, rows.right);
      double change_m = 0.0;  // and rad: coefficients are heights and banking
      for (int i = 0; i < source_column_; ++i)
        change_m = std::max(change_m, std::abs(x[static_cast<std::size_t>(i)] - x_[static_cast<std::size_t>(i)]));
      x_ = std::move(x);
      summary.iterations = pass + 1, summary.cost_after = half_square(rows);
      summary.converged = change_m < settled_m;
    }
    return summary;
  }

  /// Corrections of the nodes of all member chains, their new standard deviations, and the calibration.
  void take(FuseDriveLogsResult& result) const {
    struct Where {
      std::size_t path, node;
      bool driven;
    };
    std::vector<Where> where;
    SparseJacobian functions{.columns = columns_, .row_start = {0}};
    const auto add_function = [&](int first, const std::array<double, 4>& factors) {
      for (int k = 0; k < 4; ++k)
        functions.column.push_back(first + k), functions.value.push_back(factors[static_cast<std::size_t>(k)]);
      functions.row_start.push_back(static_cast<int>(functions.column.size()));
    };
    for (std::size_t path = 0; path < roads_.paths.size(); ++path) {
      const std::size_t c = chains_.chain_of[path];
      if (slot_[c] < 0) continue;
      for (std::size_t n = 0; n < roads_.paths[path].nodes.size(); ++n) {
        const double s = chains_.along_m(path, roads_.paths[path].nodes[n].s_m);
        const auto basis = spline(c).at(s);
        where.push_back({path, n, is_driven(c, s)});
        add_function(z_column(c) + basis.first, basis.value);
        add_function(z_column(c) + basis.first, basis.slope);
        add_function(banking_column(c) + basis.first, basis.value);
      }
    }
    for (std::size_t k = 0; k < log_.sources.size(); ++k)
      for (const Parameter p : {mount_pitch, pitch_gain, mount_roll, roll_gain}) {
        functions.column.push_back(source(k, p)), functions.value.push_back(1.0);
        functions.row_start.push_back(static_cast<int>(functions.column.size()));
      }
    const std::vector<double> variance = normal_variances(all_rows().jacobian, functions);
    const auto sigma = [&](std::size_t f) { return std::sqrt(std::max(0.0, variance[f])); };
    for (std::size_t i = 0; i < where.size(); ++i) {
      const auto [path, n, driven] = where[i];
      RoadNode& node = result.roads.paths[path].nodes[n];
      const std::size_t c = chains_.chain_of[path];
      const double s = chains_.along_m(path, node.s_m), sign = chains_.sign(path);
      const auto basis = spline(c).at(s);
      node.z_m += combine(z_column(c) + basis.first, basis.value);
      node.gradient += sign * combine(z_column(c) + basis.first, basis.slope);
      node.banking += sign * combine(banking_column(c) + basis.first, basis.value);
      const auto improve = [](double& given, double now) { given = given > 0.0 ? std::min(given, now) : now; };
      improve(node.sigma_z_m, sigma(3 * i));
      improve(node.sigma_banking, sigma(3 * i + 2));
      if (!driven) continue;
      node.banking_source = "log";
      result.driven.push_back({path, n, sigma(3 * i + 1)});
    }
    for (std::size_t k = 0; k < log_.sources.size(); ++k) {
      const std::size_t f = 3 * where.size() + 4 * k;
      const auto value = [&](Parameter p) { return x_[static_cast<std::size_t>(source(k, p))]; };
      result.calibration.push_back({log_.sources[k], value(mount_pitch), sigma(f), value(mount_roll), sigma(f + 2),
                                    value(pitch_gain), sigma(f + 1), value(roll_gain), sigma(f + 3)});
    }
    result.residuals = residuals();
  }

 private:
  enum Parameter {
    mount_pitch,
    pitch_gain,
    mount_roll,
    roll_gain,
    lateral_offset,
    gyro_bias,
    mount_yaw,
    source_parameters
  };

  static int drift_knots(const DriveRecording& recording) {
    return static_cast<int>(
               std::ceil((recording.poses.back().time_s - recording.poses.front().time_s) / drift_step_s)) +
           1;
  }
  [[nodiscard]] const UniformSpline& spline(std::size_t chain) const {
    return splines_[static_cast<std::size_t>(slot_[chain])];
  }
  [[nodiscard]] int z_column(std::size_t chain) const { return first_column_[static_cast<std::size_t>(slot_[chain])]; }
  [[nodiscard]] int banking_column(std::size_t chain) const { return z_column(chain) + spline(chain).coefficients(); }
  [[nodiscard]] int source(std::size_t k, Parameter p) const {
    return source_column_ + static_cast<int>(k) * source_parameters + p;
  }
  [[nodiscard]] bool is_driven(std::size_t chain, double along_m) const {
    const auto& list = driven_[chain];
    const auto at = std::lower_bound(list.begin(), list.end(), along_m);
    return (at != list.end() && *at - along_m <= driven_reach_m) ||
           (at != list.begin() && along_m - *(at - 1) <= driven_reach_m);
  }
  [[nodiscard]] double combine(int first, const std::array<double, 4>& factors) const {
    double sum = 0.0;
    for (int k = 0; k < 4; ++k) sum += factors[static_cast<std::size_t>(k)] * x_[static_cast<std::size_t>(first + k)];
    return sum;
  }
  static void append(Entries& entries, int first, const std::array<double, 4>& factors, double scale = 1.0) {
    for (int k = 0; k < 4; ++k) entries.push_back({first + k, scale * factors[static_cast<std::size_t>(k)]});
  }
  [[nodiscard]] double half_square(const Rows& rows) const {
    double sum = 0.0;
    for (std::size_t r = 0; r < rows.right.size(); ++r) {
      double residual = -rows.right[r];
      for (int i = rows.jacobian.row_start[r]; i < rows.jacobian.row_start[r + 1]; ++i)
        residual += rows.jacobian.value[static_cast<std::size_t>(i)] *
                    x_[static_cast<std::size_t>(rows.jacobian.column[static_cast<std::size_t>(i)])];
      sum += 0.5 * residual * residual;
    }
    return sum;
  }

  /// The correction is a Gaussian process of Matern 5/2 covariance with the standard deviation of the profile: exactly
  /// that of (d/ds + k)^3 u = white noise of power 16/3 k^5 (Hartikainen and Sarkka, Kalman filtering and smoothing
  /// solutions to temporal Gaussian process regression models, 2010), started in its steady state. Its curvature has a
  /// standard deviation of k^2 sigma: a correction is no rougher than a road.
  void add_prior(std::size_t chain) {
    const UniformSpline& s = spline(chain);
    const struct {
      int column;
      double length_m;
      double Baseline::*sigma;
    } fields[] = {{z_column(chain), options_.terrain_error_length_m, &Baseline::sigma_z_m},
                  {banking_column(chain), options_.banking_length_m, &Baseline::sigma_banking_rad}};
    for (const auto& field : fields) {
      const double k = std::sqrt(5.0) / field.length_m, k2 = k * k;
      const double weight = std::sqrt(0.5 * s.step_m() / (16.0 / 3.0 * k2 * k2 * k));
      const auto sigma = [&](double x) { return baseline_at(roads_, chains_, chain, x, options_).*field.sigma; };
      const auto first = s.at(0.0);
      Entries value, slope, bend;  // in the steady state u' is independent, u'' has the mean -k^2 u / 3 given u
      append(value, field.column + first.first, first.value), append(slope, field.column + first.first, first.slope);
      append(bend, field.column + first.first, first.bend),
          append(bend, field.column + first.first, first.value, k2 / 3.0);
      fixed_.add(value, 0.0, 1.0 / sigma(0.0));
      fixed_.add(slope, 0.0, std::sqrt(3.0) / (k * sigma(0.0)));
      fixed_.add(bend, 0.0, 3.0 / (std::sqrt(8.0) * k2 * sigma(0.0)));
      for (int i = 0; i < s.intervals; ++i)
        for (const double u : {0.5 - 0.5 / std::sqrt(3.0), 0.5 + 0.5 / std::sqrt(3.0)}) {  // two Gauss points
          const double x = (i + u) * s.step_m();
          const auto basis = s.at(x);
          std::array<double, 4> factors;
          for (std::size_t j = 0; j < 4; ++j)
            factors[j] = basis.jerk[j] + 3.0 * k * basis.bend[j] + 3.0 * k2 * basis.slope[j] + k2 * k * basis.value[j];
          Entries entries;
          append(entries, field.column + basis.first, factors);
          fixed_.add(entries, 0.0, weight / sigma(x));
        }
    }
  }

  void add_ties() {
    for (const auto& [id, places] : meetings_) {
      std::vector<Meeting> here;
      for (const Meeting& m : places)
        if (slot_[m.chain] >= 0) here.push_back(m);
      if (here.size() < 2) continue;
      // The road that goes on here and was driven on has the say.
      const auto rank = [&](const Meeting& m) {
        const bool inside = m.along_m > 1.0 && m.along_m < chains_.chains[m.chain].length_m - 1.0;
        return std::pair(inside, is_driven(m.chain, m.along_m));
      };
      std::stable_sort(here.begin(), here.end(), [&](const Meeting& a, const Meeting& b) { return rank(a) > rank(b); });
      for (std::size_t i = 1; i < here.size(); ++i) tie(here.front(), here[i]);
    }
    for (const std::size_t c : members_) {
      if (!chains_.chains[c].closed) continue;
      const auto a = spline(c).at(0.0), b = spline(c).at(spline(c).length_m);
      for (const int column : {z_column(c), banking_column(c)}) {
        const struct {
          std::array<double, 4> UniformSpline::Basis::*of;
          double sigma;
        } orders[] = {{&UniformSpline::Basis::value, tie_height_m},
                      {&UniformSpline::Basis::slope, 1e-5},
                      {&UniformSpline::Basis::bend, 1e-6}};
        for (const auto& order : orders) {
          Entries entries;
          append(entries, column + a.first, a.*order.of), append(entries, column + b.first, b.*order.of, -1.0);
          fixed_.add(entries, 0.0, 1.0 / order.sigma);
        }
      }
    }
  }

  /// Equal heights; and a road without measurements follows the plane of the other, so that their angle stays.
  void tie(const Meeting& main, const Meeting& other) {
    const auto a = spline(main.chain).at(main.along_m), b = spline(other.chain).at(other.along_m);
    if (main.chain == other.chain && std::abs(main.along_m - other.along_m) < 1e-6) return;
    Entries height;
    append(height, z_column(main.chain) + a.first, a.value);
    append(height, z_column(other.chain) + b.first, b.value, -1.0);
    fixed_.add(height, 0.0, 1.0 / tie_height_m);
    if (is_driven(other.chain, other.along_m) || main.chain == other.chain) return;
    const Vec2 d_main = direction(main), d_other = direction(other);
    Entries slope;
    append(slope, z_column(other.chain) + b.first, b.slope);
    append(slope, z_column(main.chain) + a.first, a.slope, -dot(d_main, d_other));
    append(slope, banking_column(main.chain) + a.first, a.value, -cross(d_main, d_other));
    fixed_.add(slope, 0.0, 1.0 / tie_slope);
    Entries across;
    append(across, banking_column(other.chain) + b.first, b.value);
    append(across, z_column(main.chain) + a.first, a.slope, cross(d_main, d_other));
    append(across, banking_column(main.chain) + a.first, a.value, -dot(d_main, d_other));
    fixed_.add(across, 0.0, 1.0 / tie_slope);
  }
  [[nodiscard]] Vec2 direction(const Meeting& m) const {
    const auto& nodes = roads_.paths[m.path].nodes;
    const std::size_t a = m.node > 0 ? m.node - 1 : 0, b = std::min(m.node + 1, nodes.size() - 1);
    return normalized(nodes[b].p - nodes[a].p) * chains_.sign(m.path);
  }

  void add_sensor_priors() {
    const DriveLogAccuracy& a = options_.accuracy;
    const SuspensionPrior& s = options_.suspension;
    for (std::size_t k = 0; k < log_.sources.size(); ++k) {
      const auto add = [&](Parameter p, double mean, double sigma) {
        fixed_.add({{source(k, p), 1.0}}, mean, 1.0 / sigma);
      };
      add(mount_pitch, 0.0, a.mounting_rad), add(mount_roll, 0.0, a.mounting_rad),
          add(lateral_offset, 0.0, a.mounting_rad);
      add(pitch_gain, s.pitch_rad_per_mps2, s.pitch_sigma), add(roll_gain, s.roll_rad_per_mps2, s.roll_sigma);
      add(gyro_bias, 0.0, gyro_bias_sigma_radps), add(mount_yaw, 0.0, yaw_mounting_sigma_rad);
    }
    // d(t + dt) = f d(t) + N(0, sigma^2 (1 - f^2)), f = exp(-dt / tau)
    const double f = std::exp(-drift_step_s / a.height_drift_s), step_sigma = a.height_drift_m * std::sqrt(1.0 - f * f);
    for (std::size_t r = 0; r < log_.recordings.size(); ++r) {
      const int offset = recording_column_[r], knots = drift_knots(log_.recordings[r]);
      fixed_.add({{offset, 1.0}}, 0.0, 1.0 / height_offset_sigma_m);
      fixed_.add({{offset + 1, 1.0}}, 0.0, 1.0 / a.height_drift_m);
      for (int i = 1; i < knots; ++i) fixed_.add({{offset + i, -f}, {offset + i + 1, 1.0}}, 0.0, 1.0 / step_sigma);
    }
  }

  /// A measurement, linear around the present solution: sum of entries * x = value.
  struct Measurement {
    Entries entries;
    double value = 0.0, sigma = 1.0, bin_sigma = 1.0;
    double DriveResiduals::*kind = nullptr;
  };

  /// Gradient and banking in the direction of travel, at the lane that was driven on.
  void measurements_of(const Bin& bin, std::vector<Measurement>& list) const {
    const DriveLogAccuracy& a = options_.accuracy;
    const Baseline base = baseline_at(roads_, chains_, bin.chain, bin.along_m, options_);
    const auto basis = spline(bin.chain).at(bin.along_m);
    const int z = z_column(bin.chain) + basis.first, b = banking_column(bin.chain) + basis.first;
    const double d = bin.direction, t = bin.beside_m;
    // What a car leans by the crown: nothing astride of the ridge.
    const double leans = std::clamp(t / half_track_m, -1.0, 1.0) * base.crown_rad;
    const double gradient_0 = d * (base.gradient + t * base.banking_change), banking_0 = d * (base.banking_rad - leans);
    const double gradient = gradient_0 + d * (combine(z, basis.slope) + t * combine(b, basis.slope));
    const double banking = banking_0 + d * combine(b, basis.value);
    const auto add_gradient = [&](Entries& entries, double scale) {
      append(entries, z, basis.slope, d * scale), append(entries, b, basis.slope, d * t * scale);
    };
    const double turn_mps2 = bin.speed_mps * bin.yaw_rate_radps;
    double forward = bin.forward_mps2, left = bin.left_mps2;
    if (std::isnan(forward))
      forward = (std::isnan(bin.acceleration_mps2) ? 0.0 : bin.acceleration_mps2) + gravity_mps2 * gradient;
    if (std::isnan(left)) left = (std::isnan(turn_mps2) ? 0.0 : turn_mps2) + gravity_mps2 * banking;

    if (!std::isnan(bin.nose_up_rad)) {  // atan(gradient) + mounting + squat
      const double slope = 1.0 / (1.0 + gradient * gradient);
      Measurement m{.value = bin.nose_up_rad - std::atan(gradient) + slope * (gradient - gradient_0),
                    .sigma = a.pitch_rad,
                    .bin_sigma = bin_sigma(a.pitch_rad, a.pitch_correlation_s, bin),
                    .kind = &DriveResiduals::pitch_rad};
      add_gradient(m.entries, slope);
      m.entries.push_back({source(bin.source, mount_pitch), 1.0});
      m.entries.push_back({source(bin.source, pitch_gain), forward});
      list.push_back(std::move(m));
    }
    if (!std::isnan(bin.climb_mps) && bin.speed_mps > slowest_climb_mps) {
      Measurement m{.value = bin.climb_mps / bin.speed_mps - gradient_0,
                    .sigma = a.climb_mps / bin.speed_mps,
                    .bin_sigma = bin_sigma(a.climb_mps, a.climb_correlation_s, bin) / bin.speed_mps,
                    .kind = &DriveResiduals::climb_gradient};
      add_gradient(m.entries, 1.0);
      list.push_back(std::move(m));
    }
    if (!std::isnan(bin.z_m)) {  // height of the road below the car + offset + drift
      Measurement m{
          .value = bin.z_m - base.z_m - t * base.banking_rad + std::max(half_track_m, std::abs(t)) * base.crown_rad,
          .sigma = a.height_m,
          .bin_sigma = bin_sigma(a.height_m, a.height_correlation_s, bin),
          .kind = &DriveResiduals::height_m};
      append(m.entries, z, basis.value), append(m.entries, b, basis.value, t);
      const DriveRecording& recording = log_.recordings[bin.recording];
      const int offset = recording_column_[bin.recording], last = drift_knots(recording) - 2;
      const double x = (bin.time_s - recording.poses.front().time_s) / drift_step_s;
      const int knot = std::clamp(static_cast<int>(x), 0, std::max(0, last));
      m.entries.push_back({offset, 1.0});
      m.entries.push_back({offset + 1 + knot, 1.0 - (x - knot)});
      if (last >= 0) m.entries.push_back({offset + 2 + knot, x - knot});
      list.push_back(std::move(m));
    }
    // Roll of the attitude, and the same angle from g sin(roll) = specific force - speed * yaw rate. A filter has made
    // the one from the other's sensors: where there are both, each counts half.
    const bool both = !std::isnan(bin.roll_rad) && !std::isnan(turn_mps2) && !std::isnan(bin.left_mps2);
    const double half = both ? std::sqrt(2.0) : 1.0;
    if (!std::isnan(bin.roll_rad)) {
      Measurement m{.value = bin.roll_rad - banking_0,
                    .sigma = a.roll_rad,
                    .bin_sigma = half * bin_sigma(a.roll_rad, a.roll_correlation_s, bin),
                    .kind = &DriveResiduals::roll_rad};
      append(m.entries, b, basis.value, d);
      m.entries.push_back({source(bin.source, mount_roll), 1.0});
      m.entries.push_back({source(bin.source, roll_gain), left});
      list.push_back(std::move(m));
    }
    if (!std::isnan(turn_mps2) && !std::isnan(bin.left_mps2)) {
      const double sine = std::clamp((bin.left_mps2 - turn_mps2) / gravity_mps2, -0.5, 0.5);
      Measurement m{.value = std::asin(sine) - banking_0,
                    .sigma = a.lateral_mps2 / gravity_mps2,
                    .bin_sigma = half * bin_sigma(a.lateral_mps2, a.lateral_correlation_s, bin) / gravity_mps2,
                    .kind = &DriveResiduals::lateral_rad};
      append(m.entries, b, basis.value, d);
      m.entries.push_back({source(bin.source, lateral_offset), 1.0});
      m.entries.push_back({source(bin.source, roll_gain), left});
      m.entries.push_back({source(bin.source, gyro_bias), bin.speed_mps / gravity_mps2});
      m.entries.push_back({source(bin.source, mount_yaw), forward / gravity_mps2});
      list.push_back(std::move(m));
    }
  }
  [[nodiscard]] double residual_of(const Measurement& m) const {
    double sum = -m.value;
    for (const auto& [column, factor] : m.entries) sum += factor * x_[static_cast<std::size_t>(column)];
    return sum;
  }

  [[nodiscard]] Rows all_rows() const {
    Rows rows = fixed_;
    std::vector<Measurement> list;
    const bool robust = std::any_of(x_.begin(), x_.end(), [](double v) { return v != 0.0; });  // not the first time
    for (const Bin& bin : bins_) {
      list.clear();
      measurements_of(bin, list);
      for (Measurement& m : list) {
        const double r = residual_of(m) / (robust_scale * m.sigma);
        const double weight = robust ? 1.0 / std::sqrt(1.0 + r * r) : 1.0;
        rows.add(std::move(m.entries), m.value, weight / m.bin_sigma);
      }
    }
    return rows;
  }

  [[nodiscard]] DriveResiduals residuals() const {
    DriveResiduals sums;
    std::map<double*, double> counts;
    std::vector<Measurement> list;
    for (const Bin& bin : bins_) {
      list.clear();
      measurements_of(bin, list);
      for (const Measurement& m : list) sums.*m.kind += std::pow(residual_of(m), 2), counts[&(sums.*m.kind)] += 1.0;
    }
    for (const auto& [sum, count] : counts) *sum = std::sqrt(*sum / count);
    sums.places = bins_.size();
    return sums;
  }

  const RoadNetwork& roads_;
  const LogChains& chains_;
  const DriveLog& log_;
  const std::vector<Bin>& bins_;
  const FuseDriveLogsOptions& options_;
  std::vector<std::vector<double>> driven_;  ///< [chain] places of the bins, ascending
  Meetings meetings_;
  std::vector<std::size_t> members_;
  std::vector<int> slot_;  ///< [chain] index of its spline; -1: no member
  std::vector<UniformSpline> splines_;
  std::vector<int> first_column_, recording_column_;
  int source_column_ = 0, columns_ = 0;
  Rows fixed_;
  std::vector<double> x_;
};

// --- findings

void report_disagreement(const RoadNetwork& before, FuseDriveLogsResult& result) {
  struct Worst {
    double sigmas = 0.0, change_m = 0.0, count = 0.0;
    Vec2 p;
  };
  std::map<std::size_t, Worst> worst;
  for (const DrivenNode& driven : result.driven) {
    const RoadNode &old = before.paths[driven.path].nodes[driven.node],
                   &now = result.roads.paths[driven.path].nodes[driven.node];
    const double change_m = now.z_m - old.z_m, sigmas = old.sigma_z_m > 0.0 ? std::abs(change_m) / old.sigma_z_m : 0.0;
    if (sigmas <= 3.0) continue;
    Worst& w = worst[driven.path];
    w.count += 1.0;
    if (sigmas > w.sigmas) w.sigmas = sigmas, w.change_m = change_m, w.p = now.p;
  }
  for (const auto& [path, w] : worst)
    result.findings.push_back({Severity::warning, "elevate.log_disagrees",
                               fmt::format("way {}: drive logs move the profile by {:.2f} m, {:.1f} standard "
                                           "deviations of the terrain's, and by more "
                                           "than three at {:.0f} nodes",
                                           before.paths[path].osm_id, w.change_m, w.sigmas, w.count),
                               w.p.x, w.p.y});
}

/// Crossings of two levels that were high enough before.
void report_clearance(const RoadNetwork& before, double clearance_m, FuseDriveLogsResult& result) {
  constexpr double tolerance_m = 0.1;
  for (const PathCrossing& crossing : find_crossings(result.roads)) {
    const auto room = [&](const RoadNetwork& roads) {
      const auto z = [](const RoadPath& path, std::size_t i, double f) {
        return path.nodes[i].z_m * (1.0 - f) + path.nodes[i + 1].z_m * f;
      };
      const RoadPath &a = roads.paths[crossing.path_a], &b = roads.paths[crossing.path_b];
      const double difference =
          z(a, crossing.segment_a, crossing.fraction_a) - z(b, crossing.segment_b, crossing.fraction_b);
      return a.layer > b.layer ? difference : -difference;
    };
    const RoadPath &a = result.roads.paths[crossing.path_a], &b = result.roads.paths[crossing.path_b];
    if (a.layer == b.layer || room(result.roads) >= clearance_m - tolerance_m ||
        room(before) < clearance_m - tolerance_m)
      continue;
    result.findings.push_back(
        {Severity::warning, "elevate.log_clearance",
         fmt::format("ways {} and {} are {:.1f} m apart in height since the drive logs count, {:.1f} m are wanted",
                     a.osm_id, b.osm_id, room(result.roads), clearance_m),
         crossing.p.x, crossing.p.y});
  }
}

void check(const RoadNetwork& roads, const DriveLog& log, const FuseDriveLogsOptions& options) {
  if (!(log.crs == roads.crs))
    throw OptionError(fmt::format("drive logs: roads are in {} but the log in {}, need one CRS", roads.crs.definition,
                                  log.crs.definition));
  const DriveLogAccuracy& a = options.accuracy;
  for (const double value : {a.pitch_rad, a.roll_rad, a.climb_mps, a.lateral_mps2, a.height_m, a.height_drift_m,
                             a.height_drift_s, a.mounting_rad, options.terrain_error_length_m, options.banking_length_m,
                             options.unknown_sigma_banking_rad, options.unknown_sigma_z_m, options.knot_spacing_m,
                             options.suspension.pitch_sigma, options.suspension.roll_sigma})
    if (!(value > 0.0)) throw OptionError("drive logs: standard deviations, lengths and times must be positive");
  for (const RoadPath& path : roads.paths) {
    if (path.nodes.size() < 2)
      throw OptionError(fmt::format("drive logs: way {} has fewer than two nodes", path.osm_id));
    for (const RoadNode& node : path.nodes)
      if (std::isnan(node.z_m))
        throw OptionError(
            fmt::format("drive logs: way {} has no heights; run `orthodrive elevate` first", path.osm_id));
  }
}

}  // namespace

FuseDriveLogsResult fuse_drive_logs(const RoadNetwork& roads, const DriveLog& log, const FuseDriveLogsOptions& options,
                                    Monitor* monitor) {
  check(roads, log, options);
  FuseDriveLogsResult result{.roads = roads};
  const LogMatcher matcher(roads, options.match);
  const LogChains chains = make_log_chains(roads);
  std::vector<MatchLogResult> matches;
  std::vector<Bin> bins;
  for (std::size_t r = 0; r < log.recordings.size(); ++r) {
    const DriveRecording& recording = log.recordings[r];
    matches.push_back(matcher.match(recording, log.sources.at(recording.source)));
    MatchLogResult& match = matches.back();
    result.length_m += match.length_m, result.matched_m += match.matched_m;
    result.findings.insert(result.findings.end(), match.findings.begin(), match.findings.end());
    BinMaker(chains, recording, r, bins).make(match.places);
    if (monitor)
      monitor->progress(0.5 * static_cast<double>(r + 1) / static_cast<double>(log.recordings.size()), "drive logs");
  }
  if (bins.empty()) return result;
  std::vector<MatchedRecording> matched;
  for (std::size_t r = 0; r < matches.size(); ++r) matched.push_back({&log.recordings[r], &matches[r].places});
  result.roughness = measure_roughness(roads, matched, options.roughness);

  ProfileProblem problem(roads, chains, log, bins, options);
  result.solve = problem.solve();
  problem.take(result);
  if (!result.solve.converged)
    result.findings.push_back(
        {Severity::warning, "elevate.log_not_converged",
         fmt::format("the profile of the drive logs still moved after {} passes", result.solve.iterations),
         log.recordings.front().poses.front().p.x, log.recordings.front().poses.front().p.y});
  report_disagreement(roads, result);
  report_clearance(roads, options.clearance_m, result);
  if (monitor) monitor->progress(1.0, "drive logs");
  return result;
}

}  // namespace orthodrive
