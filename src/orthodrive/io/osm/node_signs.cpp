// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <string_view>

#include "orthodrive/io/osm/osm_tags.hpp"
#include "orthodrive/model/roads/road_barriers.hpp"
#include "orthodrive/model/roads/traffic_calming.hpp"

namespace orthodrive::io {
namespace {

/// crossing:markings counts first: it says what is painted, the older values of crossing say it in part.
NodeSignKind crossing_kind(const OsmTags& tags) {
  const std::string crossing = tag_value(tags, "crossing"), markings = tag_value(tags, "crossing:markings");
  if (crossing == "traffic_signals" || tag_value(tags, "crossing:signals") == "yes")
    return NodeSignKind::signal_crossing;
  if (!markings.empty()) return markings == "no" ? NodeSignKind::plain_crossing : NodeSignKind::zebra;
  const bool marked = crossing == "zebra" || crossing == "marked" || crossing == "uncontrolled";
  return marked || tag_value(tags, "crossing_ref") == "zebra" ? NodeSignKind::zebra : NodeSignKind::plain_crossing;
}

double tagged_diameter_m(const OsmTags& tags) {
  for (const char* key : {"diameter", "width"})
    if (const double size_m = parse_width_m(tag_value(tags, key)); size_m > 0.0) return size_m;
  return 0.0;
}

/// Whether cars are kept out: the most special tag of access that there is, else what such barriers are for.
bool is_closed(const OsmTags& tags, const std::string& barrier) {
  for (const char* key : {"motorcar", "motor_vehicle", "vehicle", "access"}) {
    const std::string& access = tag_value(tags, key);
    if (access == "no") return true;
    if (!access.empty()) return tag_value(tags, "locked") == "yes";
  }
  return road_barrier(barrier).closes || tag_value(tags, "locked") == "yes";
}

void add_built_things(std::int64_t osm_node, const OsmTags& tags, std::vector<NodeSign>& signs) {
  if (tag_value(tags, "highway") == "mini_roundabout") {
    const std::string& turn = tag_value(tags, "direction");
    const bool left = turn == "anticlockwise" || turn == "anti_clockwise" || turn == "counterclockwise";
    signs.push_back({.osm_node = osm_node,
                     .kind = NodeSignKind::mini_roundabout,
                     .value = left                  ? "anticlockwise"
                              : turn == "clockwise" ? turn
                                                    : "",
                     .size_m = tagged_diameter_m(tags)});
  }
  for (const std::string& value : calming_values(tag_value(tags, "traffic_calming")))
    if (hump_profile(value))
      signs.push_back({.osm_node = osm_node, .kind = NodeSignKind::traffic_calming, .value = value});
  const std::string& barrier = tag_value(tags, "barrier");
  if (!barrier.empty() && barrier != "no" && barrier != "kerb" && barrier != "entrance")
    signs.push_back(
        {.osm_node = osm_node, .kind = NodeSignKind::barrier, .value = barrier, .closed = is_closed(tags, barrier)});
}

}  // namespace

std::vector<NodeSign> node_signs(std::int64_t osm_node, const OsmTags& tags) {
  const std::string highway = tag_value(tags, "highway"), crossing = tag_value(tags, "crossing");
  std::string towards = tag_value(tags, "direction");
  if (highway == "traffic_signals" && !tag_value(tags, "traffic_signals:direction").empty())
    towards = tag_value(tags, "traffic_signals:direction");
  const int direction = towards == "forward" ? 1 : towards == "backward" ? -1 : 0;
  std::vector<NodeSign> signs;
  for (const NodeSignKind kind : {NodeSignKind::stop, NodeSignKind::give_way, NodeSignKind::traffic_signals})
    if (highway == to_string(kind)) signs.push_back({osm_node, kind, direction});
  if (highway == "crossing" || (!crossing.empty() && crossing != "no"))
    signs.push_back({osm_node, crossing_kind(tags), 0});
  add_built_things(osm_node, tags, signs);
  return signs;
}

}  // namespace orthodrive::io
