// SPDX-License-Identifier: Apache-2.0
#pragma once
// Barriers, water, railways, paths, street lamps, power lines and objects out of maps.

#include <filesystem>
#include <vector>

#include "orthodrive/core/finding.hpp"
#include "orthodrive/model/map_surroundings.hpp"
#include "orthodrive/model/site_frame.hpp"

namespace orthodrive::io {

/// What touches the site's area, out of .osm, .osm.pbf, GeoJSON or GeoPackage, in the order of the files: lines and
/// outlines with barrier=hedge, wall, fence, guard_rail and the like; polygons with natural=water, landuse=reservoir or
/// basin, and polygons without any tag (city extracts of water have none); lines with railway=rail, tram and the like;
/// lines with highway=footway, path, cycleway, bridleway, steps or pedestrian that cross no road; points with
/// highway=street_lamp; lines with power=line or minor_line; points and the middles of areas that object_kind() knows.
/// What lies in a tunnel or on a bridge is left out. Heights of 0 and less or above 20 m (400 m of objects) do not
/// count: finding "surroundings.odd_height". City extracts with the short key t (water, rail) and br (on a bridge) are
/// read, too. Throws InputError for files that cannot be read.
[[nodiscard]] MapSurroundings read_surroundings(const std::vector<std::filesystem::path>& files, const SiteFrame& site,
                                                Findings* findings = nullptr);

}  // namespace orthodrive::io
