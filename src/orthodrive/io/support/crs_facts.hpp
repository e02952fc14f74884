// SPDX-License-Identifier: Apache-2.0
#pragma once
// What services need to know of a coordinate reference system beside its transformations.

#include "orthodrive/geo/crs.hpp"

namespace orthodrive::io {

struct CrsFacts {
  bool geographic = false;
  bool north_first = false;      ///< the authority writes latitude or northing before longitude or easting
  double metres_per_unit = 1.0;  ///< of a degree: at the equator of WGS84, as WMTS has it
};
/// Throws Error for a CRS that is not known.
[[nodiscard]] CrsFacts crs_facts(const Crs& crs);

}  // namespace orthodrive::io
