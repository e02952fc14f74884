// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/network/curves/fit_circle.hpp"

#include <cmath>

namespace orthodrive::network {

// Based on: I. Kasa, A circle fitting procedure and its error analysis, IEEE Trans. Instrum.
// Meas. 25 (1976). Linear in the centre and in radius^2 - centre^2.
std::optional<Circle> fit_circle(std::span<const Vec2> points) {
  if (points.size() < 3) return std::nullopt;
  Vec2 mean;
  for (const Vec2 p : points) mean = mean + p * (1.0 / static_cast<double>(points.size()));
  double xx = 0.0, xy = 0.0, yy = 0.0, xq = 0.0, yq = 0.0, q_sum = 0.0;
  for (const Vec2 p : points) {
    const Vec2 d = p - mean;
    const double q = dot(d, d);
    xx += d.x * d.x, xy += d.x * d.y, yy += d.y * d.y, xq += d.x * q, yq += d.y * q, q_sum += q;
  }
  const double det = xx * yy - xy * xy, n = static_cast<double>(points.size());
  if (!(det > 1e-6 * (xx + yy) * (xx + yy))) return std::nullopt;  // on a line
  const Vec2 c{0.5 * (xq * yy - yq * xy) / det, 0.5 * (yq * xx - xq * xy) / det};
  Circle circle{mean + c, std::sqrt(q_sum / n + dot(c, c)), 0.0};
  for (const Vec2 p : points) circle.error_m += std::pow(distance(p, circle.center) - circle.radius_m, 2.0) / n;
  circle.error_m = std::sqrt(circle.error_m);
  return circle;
}

}  // namespace orthodrive::network
