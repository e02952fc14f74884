// SPDX-License-Identifier: Apache-2.0
#pragma once
// The part of an OSM extract that a site needs.

#include <cstdint>
#include <filesystem>
#include <string>

#include "orthodrive/geo/vec.hpp"

namespace orthodrive::io {

struct CutOsm {
  std::int64_t nodes = 0, ways = 0, relations = 0;
  std::string timestamp;  ///< of the extract's data, empty where it does not say
};

/// Writes TO (.osm.pbf or .osm) of the nodes in the box, the ways with one of them with all their nodes, the
/// multipolygons of these with all their ways, and other relations of these. Without who edited when. Same input, same
/// bytes. The order of the objects in FROM does not matter. Memory: one bit for each possible id. Throws InputError for
/// what is no OSM file or has nothing in the box.
CutOsm cut_osm(const std::filesystem::path& from, const std::filesystem::path& to, const Box2& lonlat);

}  // namespace orthodrive::io
