// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "roadquery/opendrive/finish_road.hpp"

namespace roadquery {

/// Gives lanes those whom their <access> allows. Driving lanes that it leaves no passenger car in become lanes of
/// another type: `bus`, `taxi` or `biking` where those alone may use them, else `other`. What holds along the longest
/// part of the section counts for all of it; a note says where that is not all. Sections are in the order of the file.
void read_lane_access(Road& road, const std::vector<RoadParts::Access>& accesses, NoteList& notes);

}  // namespace roadquery
