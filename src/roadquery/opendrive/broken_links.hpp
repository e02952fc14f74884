// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "roadquery/map/road_map.hpp"
#include "roadquery/opendrive/note_list.hpp"

namespace roadquery {

/// Notes links of roads, connections and lanes to what the map does not have ("opendrive.broken_link"): whoever drives
/// there gets no further. The map stays as it is. Its roads need not be in order.
void note_broken_links(const RoadMap& map, NoteList& notes);

}  // namespace roadquery
