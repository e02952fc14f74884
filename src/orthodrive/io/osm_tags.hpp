#pragma once
// What the tags of a road say, as numbers. https://wiki.openstreetmap.org/wiki/Key:width and neighbours.

#include <map>
#include <string>
#include <vector>

#include "orthodrive/model/road_network.hpp"

namespace orthodrive::io {

using OsmTags = std::map<std::string, std::string>;

/// Metres from "3.5", "3.5 m", "3,5", "12'6\"", "11 ft"; 0 when it cannot be read or is not positive.
[[nodiscard]] double parse_width_m(const std::string& text);

/// The attributes of a way (osm_id, part and nodes stay empty). `reversed` when oneway=-1 turns its nodes round.
struct WayAttributes {
  RoadPath path;
  bool reversed = false;
  double width_m = 0.0;  ///< tag, else default_width_m
  std::vector<std::string> odd;  ///< tags that say no number, as "width=wide"; they count as absent
};
[[nodiscard]] WayAttributes way_attributes(const OsmTags& tags);

}  // namespace orthodrive::io
