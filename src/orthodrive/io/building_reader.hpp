#pragma once
// Buildings out of maps.

#include <filesystem>
#include <vector>

#include "orthodrive/core/finding.hpp"
#include "orthodrive/model/building.hpp"
#include "orthodrive/model/site_frame.hpp"

namespace orthodrive::io {

/// All polygons with building=* that touch the site's area, out of .osm, .osm.pbf, GeoJSON or GeoPackage, in the order
/// of the files. Roofs without walls (building=roof, carport) are none. Heights of up to 0 or above 500 m, and more
/// than 150 levels, do not count: finding "buildings.odd_height". City extracts with the short keys t (use), h (height)
/// and lv (levels) are read, too. Throws InputError for files that cannot be read.
[[nodiscard]] std::vector<Building> read_buildings(const std::vector<std::filesystem::path>& files,
                                                   const SiteFrame& site, Findings* findings = nullptr);

}  // namespace orthodrive::io
