// SPDX-License-Identifier: Apache-2.0
#pragma once
// How wide a road and each of its lanes is, by its tags. https://wiki.openstreetmap.org/wiki/Key:width, Lanes.

#include "orthodrive/io/osm/osm_tags.hpp"

namespace orthodrive::io {

/// Fills the widths of lanes by width:lanes and its directions, cycle lanes among them. A width that cannot be read is
/// a doubt and counts as not told.
void read_lane_widths(const OsmTags& tags, WayAttributes& way);

/// Once the lanes are known: takes width:forward and width:backward for the lanes of a direction of which no list
/// tells, in equal parts.
void spread_direction_widths(const OsmTags& tags, WayAttributes& way);

/// Width of the carriageway in m, and whether tags tell all of it.
struct TaggedWidth {
  double width_m = 0.0;  ///< 0: not told
  bool of_all = true;    ///< false: lanes whose width is not told count as those of the class
};
/// By the first that tells: width:carriageway, width, est_width, both directions, the lanes one by one.
[[nodiscard]] TaggedWidth tagged_width(const OsmTags& tags, WayAttributes& way);

}  // namespace orthodrive::io
