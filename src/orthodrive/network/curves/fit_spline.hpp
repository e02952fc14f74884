// SPDX-License-Identifier: Apache-2.0
#pragma once
// Elevations along a road: a cubic spline, C2, through as few of the samples as keep all others within the tolerance.

#include "orthodrive/network/curves/fit_profile.hpp"

namespace orthodrive::network {

/// A cubic spline (math/cubic_spline.hpp) with its knots at samples;
/// ends have the slope of the parabola through the samples there, closed profiles go on in themselves. Intervals are
/// halved until their samples fit. The samples nearest to `exact_s` (ascending) are knots from the start, so that what
/// meets there meets exactly. s must not decrease; samples closer than 1 cm to the one before are left out. At least
/// one sample.
[[nodiscard]] ProfileFit fit_spline(std::span<const ProfileSample> samples, const FitProfileOptions& options = {},
                                    std::span<const double> exact_s = {});

}  // namespace orthodrive::network
