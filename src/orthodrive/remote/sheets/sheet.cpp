// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/remote/sheets/sheet.hpp"

#include <algorithm>
#include <cmath>

namespace orthodrive::remote {

bool is_on_earth(const Ring& ring) {
  return ring.size() >= 3 && std::all_of(ring.begin(), ring.end(), [](Vec2 p) {
           return std::abs(p.x) <= 360.0 && std::abs(p.y) <= 90.0;  // false for NaN
         });
}

Polygon lonlat_rectangle(double west, double south, double east, double north) {
  if (!(west <= east && south <= north)) return {};
  return {{{west, south}, {east, south}, {east, north}, {west, north}}, {}};
}

}  // namespace orthodrive::remote
