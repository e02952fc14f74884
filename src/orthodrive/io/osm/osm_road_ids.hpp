// SPDX-License-Identifier: Apache-2.0
#pragma once
// Ids of OSM's nodes in roads.

#include <cstdint>

#include "orthodrive/model/roads/osm_node_id.hpp"

namespace orthodrive::io {

/// OSM has no object 0, some converters write one: in roads 0 means none.
constexpr std::int64_t stand_in_for_0 = -(std::int64_t{1} << 53) + 1;
[[nodiscard]] constexpr std::int64_t road_node(std::int64_t id) { return id == no_osm_node ? stand_in_for_0 : id; }

}  // namespace orthodrive::io
