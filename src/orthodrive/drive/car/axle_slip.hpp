// SPDX-License-Identifier: Apache-2.0
#pragma once
// How far the tyres of an axle have to be turned out of their way for a side force.

#include <array>
#include <cstddef>

#include "vehicle/car_parameters.hpp"

namespace orthodrive {

/// Slip angle of an axle's tyres for a side force, both as shares: force over load and friction. From the Magic Formula
/// at the static load.
class AxleSlip {
 public:
  AxleSlip(const vehicle::CarParameters& car, bool front);
  [[nodiscard]] double angle_rad(double force_share) const;  ///< both with the same sign; beyond the peak: its angle
  [[nodiscard]] double peak_rad() const { return peak_rad_; }

 private:
  static constexpr std::size_t entries = 65;
  std::array<double, entries> angle_rad_{};  ///< at even shares from 0 to the peak
  double peak_share_ = 1.0, peak_rad_ = 0.0;
};

}  // namespace orthodrive
