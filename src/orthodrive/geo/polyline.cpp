// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/geo/polyline.hpp"

#include <algorithm>
#include <cassert>
#include <limits>

#include "orthodrive/geo/segment.hpp"

namespace orthodrive {

double length_m(std::span<const Vec2> line) {
  double sum = 0.0;
  for (std::size_t i = 1; i < line.size(); ++i) sum += distance(line[i - 1], line[i]);
  return sum;
}

std::vector<double> arc_lengths_m(std::span<const Vec2> line) {
  std::vector<double> s(line.size(), 0.0);
  for (std::size_t i = 1; i < line.size(); ++i) s[i] = s[i - 1] + distance(line[i - 1], line[i]);
  return s;
}

std::vector<Vec2> tangents(std::span<const Vec2> line) {
  std::vector<Vec2> result(line.size(), Vec2{1.0, 0.0});
  for (std::size_t i = 0; i < line.size(); ++i) {
    std::size_t before = i, after = i;  // skip repeated points
    while (before > 0 && line[before] == line[i]) --before;
    while (after + 1 < line.size() && line[after] == line[i]) ++after;
    const Vec2 in = normalized(line[i] - line[before]), out = normalized(line[after] - line[i]);
    const Vec2 sum = in + out;
    if (length(sum) > 1e-9)
      result[i] = normalized(sum);
    else if (length(in) > 0.0)
      result[i] = in;  // a hairpin of 180 degrees: keep going straight
  }
  return result;
}

Vec2 mitre(Vec2 normal_before, Vec2 normal_behind) {
  const Vec2 sum = normal_before + normal_behind;
  const double square = dot(sum, sum);
  return square > 1.0 ? sum * (2.0 / square) : normal_before;
}

Vec2 point_at(std::span<const Vec2> line, double s_m) {
  assert(!line.empty());
  double s = 0.0;
  for (std::size_t i = 1; i < line.size(); ++i) {
    const double d = distance(line[i - 1], line[i]);
    if (s_m <= s + d && d > 0.0) return line[i - 1] + (line[i] - line[i - 1]) * std::max(0.0, (s_m - s) / d);
    s += d;
  }
  return line.back();
}

LineProjection project_onto(std::span<const Vec2> line, Vec2 p) {
  assert(line.size() >= 2);
  LineProjection best;
  best.distance_m = std::numeric_limits<double>::infinity();
  double s = 0.0;
  for (std::size_t i = 0; i + 1 < line.size(); ++i) {
    const Vec2 d = line[i + 1] - line[i];
    const double n = std::sqrt(dot(d, d)), t = share_along(line[i], line[i + 1], p);
    const Vec2 q = line[i] + d * t;
    const double dist = distance(p, q);
    if (dist < best.distance_m) best = {s + t * n, n > 0.0 ? cross(d, p - line[i]) / n : 0.0, dist, i, q};
    s += n;
  }
  return best;
}

Ring strip_ring(std::span<const Vec2> line, std::span<const double> left_m, std::span<const double> right_m) {
  assert(left_m.size() == line.size() && right_m.size() == line.size());
  const std::vector<Vec2> direction = tangents(line);
  Ring ring;
  ring.reserve(2 * line.size());
  for (std::size_t i = 0; i < line.size(); ++i) ring.push_back(line[i] - left_normal(direction[i]) * right_m[i]);
  for (std::size_t i = line.size(); i-- > 0;) ring.push_back(line[i] + left_normal(direction[i]) * left_m[i]);
  return ring;
}

}  // namespace orthodrive
