// SPDX-License-Identifier: Apache-2.0
#pragma once
// Who may use a road, each of its lanes and the lanes at its sides. https://wiki.openstreetmap.org/wiki/Lanes,
// Key:access, Key:busway, Key:cycleway, Bus_lanes.

#include <string>
#include <string_view>
#include <vector>

#include "orthodrive/io/osm/osm_tags.hpp"

namespace orthodrive::io {

/// Parts of a list "left|through|right", without blanks around them; none of an empty text.
[[nodiscard]] std::vector<std::string> lane_list(const std::string& text);
[[nodiscard]] std::string joined_lanes(const std::vector<std::string>& lanes);

/// The value of a tag of lanes for one direction of the path, without blanks beside "|" and ";": KEY:forward or
/// KEY:backward, of one-way roads KEY for the direction of traffic.
[[nodiscard]] std::string lane_value(const OsmTags& tags, const WayAttributes& way, const std::string& key,
                                     bool forward);

/// The word of RoadPath::use: who may drive on the road, empty for cars, too. Raceways are open to their cars.
[[nodiscard]] std::string road_use(const OsmTags& tags, const std::string& highway);

/// The words of RoadPath::use_forward or use_backward, cycle lanes among them. Lists of different length are left out
/// with a doubt.
[[nodiscard]] std::vector<std::string> lane_uses(const OsmTags& tags, WayAttributes& way, bool forward);

/// Who may use the lanes against a one-way road: a word, "none" where no tag tells.
[[nodiscard]] std::string counter_use(const OsmTags& tags);

/// Fills side_lanes by cycleway, busway, lanes:bus, lanes:psv and lanes:taxi. A bus lane against a one-way road becomes
/// a lane of the other direction.
void read_side_lanes(const OsmTags& tags, WayAttributes& way);

/// Adds a word to side_lanes, once.
void add_side_lane(RoadPath& path, std::string_view word);

/// Fills placement, once the lanes are known.
void read_placement(const OsmTags& tags, WayAttributes& way);

}  // namespace orthodrive::io
