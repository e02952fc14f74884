// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/geo/ground_scale.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "orthodrive/core/error.hpp"

namespace orthodrive {

double GroundScale::error() const { return std::max(std::abs(1.0 / least_m - 1.0), std::abs(1.0 / most_m - 1.0)); }

// Singular values of the Jacobian from metres on the ellipsoid to units of the CRS (Tissot's indicatrix; Snyder, Map
// Projections: A Working Manual, 1987, sec. 4), by central differences: PROJ's own factors know no datum shift.
GroundScale ground_scale(const Crs& crs, Vec2 lonlat) {
  constexpr double a = 6378137.0, f = 1.0 / 298.257223563, e2 = f * (2.0 - f);  // WGS84
  constexpr double step_deg = 1e-4;
  constexpr double step_rad = step_deg * std::numbers::pi / 180.0;
  const double latitude_deg = std::clamp(lonlat.y, -89.9, 89.9);  // a step must not cross the pole
  const double latitude = latitude_deg * std::numbers::pi / 180.0;
  const double w2 = 1.0 - e2 * std::sin(latitude) * std::sin(latitude);
  const double east_m = 2.0 * step_rad * a / std::sqrt(w2) * std::cos(latitude),
               north_m = 2.0 * step_rad * a * (1.0 - e2) / (w2 * std::sqrt(w2));
  const CoordinateTransform crs_from_lonlat(Crs{"EPSG:4326"}, crs);
  const auto at = [&](double dx, double dy) {
    return crs_from_lonlat.target_from_source({lonlat.x + dx, latitude_deg + dy});
  };
  const Vec2 east = (at(step_deg, 0.0) - at(-step_deg, 0.0)) * (1.0 / east_m),
             north = (at(0.0, step_deg) - at(0.0, -step_deg)) * (1.0 / north_m);
  const double sum = east.x * east.x + east.y * east.y + north.x * north.x + north.y * north.y,
               area = std::abs(east.x * north.y - east.y * north.x);
  const double plus = std::sqrt(sum + 2.0 * area), minus = std::sqrt(std::max(0.0, sum - 2.0 * area));
  const double largest = 0.5 * (plus + minus), smallest = 0.5 * (plus - minus);
  if (!(smallest > 0.0)) throw Error("CRS '" + crs.definition + "' has no area here");
  return {1.0 / largest, 1.0 / smallest};
}

}  // namespace orthodrive
