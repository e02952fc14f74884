// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/elevate/logs/fusion_problem.hpp"

#include <algorithm>
#include <cmath>

namespace orthodrive::elevate {

void append(Entries& entries, int first, const std::array<double, 4>& factors, double scale) {
  for (int k = 0; k < 4; ++k) entries.push_back({first + k, scale * factors[static_cast<std::size_t>(k)]});
}

void WeightedRows::add(Entries entries, double value, double weight) {
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

double WeightedRows::half_square_sum(const std::vector<double>& x) const {
  double sum = 0.0;
  for (std::size_t r = 0; r < right.size(); ++r) {
    double residual = -right[r];
    for (int i = jacobian.row_start[r]; i < jacobian.row_start[r + 1]; ++i)
      residual += jacobian.value[static_cast<std::size_t>(i)] *
                  x[static_cast<std::size_t>(jacobian.column[static_cast<std::size_t>(i)])];
    sum += 0.5 * residual * residual;
  }
  return sum;
}

int drift_knots(const DriveRecording& recording) {
  return static_cast<int>(std::ceil((recording.poses.back().time_s - recording.poses.front().time_s) / drift_step_s)) +
         1;
}

FusionColumns::FusionColumns(const LogChains& chains, const std::vector<std::size_t>& members, const DriveLog& log,
                             double knot_spacing_m)
    : slot_(chains.chains.size(), -1) {
  for (const std::size_t c : members) {
    slot_[c] = static_cast<int>(splines_.size());
    splines_.emplace_back(std::max(1.0, chains.chains[c].length_m), knot_spacing_m);
    first_.push_back(count_);
    count_ += 2 * splines_.back().coefficients();
  }
  first_source_ = count_;
  count_ += static_cast<int>(log.sources.size()) * source_parameters;
  for (const DriveRecording& recording : log.recordings) {
    height_offset_.push_back(count_);
    count_ += 1 + drift_knots(recording);
  }
}

FusionProblem make_fusion_problem(const RoadNetwork& roads, const LogChains& chains, const DriveLog& log,
                                  const std::vector<DrivenSample>& samples, const FuseDriveLogsOptions& options) {
  constexpr double reach_lengths = 5.0;  // beyond, the correction has died out (exp(-5 sqrt(5)) < 2e-5)
  DrivenPlaces driven(chains.chains.size(), samples);
  Meetings meetings = find_meetings(roads, chains);
  std::vector<std::size_t> members =
      chains_within(chains, meetings, driven, reach_lengths * options.terrain_error_length_m);
  FusionColumns columns(chains, members, log, options.knot_spacing_m);
  return {roads,
          chains,
          log,
          samples,
          options,
          std::move(driven),
          std::move(meetings),
          std::move(members),
          std::move(columns)};
}

double combine(const std::vector<double>& x, int first, const std::array<double, 4>& factors) {
  double sum = 0.0;
  for (int k = 0; k < 4; ++k) sum += factors[static_cast<std::size_t>(k)] * x[static_cast<std::size_t>(first + k)];
  return sum;
}

}  // namespace orthodrive::elevate
