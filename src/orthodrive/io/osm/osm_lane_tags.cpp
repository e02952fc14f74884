// SPDX-License-Identifier: Apache-2.0
// What the tags of a road say about its lanes. https://wiki.openstreetmap.org/wiki/Lanes, Key:turn, Key:sidewalk,
// Key:shoulder, Key:maxspeed.

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <string_view>
#include <utility>

#include "orthodrive/io/osm/osm_tags.hpp"

namespace orthodrive::io {
namespace {
constexpr double mile_km = 1.609344;
constexpr double no_limit_kmh = 130.0;
constexpr double walk_kmh = 7.0;  // what courts take "Schrittgeschwindigkeit" for
constexpr int max_lanes = 16;     // more is a slip of the keyboard

std::string value_of(const OsmTags& tags, const char* key) {
  const auto it = tags.find(key);
  return it == tags.end() ? std::string() : it->second;
}

/// Speeds that a country's law gives a kind of place: "CZ:urban". The entry without a country holds for all others.
struct ZoneSpeed {
  std::string_view country, zone;
  double kmh;
};
constexpr ZoneSpeed zone_speeds[] = {{"CZ", "living_street", 20.0},
                                     {"DE", "living_street", walk_kmh},
                                     {"AT", "living_street", 5.0},
                                     {"SE", "living_street", walk_kmh},
                                     {"", "living_street", 20.0},
                                     {"GB", "nsl_single", 60.0 * mile_km},
                                     {"GB", "nsl_dual", 70.0 * mile_km},
                                     {"GB", "nsl_restricted", 30.0 * mile_km},
                                     {"GB", "motorway", 70.0 * mile_km},
                                     {"CZ", "motorway", 130.0},
                                     {"SE", "motorway", 110.0},
                                     {"", "motorway", 130.0},
                                     {"CZ", "trunk", 110.0},
                                     {"", "trunk", 100.0},
                                     {"DE", "rural", 100.0},
                                     {"AT", "rural", 100.0},
                                     {"SE", "rural", 70.0},
                                     {"FR", "rural", 80.0},
                                     {"", "rural", 90.0},
                                     {"", "urban", 50.0},
                                     {"", "bicycle_road", 30.0},
                                     {"", "walk", walk_kmh}};

double zone_speed_kmh(std::string_view country, std::string_view zone) {
  if (zone.starts_with("zone")) {  // zone30, zone:30
    zone.remove_prefix(4);
    if (zone.starts_with(':')) zone.remove_prefix(1);
    return parse_speed_kmh(std::string(zone));
  }
  for (const std::string_view wanted : {country, std::string_view()})
    for (const ZoneSpeed& entry : zone_speeds)
      if (entry.country == wanted && entry.zone == zone) return entry.kmh;
  return 0.0;
}

/// A number of lanes; 0 for none, with a doubt when it cannot be read.
int lane_count(const OsmTags& tags, const char* key, WayAttributes& way) {
  const std::string text = value_of(tags, key);
  int value = 0;
  const auto [end, failed] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (!text.empty() && (failed != std::errc() || end != text.data() + text.size() || value < 0 || value > max_lanes)) {
    way.doubts.push_back(fmt::format("{}={} is no number of lanes, left out", key, text));
    return 0;
  }
  return value;
}

Sides sides_of(const OsmTags& tags, const std::string& key) {
  const auto yes = [](const std::string& value) { return value == "yes" || value == "both"; };
  const std::string all = value_of(tags, key.c_str());
  const bool both = yes(all) || yes(value_of(tags, (key + ":both").c_str()));
  const bool left = both || all == "left" || yes(value_of(tags, (key + ":left").c_str()));
  const bool right = both || all == "right" || yes(value_of(tags, (key + ":right").c_str()));
  return static_cast<Sides>((left ? 1 : 0) + (right ? 2 : 0));
}

Sides mirrored(Sides sides) {
  return sides == Sides::left ? Sides::right : sides == Sides::right ? Sides::left : sides;
}

std::size_t lanes_in(const std::string& turn_lanes) {
  return turn_lanes.empty() ? 0 : static_cast<std::size_t>(std::count(turn_lanes.begin(), turn_lanes.end(), '|')) + 1;
}

/// One number of lanes a direction, where the tags say two.
void settle_lanes(WayAttributes& way) {
  RoadPath& path = way.path;
  if (path.oneway == Oneway::forward) {
    if (path.lanes_backward > 0) {
      way.doubts.push_back(fmt::format("oneway and lanes:backward={}, took no lane against it", path.lanes_backward));
      path.lanes_backward = 0;
    }
    if (path.lanes == 0) path.lanes = path.lanes_forward;
    path.lanes_forward = path.lanes;
    return;
  }
  const int sum = path.lanes_forward + path.lanes_backward;
  if (path.lanes_forward > 0 && path.lanes_backward > 0) {
    if (path.lanes > 0 && path.lanes != sum)
      way.doubts.push_back(
          fmt::format("lanes={} but lanes:forward + lanes:backward = {}, took the sum", path.lanes, sum));
    path.lanes = sum;
  } else if (sum > 0 && path.lanes > sum) {  // one of both is told: the rest is the other one
    (path.lanes_forward == 0 ? path.lanes_forward : path.lanes_backward) = path.lanes - sum;
  } else if (sum > 0 && path.lanes > 0) {
    way.doubts.push_back(
        fmt::format("lanes={} but {} of one direction alone, took one lane for the other", path.lanes, sum));
    (path.lanes_forward == 0 ? path.lanes_forward : path.lanes_backward) = 1;
    path.lanes = sum + 1;
  }
}

void settle_turns(std::string& turns, int lanes, const char* direction, WayAttributes& way) {
  if (turns.empty() || lanes == 0 || lanes_in(turns) == static_cast<std::size_t>(lanes)) return;
  way.doubts.push_back(fmt::format("turn:lanes tells {} lanes {}, but there are {}; its arrows are left out",
                                   lanes_in(turns), direction, lanes));
  turns.clear();
}
}  // namespace

double parse_speed_kmh(const std::string& text) {
  if (text == "none") return no_limit_kmh;
  if (text == "walk") return walk_kmh;
  if (const auto colon = text.find(':'); colon != std::string::npos)
    return zone_speed_kmh(std::string_view(text).substr(0, colon), std::string_view(text).substr(colon + 1));
  double value = 0.0;
  const char* end = text.data() + text.size();
  auto [rest, failed] = std::from_chars(text.data(), end, value);
  if (failed != std::errc() || !(value > 0.0 && value < 500.0)) return 0.0;
  while (rest != end && *rest == ' ') ++rest;
  const std::string_view unit(rest, static_cast<std::size_t>(end - rest));
  if (unit.empty() || unit == "km/h" || unit == "kmh") return value;
  if (unit == "mph") return value * mile_km;
  if (unit == "knots") return value * 1.852;
  return 0.0;
}

void read_lane_tags(const OsmTags& tags, WayAttributes& way) {
  RoadPath& path = way.path;
  if (path.lanes > max_lanes) {
    way.doubts.push_back(fmt::format("lanes={} cannot be, left out", path.lanes));
    path.lanes = 0;
  }
  path.lanes_forward = lane_count(tags, "lanes:forward", way);
  path.lanes_backward = lane_count(tags, "lanes:backward", way);
  path.turn_forward = value_of(tags, "turn:lanes:forward");
  path.turn_backward = value_of(tags, "turn:lanes:backward");
  path.sidewalk = sides_of(tags, "sidewalk");
  path.shoulder = sides_of(tags, "shoulder");
  path.surface = value_of(tags, "surface");
  path.known_surface = surface_of_tags(path.highway, path.surface, value_of(tags, "tracktype"));
  if (!path.surface.empty() && path.known_surface.source != SurfaceSource::tag)
    way.doubts.push_back(fmt::format("surface={} is not known, took {}", path.surface,
                                     roadquery::to_string(path.known_surface.surface)));
  if (way.reversed) {
    std::swap(path.lanes_forward, path.lanes_backward);
    std::swap(path.turn_forward, path.turn_backward);
    path.sidewalk = mirrored(path.sidewalk), path.shoulder = mirrored(path.shoulder);
  }
  if (path.oneway == Oneway::forward && path.turn_forward.empty()) path.turn_forward = value_of(tags, "turn:lanes");
  if (path.oneway == Oneway::forward) path.turn_backward.clear();

  settle_lanes(way);
  if (path.lanes == 0 && path.oneway == Oneway::forward)
    path.lanes = path.lanes_forward = static_cast<int>(lanes_in(path.turn_forward));
  if (path.lanes_forward == 0) path.lanes_forward = static_cast<int>(lanes_in(path.turn_forward));
  if (path.lanes_backward == 0) path.lanes_backward = static_cast<int>(lanes_in(path.turn_backward));
  settle_turns(path.turn_forward, path.lanes_forward, "forward", way);
  settle_turns(path.turn_backward, path.lanes_backward, "backward", way);

  for (const char* key : {"maxspeed", "maxspeed:type", "source:maxspeed"}) {
    const std::string text = value_of(tags, key);
    path.speed_limit_kmh = parse_speed_kmh(text);
    if (path.speed_limit_kmh > 0.0) break;
    const bool says_no_speed = text == "signals" || text == "variable" || text == "sign";
    if (!text.empty() && !says_no_speed && key == std::string_view("maxspeed"))
      way.doubts.push_back(
          fmt::format("maxspeed={} is no speed, took {:.0f} km/h", text, default_speed_limit_kmh(path.highway)));
  }
}

}  // namespace orthodrive::io
