// SPDX-License-Identifier: Apache-2.0
#pragma once
// Points and vectors in metres (site CRS unless the name says otherwise).

#include <cmath>

namespace orthodrive {

struct Vec2 {
  double x = 0.0, y = 0.0;
  friend constexpr Vec2 operator+(Vec2 a, Vec2 b) { return {a.x + b.x, a.y + b.y}; }
  friend constexpr Vec2 operator-(Vec2 a, Vec2 b) { return {a.x - b.x, a.y - b.y}; }
  friend constexpr Vec2 operator*(Vec2 a, double k) { return {a.x * k, a.y * k}; }
  friend constexpr Vec2 operator*(double k, Vec2 a) { return a * k; }
  friend constexpr bool operator==(Vec2, Vec2) = default;
};

[[nodiscard]] constexpr double dot(Vec2 a, Vec2 b) { return a.x * b.x + a.y * b.y; }
/// z of the cross product: positive when b lies to the left of a.
[[nodiscard]] constexpr double cross(Vec2 a, Vec2 b) { return a.x * b.y - a.y * b.x; }
[[nodiscard]] inline double length(Vec2 a) { return std::hypot(a.x, a.y); }
[[nodiscard]] inline double distance(Vec2 a, Vec2 b) { return length(a - b); }
/// The zero vector stays zero.
[[nodiscard]] inline Vec2 normalized(Vec2 a) {
  const double n = length(a);
  return n > 0.0 ? a * (1.0 / n) : Vec2{};
}
/// Turned by +90 degrees: points to the left of a.
[[nodiscard]] constexpr Vec2 left_normal(Vec2 a) { return {-a.y, a.x}; }

struct Vec3 {
  double x = 0.0, y = 0.0, z = 0.0;
  friend constexpr Vec3 operator+(Vec3 a, Vec3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
  friend constexpr Vec3 operator-(Vec3 a, Vec3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
  friend constexpr Vec3 operator*(Vec3 a, double k) { return {a.x * k, a.y * k, a.z * k}; }
  friend constexpr bool operator==(Vec3, Vec3) = default;
};

[[nodiscard]] constexpr Vec3 cross(Vec3 a, Vec3 b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

struct Box2 {
  double min_x = 0.0, min_y = 0.0, max_x = 0.0, max_y = 0.0;
  [[nodiscard]] double width() const { return max_x - min_x; }
  [[nodiscard]] double height() const { return max_y - min_y; }
  [[nodiscard]] bool contains(Vec2 p) const { return p.x >= min_x && p.x <= max_x && p.y >= min_y && p.y <= max_y; }
  [[nodiscard]] bool overlaps(const Box2& b) const {
    return min_x <= b.max_x && b.min_x <= max_x && min_y <= b.max_y && b.min_y <= max_y;
  }
  [[nodiscard]] Box2 grown(double margin) const {
    return {min_x - margin, min_y - margin, max_x + margin, max_y + margin};
  }
  friend bool operator==(const Box2&, const Box2&) = default;
};

}  // namespace orthodrive
