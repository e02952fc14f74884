// SPDX-License-Identifier: Apache-2.0
#include "vehicle/multibody.hpp"

namespace vehicle {
namespace {

using Matrix6 = std::array<std::array<double, 6>, 6>;  // lower triangle
using Vector6 = std::array<double, 6>;

/// Solves a x = b for a symmetric positive definite matrix (L D L^T in place).
Vector6 solve(Matrix6& a, Vector6 b) {
  std::array<double, 6> inverse{};
  for (std::size_t j = 0; j < 6; ++j) {
    inverse[j] = 1.0 / a[j][j];
    for (std::size_t i = j + 1; i < 6; ++i) {
      const double l = a[i][j] * inverse[j];
      for (std::size_t k = j + 1; k <= i; ++k) a[i][k] -= l * a[k][j];
    }
    for (std::size_t i = j + 1; i < 6; ++i) {
      a[i][j] *= inverse[j];
      b[i] -= a[i][j] * b[j];
    }
  }
  for (std::size_t j = 6; j-- > 0;) {
    b[j] *= inverse[j];
    for (std::size_t i = j + 1; i < 6; ++i) b[j] -= a[i][j] * b[i];
  }
  return b;
}

void add(Vector6& v, std::size_t first, const Vec3& a) {
  v[first] += a.x;
  v[first + 1] += a.y;
  v[first + 2] += a.z;
}

/// The mass of a hub counts across its path only: M = m (1 - e e^T), e the unit path. With c = place x e its share is
///   [ M, -M S; S M, -S M S ],   -S M S = m (r^2 1 - r r^T - c c^T),   S M = m (S - c e^T),   S v = place x v.
void add_hub(Matrix6& a, double mass, const Vec3& r, const Vec3& e, const Vec3& c) {
  a[0][0] += mass * (1.0 - e.x * e.x);
  a[1][0] -= mass * e.y * e.x;
  a[1][1] += mass * (1.0 - e.y * e.y);
  a[2][0] -= mass * e.z * e.x;
  a[2][1] -= mass * e.z * e.y;
  a[2][2] += mass * (1.0 - e.z * e.z);
  a[3][0] -= mass * c.x * e.x;
  a[3][1] -= mass * (r.z + c.x * e.y);
  a[3][2] += mass * (r.y - c.x * e.z);
  a[4][0] += mass * (r.z - c.y * e.x);
  a[4][1] -= mass * c.y * e.y;
  a[4][2] -= mass * (r.x + c.y * e.z);
  a[5][0] -= mass * (r.y + c.z * e.x);
  a[5][1] += mass * (r.x - c.z * e.y);
  a[5][2] -= mass * c.z * e.z;
  const double r2 = dot(r, r);
  a[3][3] += mass * (r2 - r.x * r.x - c.x * c.x);
  a[4][3] -= mass * (r.y * r.x + c.y * c.x);
  a[4][4] += mass * (r2 - r.y * r.y - c.y * c.y);
  a[5][3] -= mass * (r.z * r.x + c.z * c.x);
  a[5][4] -= mass * (r.z * r.y + c.z * c.y);
  a[5][5] += mass * (r2 - r.z * r.z - c.z * c.z);
}

}  // namespace

Accelerations solve_motion(const SprungBody& body, const Vec3& w, const Vec3& gravity, const Vec3& force,
                           const Vec3& moment, const std::array<Hub, 4>& hubs) {
  Matrix6 a{};
  a[0][0] = a[1][1] = a[2][2] = body.mass_kg;
  a[3][3] = body.inertia.xx;
  a[4][4] = body.inertia.yy;
  a[5][5] = body.inertia.zz;
  a[4][3] = body.inertia.xy;
  a[5][3] = body.inertia.xz;
  a[5][4] = body.inertia.yz;
  Vector6 b{};
  add(b, 0, force + body.mass_kg * gravity);
  add(b, 3, moment - cross(w, body.inertia * w));

  struct Path {
    Vec3 unit, drift;
    double inverse_length = 1.0, along_n = 0.0;
  };
  std::array<Path, 4> paths;
  for (std::size_t i = 0; i < 4; ++i) {
    const Hub& hub = hubs[i];
    Path& p = paths[i];
    p.inverse_length = 1.0 / norm(hub.path);
    p.unit = p.inverse_length * hub.path;
    // Acceleration of the hub without that of body and travel: centripetal and Coriolis.
    p.drift = cross(w, cross(w, hub.place)) + (2.0 * hub.rate_mps) * cross(w, hub.path);
    const Vec3 load = hub.force_n + hub.mass_kg * gravity;
    p.along_n = dot(load, p.unit) + hub.along_n * p.inverse_length;
    const Vec3 across = hub.mass_kg * (p.drift - dot(p.drift, p.unit) * p.unit);
    const Vec3 held = across + p.along_n * p.unit;  // mass times acceleration, the part that is known
    add(b, 0, load - held);
    add(b, 3, hub.moment_nm + cross(hub.place, hub.mass_kg * gravity - held));
    add_hub(a, hub.mass_kg, hub.place, p.unit, cross(hub.place, p.unit));
  }
  const Vector6 x = solve(a, b);
  Accelerations result;
  result.linear = {x[0], x[1], x[2]};
  result.angular = {x[3], x[4], x[5]};
  for (std::size_t i = 0; i < 4; ++i) {
    const Path& p = paths[i];
    const Vec3 carried = result.linear + cross(result.angular, hubs[i].place) + p.drift;
    result.travel[i] = (p.along_n / hubs[i].mass_kg - dot(p.unit, carried)) * p.inverse_length;
  }
  return result;
}

}  // namespace vehicle
