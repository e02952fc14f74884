// SPDX-License-Identifier: Apache-2.0
#pragma once
// OSM XML (API 0.6) writing. Reading is io/support/vector_io.hpp.

#include <filesystem>

#include "orthodrive/model/roads/osm_data.hpp"

namespace orthodrive::io {

/// .osm with WGS84 coordinates of 7 decimals (1 cm), nodes and ways in the order given, no dates: same data, same
/// bytes. Written aside first. Throws Error when a way refers to a node that is not there.
void write_osm(const std::filesystem::path& path, const OsmData& data);

}  // namespace orthodrive::io
