// SPDX-License-Identifier: Apache-2.0
#pragma once
// How far the elements of a road go: those that begin late, have no length or do not fit the road's length.

#include "roadquery/map/road_map.hpp"
#include "roadquery/opendrive/note_list.hpp"

namespace roadquery {

/// For a road whose elements are sorted:
/// - the first <elevation>, <laneSection> and <width> of a lane hold from the start on ("opendrive.begins_late"); other
///   readers go on with the first polynomial, too, where the standard leaves nothing;
/// - <geometry> and <laneSection> elements without length (1 mm of a section) are left out, and what links to lanes of
///   such a section links through it ("opendrive.no_length");
/// - <geometry> elements that are not as long as the road, or do not follow each other along s, stay as they are
///   ("opendrive.road_length");
/// - lanes without <width> ("opendrive.no_width") and narrower than nothing ("opendrive.negative_width") stay, too.
void fit_to_road(Road& road, NoteList& notes);

}  // namespace roadquery
