// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/network/curves/smooth_points.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "orthodrive/core/error.hpp"
#include "orthodrive/math/cholesky.hpp"

namespace orthodrive::network {
namespace {

constexpr std::size_t band = 3;
constexpr int passes = 8;           // of weights
constexpr double max_weight = 1e6;  // a node held to a thousandth of its pull
constexpr double pad_waves = 4.0;   // closed lines go on this many cutoff lengths beyond their seam

std::vector<Vec2> smooth_open(std::span<const Vec2> points, double cutoff_m, double reach_m) {
  const std::size_t n = points.size();
  std::vector<double> s(n, 0.0), span(n, 0.0), weight(n, 1.0);
  for (std::size_t i = 1; i < n; ++i) s[i] = s[i - 1] + distance(points[i - 1], points[i]);
  for (std::size_t i = 0; i < n; ++i) span[i] = 0.5 * (s[std::min(i + 1, n - 1)] - s[i > 0 ? i - 1 : 0]);
  const double lambda = std::pow(cutoff_m / (2.0 * std::numbers::pi), 6);
  std::vector<double> bend(n * (band + 1), 0.0);
  const SymmetricMatrix bending = SymmetricMatrix::banded(bend, band);
  for (std::size_t i = 0; i + 3 < n; ++i) {
    // Third derivative over four nodes: 6 times the divided difference.
    std::array<double, 4> c{};
    for (std::size_t k = 0; k < 4; ++k) {
      c[k] = 6.0;
      for (std::size_t m = 0; m < 4; ++m)
        if (m != k) c[k] /= s[i + k] - s[i + m];
    }
    const double w = lambda * (s[i + 3] - s[i]) / 3.0;
    for (std::size_t k = 0; k < 4; ++k)
      for (std::size_t m = 0; m <= k; ++m) bending(i + k, i + m) += w * c[k] * c[m];
  }
  std::vector<Vec2> q(n);
  std::vector<double> x(n), y(n);
  for (int pass = 0; pass < passes; ++pass) {
    std::vector<double> entries = bend;
    const SymmetricMatrix a = SymmetricMatrix::banded(entries, band);
    for (std::size_t i = 0; i < n; ++i) {
      const double w = weight[i] * span[i];
      a(i, i) += w;
      x[i] = points[i].x * w, y[i] = points[i].y * w;
    }
    if (!factorize(a)) throw Error("smoothing: nodes of a line coincide");
    solve_factored(a, x), solve_factored(a, y);
    for (std::size_t i = 0; i < n; ++i) q[i] = {x[i], y[i]};
    bool held = true;
    for (std::size_t i = 0; i < n; ++i) {
      const double off = distance(q[i], points[i]) / reach_m;
      if (off > 1.0) weight[i] = std::min(max_weight, weight[i] * off * off * 2.0), held = false;
    }
    if (held) break;
  }
  return q;
}

}  // namespace

std::vector<Vec2> smooth_points(std::span<const Vec2> points, bool closed, double cutoff_m, double reach_m) {
  const std::size_t n = points.size();
  if (n < 4) return {points.begin(), points.end()};
  if (!closed) return smooth_open(points, cutoff_m, reach_m);
  // Round and round: what is far beyond the seam does not matter.
  std::size_t pad = 0;
  for (double walked = 0.0; walked < pad_waves * cutoff_m && pad < n; ++pad)
    walked += distance(points[pad], points[(pad + 1) % n]);
  std::vector<Vec2> around;
  around.reserve(n + 2 * pad);
  for (std::size_t i = 0; i < n + 2 * pad; ++i) around.push_back(points[(i + n - pad) % n]);
  const std::vector<Vec2> q = smooth_open(around, cutoff_m, reach_m);
  return {q.begin() + static_cast<std::ptrdiff_t>(pad), q.begin() + static_cast<std::ptrdiff_t>(pad + n)};
}

}  // namespace orthodrive::network
