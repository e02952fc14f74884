// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/io/osm/osm_structure_tags.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>
#include <span>
#include <string_view>

#include "orthodrive/core/printable.hpp"

namespace orthodrive::io {
namespace {

using Names = std::span<const std::string_view>;

constexpr std::string_view none_values[] = {"", "no", "none", "false", "0"};
/// Of tunnel: a roof over a way on the ground; a culvert is under the road, not round it.
constexpr std::string_view ground_tunnels[] = {
    "building_passage", "passage", "avalanche_protector", "covered", "culvert", "arcade", "colonnade"};
/// Of bridge: a way on the ground, or on posts a foot above it.
constexpr std::string_view ground_bridges[] = {"low_water_crossing", "boardwalk"};
/// Values and prefixes of what is not there, or not to be driven on.
constexpr std::string_view lifecycles[] = {"proposed", "planned", "construction", "disused",   "abandoned",
                                           "razed",    "removed", "demolished",   "destroyed", "dismantled",
                                           "ruined",   "ruins",   "historic",     "was"};

/// Values of Key:highway that are no roads for cars; those that are: is_drivable().
constexpr std::string_view other_highways[] = {"path",
                                               "footway",
                                               "cycleway",
                                               "pedestrian",
                                               "steps",
                                               "bridleway",
                                               "corridor",
                                               "elevator",
                                               "platform",
                                               "via_ferrata",
                                               "ladder",
                                               "bus_guideway",
                                               "escape",
                                               "rest_area",
                                               "services",
                                               "emergency_bay",
                                               "bus_stop",
                                               "crossing",
                                               "trailhead",
                                               "street_lamp",
                                               "turning_circle",
                                               "turning_loop",
                                               "toll_gantry",
                                               "speed_camera",
                                               "milestone",
                                               "stop",
                                               "give_way",
                                               "traffic_signals",
                                               "traffic_island",
                                               "no",
                                               "emergency_access_point"};

bool is_one_of_names(std::string_view value, Names names) { return std::ranges::find(names, value) != names.end(); }

bool is_given(std::string_view value) { return !is_one_of_names(value, none_values); }

/// layer=+1 is written, too.
std::optional<int> layer_number(std::string_view text) {
  if (text.starts_with('+')) text.remove_prefix(1);
  return parse_whole_number(std::string(text));
}

/// The tag that tells that a way is not there, as "highway=proposed"; empty where none does.
std::string lifecycle_tag(const OsmTags& tags) {
  const std::string_view highway = tag_value(tags, "highway");
  if (is_one_of_names(highway, lifecycles)) {
    const std::string_view becomes = tag_value(tags, std::string(highway));
    const bool is_road = !is_given(becomes) || becomes == "yes" || is_drivable(std::string(becomes));
    return is_road ? fmt::format("highway={}", highway) : "";
  }
  for (const std::string_view state : lifecycles) {
    const std::string prefixed = fmt::format("{}:highway", state);
    if (highway.empty() && is_drivable(std::string(tag_value(tags, prefixed))))
      return fmt::format("{}={}", prefixed, tag_value(tags, prefixed));
    if (state == "historic") continue;  // historic=yes is told of roads that are old
    // construction=minor and the like: men at work on a road that is open.
    if (is_drivable(std::string(highway)) && tag_value(tags, std::string(state)) == "yes")
      return fmt::format("{}=yes", state);
    if (is_drivable(std::string(highway)) && tag_value(tags, "bridge") == state) return fmt::format("bridge={}", state);
    if (is_drivable(std::string(highway)) && tag_value(tags, "tunnel") == state) return fmt::format("tunnel={}", state);
  }
  return {};
}

/// The tag that puts a way onto a level of a building; empty where none does.
std::string level_tag(const OsmTags& tags, const RoadPath& path) {
  const std::string_view level = tag_value(tags, "level"), indoor = tag_value(tags, "indoor"),
                         layer = tag_value(tags, "layer");
  const bool is_above = is_given(level) && level != "0.0" && level != "+0", has_layer = is_given(layer);
  const bool is_indoor = is_given(indoor) || tag_value(tags, "location") == "indoor" ||
                         tag_value(tags, "parking") == "multi-storey" || tag_value(tags, "parking") == "underground";
  const bool is_structure = path.bridge || path.tunnel, is_aisle = tag_value(tags, "service") == "parking_aisle";
  if (is_above && (is_indoor || is_aisle || !is_structure)) return fmt::format("level={}", level);
  if (has_layer && (is_indoor || (is_aisle && is_structure))) return fmt::format("layer={}", layer);
  return {};
}

}  // namespace

bool has_road_tags(const osmium::TagList& tags) {
  return std::any_of(tags.begin(), tags.end(), [](const osmium::Tag& tag) {
    const std::string_view key = tag.key();
    if (key == "highway") return true;
    const std::size_t colon = key.find(':');
    return colon != key.npos && key.substr(colon) == ":highway" && is_one_of_names(key.substr(0, colon), lifecycles);
  });
}

void read_structure_tags(const OsmTags& tags, WayAttributes& way) {
  RoadPath& path = way.path;
  const std::string_view bridge = tag_value(tags, "bridge"), tunnel = tag_value(tags, "tunnel"),
                         layer = tag_value(tags, "layer");
  path.bridge = is_given(bridge) && !is_one_of_names(bridge, ground_bridges);
  path.tunnel = is_given(tunnel) && !is_one_of_names(tunnel, ground_tunnels);
  path.layer = layer_number(layer).value_or(path.bridge ? 1 : path.tunnel ? -1 : 0);
  const bool is_under_roof = is_one_of_names(tunnel, ground_tunnels) && !tunnel.empty();
  if (is_under_roof && !path.bridge) path.layer = std::max(path.layer, 0);  // a layer below 0 only sorts what is drawn
  if (is_given(layer) && !layer_number(layer))
    way.doubts.push_back(
        fmt::format("layer={} is no whole number, took {}", printable(std::string(layer)), path.layer));

  if (const std::string tag = lifecycle_tag(tags); !tag.empty())
    way.omitted = {Severity::info, "osm.not_built",
                   fmt::format("{}: planned, under construction, disused or gone, it is left out", printable(tag))};
  else if (tag_value(tags, "area") == "yes" && is_drivable(path.highway))
    way.omitted = {
        Severity::info, "osm.road_area",
        "area=yes: its outline is no centre line, it is left out; draw a way along its middle to drive on it"};
  else if (const std::string on = level_tag(tags, path); !on.empty() && is_drivable(path.highway))
    way.omitted = {
        Severity::warning, "osm.indoor_level",
        fmt::format("{}: a level of a building, whose height no terrain tells; it is left out", printable(on))};
  else if (!path.highway.empty() && !is_drivable(path.highway) && !is_one_of_names(path.highway, lifecycles) &&
           !is_one_of_names(path.highway, other_highways))
    way.omitted = {
        Severity::warning, "osm.highway_not_known",
        fmt::format("highway={} is no value of Key:highway, it is left out; if one drives there, correct the "
                    "map",
                    printable(path.highway))};
}

}  // namespace orthodrive::io
