// SPDX-License-Identifier: Apache-2.0
#pragma once
// What one unit of a CRS is on the ground: metres of web mercator are 0.67 m at 48 degrees of latitude.

#include "orthodrive/geo/crs.hpp"

namespace orthodrive {

/// Metres on the ground of one unit of a CRS. Both are the same where the CRS is conformal.
struct GroundScale {
  double least_m = 1.0;  ///< in the direction in which a unit is shortest
  double most_m = 1.0;   ///< in the direction in which a unit is longest
  /// How far lengths of the plane are from those on the ground: 0.01 = by a hundredth.
  [[nodiscard]] double error() const;
};

/// At a place in degrees of WGS84, on the ellipsoid, to 1e-6. Throws Error for an unknown CRS and for places that it
/// does not reach.
[[nodiscard]] GroundScale ground_scale(const Crs& crs, Vec2 lonlat);

}  // namespace orthodrive
