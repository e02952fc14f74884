// SPDX-License-Identifier: Apache-2.0
#pragma once
// A CRS as text for files that others read: OpenDRIVE's geoReference.

#include <string>

#include "orthodrive/geo/crs.hpp"

namespace orthodrive {

constexpr double geo_reference_tolerance_m = 1.0;  ///< how far a place may lie from where the CRS itself puts it

/// Text of a CRS whose readers find the places of `box` (coordinates of the CRS) where they are. It is the PROJ.4
/// string where that keeps the datum. Else "+towgs84" is added, since that needs no grid of its reader: the parameters
/// that PROJ knows for the country, moved so that they are exact in the middle of the box. Where no PROJ.4 string comes
/// within geo_reference_tolerance_m it is WKT on one line. A vertical CRS is left out. Throws Error for an unknown CRS.
[[nodiscard]] std::string geo_reference(const Crs& crs, const Box2& box);

/// Whether two CRSs put a point of both on the same place of the earth, within geo_reference_tolerance_m: as near as a
/// text of geo_reference() is to the CRS that it was made of.
[[nodiscard]] bool is_same_place(const Crs& a, const Crs& b, Vec2 p);

}  // namespace orthodrive
