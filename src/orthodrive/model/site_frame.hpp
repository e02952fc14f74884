// SPDX-License-Identifier: Apache-2.0
#pragma once
// Where a site lies: its metric CRS and its area.

#include "orthodrive/geo/crs.hpp"
#include "orthodrive/geo/polygon.hpp"

namespace orthodrive {

struct SiteFrame {
  Crs crs;       ///< metric, UTM unless the site file says otherwise
  Polygon area;  ///< in that CRS; a box of longitudes and latitudes becomes a slightly turned, densified ring
};

}  // namespace orthodrive
