// SPDX-License-Identifier: Apache-2.0
#pragma once
// OpenStreetMap data as it is in a file: nodes, ways that share them, tags. What the synthetic site hands to io.

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "orthodrive/geo/crs.hpp"
#include "orthodrive/geo/vec.hpp"

namespace orthodrive {

struct OsmNode {
  std::int64_t id = 0;
  Vec2 p;  ///< in OsmData::crs
};

struct OsmWay {
  std::int64_t id = 0;
  std::vector<std::int64_t> nodes;  ///< ids; a closed way repeats its first node at the end
  std::map<std::string, std::string> tags;
};

struct OsmData {
  Crs crs;
  std::vector<OsmNode> nodes;  ///< sorted by id
  std::vector<OsmWay> ways;    ///< sorted by id
};

}  // namespace orthodrive
