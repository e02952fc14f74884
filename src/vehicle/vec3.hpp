// SPDX-License-Identifier: Apache-2.0
#pragma once
// Vectors and rotations in space.

#include <array>
#include <cmath>

namespace vehicle {

struct Vec3 {
  double x = 0.0, y = 0.0, z = 0.0;

  Vec3& operator+=(const Vec3& o) {
    x += o.x;
    y += o.y;
    z += o.z;
    return *this;
  }
};

inline Vec3 operator+(const Vec3& a, const Vec3& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Vec3 operator-(const Vec3& a, const Vec3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Vec3 operator-(const Vec3& a) { return {-a.x, -a.y, -a.z}; }
inline Vec3 operator*(double s, const Vec3& a) { return {s * a.x, s * a.y, s * a.z}; }
inline double dot(const Vec3& a, const Vec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Vec3 cross(const Vec3& a, const Vec3& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline double norm(const Vec3& a) { return std::sqrt(dot(a, a)); }
inline std::array<double, 3> to_array(const Vec3& a) { return {a.x, a.y, a.z}; }
inline Vec3 to_vec3(const std::array<double, 3>& a) { return {a[0], a[1], a[2]}; }

/// Columns are the images of the axes.
struct Mat3 {
  Vec3 x{1.0, 0.0, 0.0}, y{0.0, 1.0, 0.0}, z{0.0, 0.0, 1.0};
};

inline Vec3 operator*(const Mat3& m, const Vec3& v) { return v.x * m.x + v.y * m.y + v.z * m.z; }
/// Transpose of m times v.
inline Vec3 transposed_times(const Mat3& m, const Vec3& v) { return {dot(m.x, v), dot(m.y, v), dot(m.z, v)}; }

/// Unit quaternion: rotation of the car's frame into the world.
struct Quaternion {
  double w = 1.0, x = 0.0, y = 0.0, z = 0.0;
};

inline Mat3 matrix(const Quaternion& q) {
  return {{1.0 - 2.0 * (q.y * q.y + q.z * q.z), 2.0 * (q.x * q.y + q.w * q.z), 2.0 * (q.x * q.z - q.w * q.y)},
          {2.0 * (q.x * q.y - q.w * q.z), 1.0 - 2.0 * (q.x * q.x + q.z * q.z), 2.0 * (q.y * q.z + q.w * q.x)},
          {2.0 * (q.x * q.z + q.w * q.y), 2.0 * (q.y * q.z - q.w * q.x), 1.0 - 2.0 * (q.x * q.x + q.y * q.y)}};
}

/// q turned by the rotation vector (radians, in the car's frame). The small-angle form of the half angle is exact to
/// the fifth order, which over one step is rounding.
inline Quaternion turned(const Quaternion& q, const Vec3& rotation) {
  const double angle2 = dot(rotation, rotation);
  const double c = 1.0 - angle2 / 8.0 + angle2 * angle2 / 384.0;
  const double s = 0.5 - angle2 / 48.0 + angle2 * angle2 / 3840.0;
  const Vec3 v = s * rotation;
  Quaternion r{q.w * c - q.x * v.x - q.y * v.y - q.z * v.z, q.w * v.x + q.x * c + q.y * v.z - q.z * v.y,
               q.w * v.y - q.x * v.z + q.y * c + q.z * v.x, q.w * v.z + q.x * v.y - q.y * v.x + q.z * c};
  const double scale = 1.0 / std::sqrt(r.w * r.w + r.x * r.x + r.y * r.y + r.z * r.z);
  return {scale * r.w, scale * r.x, scale * r.y, scale * r.z};
}

}  // namespace vehicle
