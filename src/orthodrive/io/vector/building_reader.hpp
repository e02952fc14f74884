// SPDX-License-Identifier: Apache-2.0
#pragma once
// Buildings out of maps.

#include <filesystem>
#include <vector>

#include "orthodrive/core/finding.hpp"
#include "orthodrive/model/building.hpp"
#include "orthodrive/model/site_frame.hpp"

namespace orthodrive::io {

/// All polygons with building=* or building:part=* that touch the site's area, out of .osm, .osm.pbf, GeoJSON or
/// GeoPackage, in the order of the files. Heights of up to 0 or above 500 m, more than 150 levels, a min_height that is
/// not below the height and a roof that is higher than its building do not count: finding "buildings.odd_height". City
/// extracts with the short keys t (use), h (height) and lv (levels) are read, too. Throws InputError for files that
/// cannot be read.
[[nodiscard]] std::vector<Building> read_buildings(const std::vector<std::filesystem::path>& files,
                                                   const SiteFrame& site, Findings* findings = nullptr);

}  // namespace orthodrive::io
