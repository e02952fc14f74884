// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "roadquery/map/road_map.hpp"
#include "roadquery/opendrive/note_list.hpp"

namespace roadquery {

/// A lane with level="true" and those outside of it (1.7, 11.6: neither superelevation nor crossfall apply) lie across
/// as high as the inner border of the first of them: heights of the lanes that take away what the cross section has.
/// To 0.1 mm. The road's lists are in order.
/// Lanes outside of it that are not level themselves are noted ("opendrive.level").
void keep_level_lanes(Road& road, NoteList& notes);

}  // namespace roadquery
