// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "roadquery/map/road_map.hpp"
#include "roadquery/opendrive/note_list.hpp"

namespace roadquery {

/// Moves all of the map by its header's <offset> (1.5 and later): turned by hdg about the file's origin, then moved by
/// x, y, z; back again for `subtract`. Junctions' own surfaces, whose grids have the axes of the file, do not survive a
/// turn: a note says so.
void apply_header_offset(RoadMap& map, HeaderOffset how, NoteList& notes);

}  // namespace roadquery
