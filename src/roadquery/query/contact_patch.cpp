// SPDX-License-Identifier: Apache-2.0
#include "roadquery/query/contact_patch.hpp"

#include <cmath>

namespace roadquery {
namespace {

/// Sums of the normal equations, u and v in half lengths and half widths so that they are of the order of 1.
struct Sums {
  double n = 0.0, u = 0.0, v = 0.0, uu = 0.0, uv = 0.0, vv = 0.0, z = 0.0, uz = 0.0, vz = 0.0, zz = 0.0;
  void add(double at_u, double at_v, double height) {
    n += 1.0, u += at_u, v += at_v, uu += at_u * at_u, uv += at_u * at_v, vv += at_v * at_v;
    z += height, uz += at_u * height, vz += at_v * height, zz += height * height;
  }
};

struct Plane {
  double a = 0.0, b = 0.0, c = 0.0;  ///< z = a + b u + c v
  double mean_square = 0.0;
};

/// About the mean point, which decouples a. Nothing for points on a line.
std::optional<Plane> fit(const Sums& sums) {
  if (sums.n < 3.0) return std::nullopt;
  const double u = sums.u / sums.n, v = sums.v / sums.n, z = sums.z / sums.n;
  const double uu = sums.uu / sums.n - u * u, uv = sums.uv / sums.n - u * v, vv = sums.vv / sums.n - v * v;
  const double uz = sums.uz / sums.n - u * z, vz = sums.vz / sums.n - v * z, zz = sums.zz / sums.n - z * z;
  const double determinant = uu * vv - uv * uv;
  if (!(determinant > 1e-9)) return std::nullopt;
  const double b = (uz * vv - vz * uv) / determinant, c = (vz * uu - uz * uv) / determinant;
  return Plane{z - b * u - c * v, b, c, std::max(zz - b * uz - c * vz, 0.0)};
}

}  // namespace

ContactPatch contact_patch(const GroundQuery& ground, const PatchRectangle& rectangle, Cursor& cursor) {
  const double cos_heading = std::cos(rectangle.heading), sin_heading = std::sin(rectangle.heading);
  const GroundHit centre = ground.find(rectangle.x, rectangle.y, rectangle.z_guess, cursor, 0);
  // Heights relative to the centre's, so that sums of squares keep their digits.
  const double level =
      centre.place != Place::none ? centre.hit.z : (std::isnan(rectangle.z_guess) ? 0.0 : rectangle.z_guess);
  const double guess = centre.place != Place::none ? centre.hit.z : rectangle.z_guess;
  ContactPatch patch{centre.place};
  Sums sums;
  Cursor at = cursor;
  for (int i = 0; i < rectangle.along; ++i) {
    for (int j = 0; j < rectangle.across; ++j) {
      const double u = (2.0 * i + 1.0) / rectangle.along - 1.0, v = (2.0 * j + 1.0) / rectangle.across - 1.0;
      const double forward = 0.5 * rectangle.length_m * u, left = 0.5 * rectangle.width_m * v;
      const GroundHit found =
          ground.find(rectangle.x + forward * cos_heading - left * sin_heading,
                      rectangle.y + forward * sin_heading + left * cos_heading, guess, at, hit_material);
      patch.partial = patch.partial || found.place != centre.place;
      if (found.place == Place::none) continue;
      if (patch.place == Place::none) patch.place = found.place;
      sums.add(u, v, found.hit.z - level);
      patch.friction += found.hit.friction;
    }
  }
  patch.covered = sums.n / (static_cast<double>(rectangle.along) * rectangle.across);
  const auto plane = fit(sums);
  if (!plane) {
    patch.place = Place::none;
    return patch;
  }
  patch.friction /= sums.n;
  patch.z = level + plane->a;
  const double forward_slope = 2.0 * plane->b / rectangle.length_m, left_slope = 2.0 * plane->c / rectangle.width_m;
  const double norm = std::sqrt(1.0 + forward_slope * forward_slope + left_slope * left_slope);
  patch.normal = {-(forward_slope * cos_heading - left_slope * sin_heading) / norm,
                  -(forward_slope * sin_heading + left_slope * cos_heading) / norm, 1.0 / norm};
  patch.residual_m = std::sqrt(plane->mean_square);
  return patch;
}

}  // namespace roadquery
