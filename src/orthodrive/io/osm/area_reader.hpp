// SPDX-License-Identifier: Apache-2.0
#pragma once
// Areas of sites out of files: polygons of longitudes and latitudes.

#include <cstdint>
#include <filesystem>
#include <vector>

#include "orthodrive/geo/polygon.hpp"

namespace orthodrive::io {

/// A polygon of closed rings as GeoJSON has them, the outer one first. Points that repeat the one before are dropped.
/// Throws OptionError for a ring that is not closed and for none.
[[nodiscard]] Polygon polygon_of_rings(std::vector<Ring> rings);

/// All polygons of a GeoJSON file (a geometry, a feature or a collection), in degrees of WGS84, largest first. Throws
/// InputError for a missing or malformed file, one without a polygon, one in another CRS, and for open rings.
[[nodiscard]] MultiPolygon read_areas(const std::filesystem::path& path);

/// The only polygon of a GeoJSON file. Throws InputError for several, and as read_areas does.
[[nodiscard]] Polygon read_area(const std::filesystem::path& path);

/// The polygons of a multipolygon or boundary relation of an .osm or .osm.pbf file, largest first, in degrees of WGS84.
/// Throws InputError when the file lacks the relation or some of its ways or nodes, and when they close no rings.
[[nodiscard]] MultiPolygon read_relation(const std::filesystem::path& path, std::int64_t relation_id);

}  // namespace orthodrive::io
