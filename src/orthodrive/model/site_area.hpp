// SPDX-License-Identifier: Apache-2.0
#pragma once
// The area of a site as people give it, in degrees, and the frame that is made of it. What cannot be is told with what
// to do about it.

#include <array>
#include <string>

#include "orthodrive/core/finding.hpp"
#include "orthodrive/model/site_frame.hpp"

namespace orthodrive {

/// West, south, east, north; degrees of WGS84.
using LonLatBox = std::array<double, 4>;

constexpr double highest_latitude_deg = 84.0;     ///< where UTM and the tile grids of photos end
constexpr double narrowest_area_m = 50.0;         ///< less holds no road worth building
constexpr double farthest_from_meridian_deg = 4;  ///< a UTM zone reaches 3 degrees to each side
constexpr double largest_area_m2 = 2500e6;        ///< 50 x 50 km: one CRS and one file of each source still serve it

/// A box as a polygon of four corners. Throws OptionError for sides in the wrong order (with the order that was
/// probably meant), a box across the antimeridian or nearer to a pole than 84 degrees.
[[nodiscard]] Polygon polygon_of_box(const LonLatBox& box);

/// Throws OptionError for a polygon of degrees with fewer than three corners, beyond the world, across the
/// antimeridian, near a pole, or whose rings cross or touch themselves (with the place).
void check_lonlat_area(const Polygon& lonlat);

/// The frame of a polygon of degrees: its CRS, "auto" = the UTM zone of the middle of its bounds, and the area in it.
/// Edges get points at least every 1/32 of their length and every 5 km, since straight edges in degrees are bent there.
/// Throws OptionError for an unknown CRS, one that check_scale refuses, and what check_area refuses.
[[nodiscard]] SiteFrame site_frame_of(const Polygon& lonlat, const std::string& crs = "auto");

/// Throws Error for an unknown CRS and OptionError for one of degrees: here, not three stages later.
void check_crs(const Crs& crs);

constexpr double largest_scale_error = 0.01;  ///< of lengths in a site's CRS: 35 mm of a lane

/// Throws OptionError where a unit of the CRS is not a metre on the ground to largest_scale_error, in any direction:
/// web mercator, feet, CRSs made for continents. `lonlat` is a place of the site, degrees of WGS84.
void check_scale(const Crs& crs, Vec2 lonlat);

/// Throws OptionError for an area narrower than 50 m.
void check_area(const SiteFrame& frame);

/// "area.off_meridian" (info) when a place lies more than 4 degrees from the middle of the UTM zone of the frame,
/// where lengths are off by up to 2 per mille; "area.scale" (warning) when lengths in another CRS are off by more than
/// that in the middle of the area. `lonlat` is the area in degrees.
[[nodiscard]] Findings findings_of_area(const Polygon& lonlat, const SiteFrame& frame);

}  // namespace orthodrive
