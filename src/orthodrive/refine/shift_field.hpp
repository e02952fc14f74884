// SPDX-License-Identifier: Apache-2.0
#pragma once
// How far the map around a place lies off the photo. OSM is traced from photos that are themselves metres off, so all
// ways of a neighbourhood are shifted alike: what is seen of some of them tells where the hidden ones are.

#include <vector>

#include "orthodrive/roads/road_chains.hpp"

namespace orthodrive::refine {

/// An offset that was measured: the map has to move by offset_m along `normal` at p.
struct ShiftSample {
  Vec2 p, normal;
  double offset_m = 0.0;
  double weight = 0.0;
};

/// A shift and its covariance matrix.
struct Shift {
  Vec2 shift_m;
  double xx_m2 = 0.0, xy_m2 = 0.0, yy_m2 = 0.0;
};

inline constexpr double sample_sigma_m = 1.5;  ///< of a sample of weight 1: samples along a road err together

struct ShiftFieldOptions {
  double reach_m = 100.0;  ///< standard deviation of the Gaussian that weighs samples by their distance
  double prior_m = 4.0;    ///< standard deviation of a shift that nothing is known about
  double outlier_m = 1.0;  ///< Cauchy scale of an offset around the shift: single ways err on their own
};

/// The shift at each of `places`: a robust local fit of a vector to the offsets around (iteratively reweighted least
/// squares). Where there is no sample the shift is 0, with the variance of the prior. Linear in the number of samples
/// and places.
[[nodiscard]] std::vector<Shift> shift_at(const std::vector<Vec2>& places, const std::vector<ShiftSample>& samples,
                                          int threads, const ShiftFieldOptions& options = {});

}  // namespace orthodrive::refine
