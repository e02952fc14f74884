// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "roadquery/map/road_map.hpp"
#include "roadquery/opendrive/note_list.hpp"

namespace roadquery {

/// A link to what the map does not have: whoever drives there gets no further. Or one to what does not lie behind it.
struct BrokenLink {
  enum class Kind : std::uint8_t {
    road,        ///< of a road to a road that is not there
    junction,    ///< of a road to a junction that is not there
    connection,  ///< of a junction's connection to a road that is not there
    lane,        ///< of a lane or a connection to a lane that is not there
    apart,       ///< of roads whose reference lines do not meet at their contact point
    against,     ///< of a connection onto a lane against its direction
    beside,      ///< of lanes that lie beside each other
    level,       ///< of level lanes to ones that are not
  };
  Kind kind = Kind::road;
  NotePlace where;
  bool bears = true;  ///< on what a car drives on
};

/// By road, then by junction, in their order; along s in each. The map's roads need not be in order.
[[nodiscard]] std::vector<BrokenLink> broken_links(const RoadMap& map);

/// Notes those that lead nowhere ("opendrive.broken_link"), those to what does not lie behind them or leads the other
/// way ("opendrive.wrong_link"), and level lanes that go on as ones that are not ("opendrive.level"). The map stays as
/// it is.
void note_broken_links(const RoadMap& map, NoteList& notes);

}  // namespace roadquery
