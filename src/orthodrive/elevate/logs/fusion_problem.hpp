// SPDX-License-Identifier: Apache-2.0
#pragma once
// Step 4 of fuse_drive_logs: the unknowns of the least-squares problem, and its rows.
//
// Unknowns: per chain a spline of the correction of the height and one of the banking; per sensor how it sits in its
// car and how the body moves; per recording an offset of the heights and its drift.

#include <array>
#include <cstddef>
#include <utility>
#include <vector>

#include "orthodrive/elevate/logs/driven_samples.hpp"
#include "orthodrive/elevate/logs/fuse_drive_logs.hpp"
#include "orthodrive/elevate/logs/road_meetings.hpp"
#include "orthodrive/math/normal_matrix.hpp"
#include "orthodrive/math/uniform_spline.hpp"
#include "orthodrive/roads/log_chains.hpp"

namespace orthodrive::elevate {

/// Column and factor of the unknowns in one row.
using Entries = std::vector<std::pair<int, double>>;

/// Four neighbouring coefficients of a spline, as its basis functions weigh them.
void append(Entries& entries, int first, const std::array<double, 4>& factors, double scale = 1.0);

/// Rows of J and the right side, each already over its standard deviation.
struct WeightedRows {
  SparseJacobian jacobian{.row_start = {0}};
  std::vector<double> right;

  /// sum of entries * x = value; an unknown may come twice.
  void add(Entries entries, double value, double weight);
  [[nodiscard]] double half_square_sum(const std::vector<double>& x) const;
};

/// Which column each unknown has.
class FusionColumns {
 public:
  /// Of one sensor in its car.
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

  FusionColumns(const LogChains& chains, const std::vector<std::size_t>& members, const DriveLog& log,
                double knot_spacing_m);

  [[nodiscard]] bool is_member(std::size_t chain) const { return slot_[chain] >= 0; }
  [[nodiscard]] const UniformSpline& spline(std::size_t chain) const {
    return splines_[static_cast<std::size_t>(slot_[chain])];
  }
  [[nodiscard]] int z(std::size_t chain) const { return first_[static_cast<std::size_t>(slot_[chain])]; }
  [[nodiscard]] int banking(std::size_t chain) const { return z(chain) + spline(chain).coefficients(); }
  [[nodiscard]] int source(std::size_t k, Parameter p) const {
    return first_source_ + static_cast<int>(k) * source_parameters + p;
  }
  /// The constant offset of a recording's heights; the knots of its drift follow.
  [[nodiscard]] int height_offset(std::size_t recording) const { return height_offset_[recording]; }
  /// Columns before this one are spline coefficients.
  [[nodiscard]] int first_source() const { return first_source_; }
  [[nodiscard]] int count() const { return count_; }

 private:
  std::vector<int> slot_;  // [chain] index of its spline; -1: no member
  std::vector<UniformSpline> splines_;
  std::vector<int> first_, height_offset_;
  int first_source_ = 0, count_ = 0;
};

inline constexpr double drift_step_s = 2.0;  ///< between the knots of the drift of heights
[[nodiscard]] int drift_knots(const DriveRecording& recording);

/// What the rows are made from.
struct FusionProblem {
  const RoadNetwork& roads;
  const LogChains& chains;
  const DriveLog& log;
  const std::vector<DrivenSample>& samples;
  const FuseDriveLogsOptions& options;
  DrivenPlaces driven;
  Meetings meetings;
  std::vector<std::size_t> members;  ///< chains that are corrected
  FusionColumns columns;
};
[[nodiscard]] FusionProblem make_fusion_problem(const RoadNetwork& roads, const LogChains& chains, const DriveLog& log,
                                                const std::vector<DrivenSample>& samples,
                                                const FuseDriveLogsOptions& options);

/// Value of a correction (or a derivative of it) from four of its coefficients.
[[nodiscard]] double combine(const std::vector<double>& x, int first, const std::array<double, 4>& factors);

}  // namespace orthodrive::elevate
