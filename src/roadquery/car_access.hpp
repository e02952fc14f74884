// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "roadquery/finish_road.hpp"

namespace roadquery {

/// Driving lanes whose <access> leaves no passenger car in become lanes of the type `other`. What holds along the
/// longest part of the section counts for all of it; a note says where that is not all. Sections are in the order of
/// the file.
void close_lanes_to_cars(Road& road, const std::vector<RoadParts::Access>& accesses, NoteList& notes);

}  // namespace roadquery
