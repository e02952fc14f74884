// SPDX-License-Identifier: Apache-2.0
#pragma once
// What all evaluations share: where they look, and how errors are summed up.

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "orthodrive/geo/polygon.hpp"

namespace orthodrive {

/// Where a score counts, in the CRS of what is scored.
struct ScoreRegion {
  std::optional<MultiPolygon> area;  ///< nothing given: everywhere
  MultiPolygon ignore;
  [[nodiscard]] bool contains(Vec2 p) const {
    return (!area || orthodrive::contains(*area, p)) && !orthodrive::contains(ignore, p);
  }
};
/// 1 where the centre of a pixel counts.
[[nodiscard]] Raster<std::uint8_t> region_mask(const GridFrame& frame, const ScoreRegion& region);

/// Errors are "ours minus truth". Without samples all but n are NaN.
struct ErrorSummary {
  double bias = 0.0;  ///< mean
  double mean_abs = 0.0;
  double p95 = 0.0;  ///< 95 % of the absolute errors are at most this (nearest rank)
  std::size_t n = 0;
};
[[nodiscard]] ErrorSummary summarize(const std::vector<double>& errors);

/// Share of the errors within so many of the sigmas that the nearest node states. NaN where no node states any.
struct SigmaCoverage {
  double one = std::numeric_limits<double>::quiet_NaN(), two = one;
};

/// Counts of errors within one and two sigma.
struct SigmaCount {
  std::size_t all = 0, one = 0, two = 0;
  void add(double error, double sigma) {
    if (!(sigma > 0.0)) return;
    ++all;
    one += std::abs(error) <= sigma ? 1 : 0;
    two += std::abs(error) <= 2.0 * sigma ? 1 : 0;
  }
  [[nodiscard]] SigmaCoverage coverage() const {
    if (all == 0) return {};
    return {static_cast<double>(one) / static_cast<double>(all), static_cast<double>(two) / static_cast<double>(all)};
  }
};

}  // namespace orthodrive
