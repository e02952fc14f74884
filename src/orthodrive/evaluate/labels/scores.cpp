// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/evaluate/labels/scores.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "orthodrive/core/median.hpp"

namespace orthodrive {

ErrorSummary summarize(const std::vector<double>& errors) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  if (errors.empty()) return {nan, nan, nan, 0};
  ErrorSummary summary{.n = errors.size()};
  std::vector<double> sizes;
  sizes.reserve(errors.size());
  for (const double error : errors) {
    summary.bias += error;
    sizes.push_back(std::abs(error));
    summary.mean_abs += sizes.back();
  }
  summary.bias /= static_cast<double>(errors.size());
  summary.mean_abs /= static_cast<double>(errors.size());
  const std::size_t rank = (95 * errors.size() + 99) / 100;  // 1-based, rounded up
  summary.p95 = at_rank(sizes, rank - 1);
  return summary;
}

Raster<std::uint8_t> region_mask(const GridFrame& frame, const ScoreRegion& region) {
  Raster<std::uint8_t> mask(frame.width, frame.height, 1, region.area ? 0 : 1);
  if (region.area)
    for (const Polygon& polygon : *region.area) fill_polygon(mask, frame, polygon, std::uint8_t{1});
  for (const Polygon& polygon : region.ignore) fill_polygon(mask, frame, polygon, std::uint8_t{0});
  return mask;
}

}  // namespace orthodrive
