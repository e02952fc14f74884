// SPDX-License-Identifier: Apache-2.0
#pragma once
// Single trees out of maps.

#include <filesystem>
#include <vector>

#include "orthodrive/model/site_frame.hpp"

namespace orthodrive::io {

/// Places of trees in the site's area, out of .osm, .osm.pbf, GeoJSON or GeoPackage, in the order of the files: points
/// with natural=tree, and every 8 m of lines with natural=tree_row. Points without any tag are trees, too: city
/// extracts of trees have none. Throws InputError for files that cannot be read.
[[nodiscard]] std::vector<Vec2> read_trees(const std::vector<std::filesystem::path>& files, const SiteFrame& site);

}  // namespace orthodrive::io
