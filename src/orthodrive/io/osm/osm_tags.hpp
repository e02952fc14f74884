// SPDX-License-Identifier: Apache-2.0
#pragma once
// What the tags of a road say, as numbers. https://wiki.openstreetmap.org/wiki/Key:width and neighbours.

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "orthodrive/core/finding.hpp"
#include "orthodrive/model/roads/road_network.hpp"

namespace orthodrive::io {

using OsmTags = std::map<std::string, std::string>;

/// The value of a tag; empty where there is none. It lives as long as the tags.
[[nodiscard]] const std::string& tag_value(const OsmTags& tags, const std::string& key);

/// The whole number that a text is, without a sign or with a minus; none where anything else stands in it.
[[nodiscard]] std::optional<int> parse_whole_number(const std::string& text);

/// Why a way with the tags of a road is left out.
struct OmittedWay {
  Severity severity = Severity::info;
  const char* code = "";
  std::string why;
};

/// Metres from "3.5", "3.5 m", "3,5", "12'6\"", "11 ft", "11 ft 6 in"; 0 when it cannot be read or is not positive.
[[nodiscard]] double parse_width_m(const std::string& text);

/// km/h from maxspeed's "50", "30 mph", "none" (130, the usual advice); 0 when it is no number. Cases of the law
/// ("CZ:urban", "walk"): is_speed_context(). https://wiki.openstreetmap.org/wiki/Key:maxspeed.
[[nodiscard]] double parse_speed_kmh(const std::string& text);

/// The attributes of a way (osm_id, part and nodes stay empty). `reversed` when oneway=-1 turns its nodes round.
struct WayAttributes {
  RoadPath path;
  std::optional<OmittedWay> omitted;  ///< the way is no road that one drives on today, or none that can be built
  bool reversed = false;
  double width_m = 0.0;          ///< tag, else default_width_m
  std::vector<std::string> odd;  ///< tags that say no number, as "width=wide"; they count as absent
  std::vector<std::string>
      doubts;  ///< tags of lanes and speed that contradict each other or cannot be read: what was assumed
  std::vector<std::pair<std::string, std::string>> unread;  ///< tags that tag_rules() lists as not read, and why
};
[[nodiscard]] WayAttributes way_attributes(const OsmTags& tags);

/// Lanes, turn lanes, speed limit, sidewalks, shoulders and surface of a way whose oneway and lanes are known already;
/// sides and directions are turned round with the way. Part of way_attributes.
void read_lane_tags(const OsmTags& tags, WayAttributes& way);

/// What a node's tags say about who waits there and who walks across (highway=stop, give_way, traffic_signals,
/// crossing; crossing, crossing:markings, crossing_ref; direction; https://wiki.openstreetmap.org/wiki/Key:crossing),
/// and what is built there: highway=mini_roundabout, humps of traffic_calming, barrier with the tags of access.
[[nodiscard]] std::vector<NodeSign> node_signs(std::int64_t osm_node, const OsmTags& tags);

}  // namespace orthodrive::io
