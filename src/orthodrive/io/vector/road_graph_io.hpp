// SPDX-License-Identifier: Apache-2.0
#pragma once
// The roads before and after they were moved onto the photo, for the viewer and for QGIS.

#include <filesystem>

#include "orthodrive/model/roads/road_network.hpp"

namespace orthodrive::io {

/// GeoJSON lines in WGS84 (RFC 7946, 7 decimals), first the map's, then the refined ones, with the properties
///   state "before" or "after", osm_id, part, name, highway;
///   z_m: heights of the line's points above the sea, null where they are not known;
///   of those after also width_m, sigma_offset_m and sigma_width_m: a number a point.
/// Lines of the map take their heights from the nearest refined point of the same way. Both in one CRS.
void write_road_graph(const std::filesystem::path& path, const RoadNetwork& before, const RoadNetwork& after);

}  // namespace orthodrive::io
