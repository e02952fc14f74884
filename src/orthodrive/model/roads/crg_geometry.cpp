// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/model/roads/crg_geometry.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace orthodrive {
namespace {

constexpr double border_rounding = 1e-9;  // m and shares of a step: what a place may lie outside by

/// The strip between rows i and i + 1, up to the lines of (u, v) through both.
struct Strip {
  Vec2 start, end, normal;        ///< normal of the chord, unit, to the left
  Vec2 across_start, across_end;  ///< per metre of v: their part along `normal` is 1
};

Vec2 row_point(const CrgSurface& s, std::size_t i) { return {s.x_m[i], s.y_m[i]}; }

Strip strip_at(const CrgSurface& s, std::size_t i) {
  Strip strip{row_point(s, i), row_point(s, i + 1), {}, {}, {}};
  strip.normal = left_normal(normalized(strip.end - strip.start));
  const auto across = [&](Vec2 before, Vec2 after) {
    const Vec2 n = left_normal(normalized(after - before));
    const double scale = dot(n, strip.normal);
    return std::abs(scale) > 1e-10 ? n * (1.0 / scale) : n;  // as the reference implementation does
  };
  strip.across_start = i > 0 ? across(row_point(s, i - 1), strip.end) : strip.normal;
  strip.across_end = i + 2 < s.rows() ? across(strip.start, row_point(s, i + 2)) : strip.normal;
  return strip;
}

/// Row at or before u, and how far to the next one; rows beyond the ends are carried on.
std::pair<std::size_t, double> row_at(const CrgSurface& s, double u_m) {
  const double row = (u_m - s.u_start_m) / s.u_increment_m;
  const double i = std::clamp(std::floor(row), 0.0, static_cast<double>(s.rows()) - 2.0);
  return {static_cast<std::size_t>(i), row - i};
}

}  // namespace

Vec2 crg_xy(const CrgSurface& s, CrgUv uv) {
  const auto [i, share] = row_at(s, uv.u_m);
  const Strip strip = strip_at(s, i);
  if (share < 0.0 || share > 1.0) {
    const Vec2 along = normalized(strip.end - strip.start);
    const double beyond_m = (share < 0.0 ? share : share - 1.0) * s.u_increment_m;
    return (share < 0.0 ? strip.start : strip.end) + along * beyond_m + strip.normal * uv.v_m;
  }
  const Vec2 a = strip.start + strip.across_start * uv.v_m, b = strip.end + strip.across_end * uv.v_m;
  return a + (b - a) * share;
}

double crg_height(const CrgSurface& s, CrgUv uv) {
  constexpr double missing = std::numeric_limits<double>::quiet_NaN();
  auto [i, p] = row_at(s, uv.u_m);
  if (!(p >= -border_rounding && p <= 1.0 + border_rounding)) return missing;
  p = std::clamp(p, 0.0, 1.0);
  if (!(uv.v_m >= s.v_m.front() - border_rounding && uv.v_m <= s.v_m.back() + border_rounding)) return missing;
  const auto after = std::upper_bound(s.v_m.begin() + 1, s.v_m.end() - 1, uv.v_m);
  const auto j = static_cast<std::size_t>(after - s.v_m.begin()) - 1;
  const double q = std::clamp((uv.v_m - s.v_m[j]) / (s.v_m[j + 1] - s.v_m[j]), 0.0, 1.0);
  double z = 0.0;
  const auto add = [&](double weight, double value) {
    if (weight > 0.0) z += weight * value;  // a missing value that counts nothing does no harm
  };
  add((1.0 - p) * (1.0 - q), s.grid(i, j));
  add((1.0 - p) * q, s.grid(i, j + 1));
  add(p * (1.0 - q), s.grid(i + 1, j));
  add(p * q, s.grid(i + 1, j + 1));
  const double reference_z = (1.0 - p) * s.z_m[i] + p * s.z_m[i + 1];
  return reference_z + ((1.0 - p) * s.banking[i] + p * s.banking[i + 1]) * uv.v_m + z;
}

}  // namespace orthodrive
