// SPDX-License-Identifier: Apache-2.0
#pragma once
// Superelevation and widths along a road: few cubics that join with equal value and slope (C1). Heights:
// fit_spline.hpp.

#include <span>
#include <vector>

#include "roadquery/map/road_map.hpp"

namespace orthodrive::network {

struct ProfileSample {
  double s = 0.0, value = 0.0;
};

struct FitProfileOptions {
  double tolerance = 0.02;  ///< largest error at a sample, in the unit of the values
  bool closed = false;      ///< the last sample repeats the first one's value and the profile goes on there
  bool level_ends = false;  ///< slopes of 0 there, so that what is fitted by itself on either side joins C1
};

struct ProfileFit {
  std::vector<roadquery::Cubic> cubics;  ///< the first starts at the first sample's s
  double max_error = 0.0;
};

/// Cubic Hermite pieces over as many samples as stay within the tolerance. s must not decrease; samples closer than
/// 1 cm to the one before are left out. At least one sample.
[[nodiscard]] ProfileFit fit_profile(std::span<const ProfileSample> samples, const FitProfileOptions& options = {});

/// Samples at least 1 cm apart; the last one stays.
[[nodiscard]] std::vector<ProfileSample> without_repeats(std::span<const ProfileSample> samples);
[[nodiscard]] double value_at(const roadquery::Cubic& cubic, double s);
[[nodiscard]] double slope_at(const roadquery::Cubic& cubic, double s);
/// Of a whole profile; 0 of none.
[[nodiscard]] double value_at(std::span<const roadquery::Cubic> cubics, double s);
[[nodiscard]] double slope_at(std::span<const roadquery::Cubic> cubics, double s);
/// The cubic with these values and slopes at both ends.
[[nodiscard]] roadquery::Cubic hermite(double s0, double s1, double v0, double v1, double slope0, double slope1);
/// Adds `more` from its own s to `end`, where the profile gets joints unless it has one there. A profile of no pieces
/// is 0 everywhere.
void add_cubic(std::vector<roadquery::Cubic>& cubics, const roadquery::Cubic& more, double end);
/// The part from s0 to s1 with s from 0.
[[nodiscard]] std::vector<roadquery::Cubic> slice_profile(std::span<const roadquery::Cubic> cubics, double s0,
                                                          double s1);
/// The same profile of `length` without the joints that move it by less than `tolerance`: C1 if it was.
[[nodiscard]] std::vector<roadquery::Cubic> simplify_profile(std::span<const roadquery::Cubic> cubics, double length,
                                                             double tolerance);
/// The same profile of `length` seen from its other end; `sign` -1 for what changes sign then (superelevation).
[[nodiscard]] std::vector<roadquery::Cubic> reverse_profile(std::span<const roadquery::Cubic> cubics, double length,
                                                            double sign = 1.0);

}  // namespace orthodrive::network
