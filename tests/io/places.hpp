// SPDX-License-Identifier: Apache-2.0
#pragma once
// Where the made-up sites of the io tests lie.

#include "orthodrive/model/site_frame.hpp"

namespace orthodrive {

inline const Crs utm33{"EPSG:32633"};
constexpr Vec2 origin{500000.0, 5540000.0};  // on the central meridian of zone 33, near 50 degrees north

inline Polygon rectangle(double west, double south, double east, double north) {
  return {{{west, south}, {east, south}, {east, north}, {west, north}}, {}};
}
inline SiteFrame site_of(double size_m) {
  return {utm33, rectangle(origin.x, origin.y, origin.x + size_m, origin.y + size_m)};
}
inline SiteFrame lonlat_site(double west, double south, double east, double north) {
  const CoordinateTransform site_from_lonlat(Crs{"EPSG:4326"}, utm33);
  SiteFrame site{utm33, {}};
  for (const Vec2 p : {Vec2{west, south}, Vec2{east, south}, Vec2{east, north}, Vec2{west, north}})
    site.area.outer.push_back(site_from_lonlat.target_from_source(p));
  return site;
}

}  // namespace orthodrive
