// SPDX-License-Identifier: Apache-2.0
#pragma once
// Equations of motion of a body with four hubs that slide along straight paths in it.

#include <array>

#include "vehicle/vec3.hpp"

namespace vehicle {

/// Symmetric: x x, y y, z z and products x y, x z, y z, entered as they stand in the matrix.
struct Inertia {
  double xx = 0.0, yy = 0.0, zz = 0.0, xy = 0.0, xz = 0.0, yz = 0.0;
};
inline Vec3 operator*(const Inertia& i, const Vec3& v) {
  return {i.xx * v.x + i.xy * v.y + i.xz * v.z, i.xy * v.x + i.yy * v.y + i.yz * v.z,
          i.xz * v.x + i.yz * v.y + i.zz * v.z};
}

struct SprungBody {
  double mass_kg = 0.0;
  Inertia inertia;  ///< about its own c.g., kg m2
};

/// A hub with its load. All in the frame of the body, with the body's c.g. as origin.
struct Hub {
  double mass_kg = 0.0;
  Vec3 place;             ///< m
  Vec3 path;              ///< change of place per metre of travel
  double rate_mps = 0.0;  ///< of the travel
  Vec3 force_n;           ///< on hub and wheel from outside, without gravity
  Vec3 moment_nm;         ///< of that force and of what turns, about the origin
  double along_n = 0.0;   ///< force between body and hub along the travel (springs, dampers): power = along_n rate
};

struct Accelerations {
  Vec3 linear;   ///< of the origin, in the body's axes, m/s2
  Vec3 angular;  ///< rad/s2
  std::array<double, 4> travel{};
};

/// Newton and Euler for body and hubs together (Kane's form: forces that do no work do not appear), reduced to the six
/// unknowns of the body. force_n and moment_nm act on the body besides gravity.
[[nodiscard]] Accelerations solve_motion(const SprungBody& body, const Vec3& rates_radps, const Vec3& gravity_mps2,
                                         const Vec3& force_n, const Vec3& moment_nm, const std::array<Hub, 4>& hubs);

}  // namespace vehicle
