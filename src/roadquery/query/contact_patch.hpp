// SPDX-License-Identifier: Apache-2.0
#pragma once
// The plane that a tyre's contact area, or a plate of a simulator, stands on.

#include "roadquery/query/ground_query.hpp"

namespace roadquery {

struct PatchRectangle {
  double x = 0.0, y = 0.0, z_guess = 0.0;  ///< centre, m
  double heading = 0.0;                    ///< of its length, rad from east
  double length_m = 0.2, width_m = 0.2;
  int along = 5, across = 3;  ///< equal parts that are asked at their middles
};

struct ContactPatch {
  Place place = Place::none;  ///< of the centre, or of the first point that has a surface; none: no plane
  bool partial = false;       ///< a part has no surface, or lies in another place than the centre
  double covered = 0.0;       ///< share of the points that have a surface
  double z = 0.0;             ///< of the plane at the centre, m
  std::array<double, 3> normal = {0.0, 0.0, 1.0};
  double residual_m = 0.0;  ///< root mean square of the heights over the plane
  double friction = 0.0;    ///< mean
};

/// Least-squares plane z = a + b u + c v over the heights, u along and v across. The surfaces are those of the level
/// nearest to z_guess at the centre. Does not allocate.
[[nodiscard]] ContactPatch contact_patch(const GroundQuery& ground, const PatchRectangle& rectangle, Cursor& cursor);

}  // namespace roadquery
