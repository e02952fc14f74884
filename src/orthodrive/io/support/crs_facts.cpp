// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/io/support/crs_facts.hpp"

#include "orthodrive/io/support/gdal_support.hpp"

namespace orthodrive::io {

CrsFacts crs_facts(const Crs& crs) {
  constexpr double degree_m = 111319.49079327358;  // OGC 07-057r7, 6.1
  start_gdal();
  const OGRSpatialReference reference = spatial_reference(crs);
  CrsFacts facts;
  facts.geographic = reference.IsGeographic() != 0;
  facts.north_first = reference.EPSGTreatsAsLatLong() != 0 || reference.EPSGTreatsAsNorthingEasting() != 0;
  facts.metres_per_unit = facts.geographic ? degree_m : reference.GetLinearUnits();
  return facts;
}

}  // namespace orthodrive::io
