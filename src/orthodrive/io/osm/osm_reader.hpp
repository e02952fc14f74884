// SPDX-License-Identifier: Apache-2.0
#pragma once
// OSM files as they are, node by node. Roads ready for the stages are read by io/support/vector_io.hpp.

#include <filesystem>

#include "orthodrive/model/roads/osm_data.hpp"

namespace orthodrive::io {

/// All nodes and ways of a .osm / .osm.pbf with their ids and tags, sorted by id, places in `target_crs`; the inverse
/// of write_osm. Relations and the tags of nodes are left out. Throws InputError for a missing or truncated file.
[[nodiscard]] OsmData read_osm(const std::filesystem::path& path, const Crs& target_crs);

}  // namespace orthodrive::io
