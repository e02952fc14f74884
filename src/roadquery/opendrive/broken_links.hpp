// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "roadquery/map/road_map.hpp"
#include "roadquery/opendrive/note_list.hpp"

namespace roadquery {

/// A link to what the map does not have: whoever drives there gets no further.
struct BrokenLink {
  enum class Kind : std::uint8_t {
    road,        ///< of a road to a road
    junction,    ///< of a road to a junction
    connection,  ///< of a junction's connection to a road
    lane,        ///< of a lane or a connection to a lane
  };
  Kind kind = Kind::road;
  NotePlace where;
};

/// By road, then by junction, in their order; along s in each. The map's roads need not be in order.
[[nodiscard]] std::vector<BrokenLink> broken_links(const RoadMap& map);

/// Notes them ("opendrive.broken_link"). The map stays as it is.
void note_broken_links(const RoadMap& map, NoteList& notes);

}  // namespace roadquery
