// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "roadquery/opendrive/finish_road.hpp"

namespace roadquery {

/// Gives lanes with borders their widths: from the border of the lane inside, or from the lane offset. Lanes with
/// widths keep them (1.7, 11.6.2). The borders' sections are those of the road, in the order of the file.
void widths_from_borders(Road& road, const std::vector<RoadParts::Border>& borders, NoteList& notes);

}  // namespace roadquery
