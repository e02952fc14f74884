// SPDX-License-Identifier: Apache-2.0
// The area of a site as services need it.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "orthodrive/core/error.hpp"
#include "orthodrive/geo/overlay.hpp"
#include "orthodrive/remote/tiles/tile_plan.hpp"

namespace orthodrive::remote {
namespace {
/// Edges bend in another CRS.
Ring densified(const Ring& ring) {
  constexpr int steps = 16;
  Ring result;
  for (std::size_t i = 0; i < ring.size(); ++i)
    for (int k = 0; k < steps; ++k)
      result.push_back(ring[i] + (ring[(i + 1) % ring.size()] - ring[i]) * (k / static_cast<double>(steps)));
  return result;
}

/// With the margin around it, in the site's CRS.
Ring grown(const SiteFrame& site, double margin_m, const std::string& name) {
  if (site.area.outer.size() < 3 || !(area_m2(site.area) > 0.0))
    throw InputError(name, "the area of the site is empty");
  const Vec2 center = site.area.outer.front();  // UTM coordinates would cost digits
  const MultiPolygon larger = buffer_of({moved({site.area.outer, {}}, Vec2{} - center)}, margin_m, 2);
  if (larger.empty()) throw InputError(name, "the area of the site is empty");
  return densified(moved(larger.front(), center).outer);
}

Ring in_lonlat(const Ring& ring, const SiteFrame& site, const std::string& name) {
  const CoordinateTransform lonlat_from_site(site.crs, Crs{"EPSG:4326"});
  Ring result;
  for (const Vec2 p : ring) result.push_back(lonlat_from_site.target_from_source(p));
  const Box2 box = bounds_of(result);
  // Beside the line of 180 degrees one point has 179.9 and the next -179.9.
  if (box.width() > 180.0)
    throw InputError(name, "the area lies across the antimeridian (180 degrees); make two sites, one of each side");
  return result;
}
}  // namespace

Polygon area_in(const SiteFrame& site, const Crs& crs, double margin_m, const std::string& name) {
  const Ring ring = grown(site, margin_m, name);
  const Box2 lonlat = bounds_of(in_lonlat(ring, site, name));
  if (crs.definition == "EPSG:3857" && std::max(std::abs(lonlat.min_y), std::abs(lonlat.max_y)) > web_mercator_latitude)
    throw InputError(name,
                     fmt::format("the area reaches latitude {:.2f}, web mercator ends at 85.05; take a service in "
                                 "a polar projection",
                                 std::abs(lonlat.min_y) > lonlat.max_y ? lonlat.min_y : lonlat.max_y));
  const CoordinateTransform target_from_site(site.crs, crs);
  Polygon result;
  for (const Vec2 p : ring) result.outer.push_back(target_from_site.target_from_source(p));
  return result;
}

Box2 lonlat_box(const SiteFrame& site, double margin_m, const std::string& name) {
  return bounds_of(in_lonlat(grown(site, margin_m, name), site, name));
}

}  // namespace orthodrive::remote
