// SPDX-License-Identifier: Apache-2.0
// What the tags of a road say about its lanes. https://wiki.openstreetmap.org/wiki/Lanes, Forward_&_backward, Key:turn,
// Key:sidewalk, Key:shoulder, Key:maxspeed. Which tags are read: tag_rules.

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <string_view>
#include <utility>

#include "orthodrive/io/osm/lane_use.hpp"
#include "orthodrive/io/osm/lane_widths.hpp"
#include "orthodrive/io/osm/osm_tags.hpp"
#include "orthodrive/model/roads/highway_class.hpp"
#include "orthodrive/model/roads/speed_laws.hpp"

namespace orthodrive::io {
namespace {
constexpr double mile_km = 1.609344;
constexpr double no_limit_kmh = 130.0;
constexpr int max_lanes = 16;  // more is a slip of the keyboard

/// A number of lanes; 0 for none, with a doubt when it cannot be read.
int lane_count(const OsmTags& tags, const char* key, WayAttributes& way) {
  const std::string text = tag_value(tags, key);
  const int value = parse_whole_number(text).value_or(text.empty() ? 0 : -1);
  if (value < 0 || value > max_lanes) {
    way.doubts.push_back(fmt::format("{}={} is no number of lanes, left out", key, text));
    return 0;
  }
  return value;
}

Sides sides_of(const OsmTags& tags, const std::string& key) {
  const auto yes = [](const std::string& value) { return value == "yes" || value == "both"; };
  const std::string all = tag_value(tags, key);
  const bool both = yes(all) || yes(tag_value(tags, key + ":both"));
  const bool left = both || all == "left" || yes(tag_value(tags, key + ":left"));
  const bool right = both || all == "right" || yes(tag_value(tags, key + ":right"));
  return static_cast<Sides>((left ? 1 : 0) + (right ? 2 : 0));
}

Sides mirrored(Sides sides) {
  return sides == Sides::left ? Sides::right : sides == Sides::right ? Sides::left : sides;
}

std::size_t lanes_in(const std::string& list) { return lane_list(list).size(); }

/// Of a one-way road: lanes against it are none for cars.
void settle_one_way(const OsmTags& tags, WayAttributes& way) {
  RoadPath& path = way.path;
  path.lanes_both_ways = 0;
  if (path.lanes_backward == 0) {
    if (path.lanes == 0) path.lanes = path.lanes_forward;
    path.lanes_forward = path.lanes;
    return;
  }
  const int against = path.lanes_backward;
  if (path.lanes_forward == 0) path.lanes_forward = std::max(1, path.lanes - against);
  if (path.lanes > 0 && path.lanes != path.lanes_forward + against)
    way.doubts.push_back(fmt::format("lanes={} but lanes:forward + lanes:backward = {}, took the sum", path.lanes,
                                     path.lanes_forward + against));
  path.lanes = path.lanes_forward + against;
  if (!path.use_backward.empty()) return;
  const std::string use = counter_use(tags);
  if (use == "bicycle") {  // no lane of the carriageway's vehicles
    add_side_lane(path, "bicycle:against");
    path.lanes -= against, path.lanes_backward = 0;
    return;
  }
  if (use == "none")
    way.doubts.push_back(
        fmt::format("oneway and lanes:backward={} but no tag tells who may use it, took it as closed", against));
  path.use_backward = joined_lanes(std::vector<std::string>(static_cast<std::size_t>(against), use));
}

/// One number of lanes for each direction, where the tags say two.
void settle_two_way(WayAttributes& way) {
  RoadPath& path = way.path;
  const int both = path.lanes_both_ways, sum = path.lanes_forward + path.lanes_backward;
  if (path.lanes_forward > 0 && path.lanes_backward > 0) {
    if (path.lanes > 0 && path.lanes != sum + both)
      way.doubts.push_back(fmt::format("lanes={} but lanes:forward + lanes:backward{} = {}, took the sum", path.lanes,
                                       both > 0 ? " + lanes:both_ways" : "", sum + both));
    path.lanes = sum + both;
  } else if (sum > 0 && path.lanes > sum + both) {  // one of both is told: the rest is the other one
    (path.lanes_forward == 0 ? path.lanes_forward : path.lanes_backward) = path.lanes - sum - both;
  } else if (sum > 0 && (path.lanes > 0 || both > 0)) {
    if (path.lanes > 0)
      way.doubts.push_back(
          fmt::format("lanes={} but {} of one direction alone, took one lane for the other", path.lanes, sum + both));
    (path.lanes_forward == 0 ? path.lanes_forward : path.lanes_backward) = 1;
    path.lanes = sum + 1 + both;
  } else if (both > 0 && path.lanes <= both) {  // no number of the others: one each, or lanes for both alone
    if (path.lanes == 0) path.lanes_forward = path.lanes_backward = 1, path.lanes = 2 + both;
  } else if (both > 0) {
    path.lanes_backward = std::max(1, (path.lanes - both) / 2);
    path.lanes_forward = std::max(1, path.lanes - both - path.lanes_backward);
    path.lanes = path.lanes_forward + path.lanes_backward + both;
  }
}

void settle_list(std::string& list, int lanes, const char* key, const char* direction, const char* what,
                 WayAttributes& way) {
  if (list.empty() || lanes == 0 || lanes_in(list) == static_cast<std::size_t>(lanes)) return;
  way.doubts.push_back(
      fmt::format("{} tells {} lanes {}, but there are {}; {}", key, lanes_in(list), direction, lanes, what));
  list.clear();
}

/// Cycle lanes of lists: `lanes` does not count them. At the edge of a direction's lanes they are lanes at the side.
void take_out_cycle_lanes(WayAttributes& way, bool forward, std::vector<std::string>& uses) {
  RoadPath& path = way.path;
  std::vector<std::string> turns = lane_list(forward ? path.turn_forward : path.turn_backward),
                           speeds = lane_list(forward ? path.speeds_forward : path.speeds_backward),
                           widths = lane_list(forward ? path.widths_forward : path.widths_backward);
  const std::size_t count = uses.size();
  const bool alone = std::ranges::all_of(uses, [](const std::string& use) { return use == "bicycle"; });
  for (std::size_t i = count; i-- > 0;) {
    if (uses[i] != "bicycle") continue;
    const bool first = i == 0, last = i + 1 == count;
    if (alone)
      add_side_lane(path, forward ? "bicycle:along" : "bicycle:against");
    else if (first || last)
      add_side_lane(path, last == forward ? "bicycle:right" : "bicycle:left");
    else
      way.doubts.push_back("a cycle lane between two lanes is not built, they lie side by side");
    const auto at = static_cast<std::ptrdiff_t>(i);
    if (turns.size() == uses.size()) turns.erase(turns.begin() + at);
    if (speeds.size() == uses.size() && speeds.size() > 1) speeds.erase(speeds.begin() + at);
    if (widths.size() == uses.size()) widths.erase(widths.begin() + at);
    uses.erase(uses.begin() + at);
  }
  (forward ? path.turn_forward : path.turn_backward) = joined_lanes(turns);
  (forward ? path.speeds_forward : path.speeds_backward) = joined_lanes(speeds);
  (forward ? path.widths_forward : path.widths_backward) = joined_lanes(widths);
  int& lanes = forward ? path.lanes_forward : path.lanes_backward;
  if (alone && count > 0 && lanes > 0 && static_cast<std::size_t>(lanes) == count) {  // counted all the same
    if (path.lanes > lanes) path.lanes -= lanes;
    lanes = 0;
  }
}

/// Who may use the lanes of each direction; numbers of lanes that only lists tell.
void read_uses(const OsmTags& tags, WayAttributes& way) {
  RoadPath& path = way.path;
  path.use = road_use(tags, path.highway);
  for (const bool forward : {true, false}) {
    std::vector<std::string> uses = lane_uses(tags, way, forward);
    if (uses.empty()) continue;
    take_out_cycle_lanes(way, forward, uses);
    const bool all_for_cars = std::ranges::all_of(uses, [](const std::string& use) { return use.empty(); });
    int& lanes = forward ? path.lanes_forward : path.lanes_backward;
    if (lanes == 0 && !all_for_cars) lanes = static_cast<int>(uses.size());
    if (!all_for_cars) (forward ? path.use_forward : path.use_backward) = joined_lanes(uses);
  }
  if (path.oneway == Oneway::forward && path.lanes == 0) path.lanes = path.lanes_forward + path.lanes_backward;
}

/// A list of one lane is no text: "" would be no list.
void settle_lists(WayAttributes& way) {
  RoadPath& path = way.path;
  constexpr const char* no_arrows = "its arrows are left out";
  settle_list(path.turn_forward, path.lanes_forward, "turn:lanes", "forward", no_arrows, way);
  settle_list(path.turn_backward, path.lanes_backward, "turn:lanes", "backward", no_arrows, way);
  constexpr const char* all_alike = "it is left out";
  settle_list(path.use_forward, path.lanes_forward, "access of lanes", "forward", all_alike, way);
  settle_list(path.use_backward, path.lanes_backward, "access of lanes", "backward", all_alike, way);
  if (lanes_in(path.speeds_forward) > 1)
    settle_list(path.speeds_forward, path.lanes_forward, "maxspeed:lanes", "forward", all_alike, way);
  if (lanes_in(path.speeds_backward) > 1)
    settle_list(path.speeds_backward, path.lanes_backward, "maxspeed:lanes", "backward", all_alike, way);
  settle_list(path.widths_forward, path.lanes_forward, "width:lanes", "forward", all_alike, way);
  settle_list(path.widths_backward, path.lanes_backward, "width:lanes", "backward", all_alike, way);
  settle_list(path.widths_both_ways, path.lanes_both_ways, "width:lanes", "for both directions", all_alike, way);
  if (shared_lanes(path) == 0 || path.widths_forward.size() + path.widths_backward.size() == 0) return;
  way.doubts.emplace_back("width:lanes tells widths of directions, but the lanes are for both; it is left out");
  path.widths_forward.clear(), path.widths_backward.clear();
}

/// Of a reversible road: numbers for each direction tell how it is driven at times, of the same lanes.
void share_all_lanes(WayAttributes& way) {
  RoadPath& path = way.path;
  const int told = path.lanes_forward + path.lanes_backward + path.lanes_both_ways;
  if (path.lanes == 0) path.lanes = std::max(1, told);
  if (told > path.lanes)
    way.doubts.push_back(
        fmt::format("lanes={} of a reversible road, but {} of its directions, took {}", path.lanes, told, path.lanes));
  path.lanes_forward = path.lanes_backward = 0;
  path.lanes_both_ways = path.lanes;
}

void read_lanes(const OsmTags& tags, WayAttributes& way) {
  RoadPath& path = way.path;
  if (path.lanes > max_lanes) {
    way.doubts.push_back(fmt::format("lanes={} cannot be, left out", path.lanes));
    path.lanes = 0;
  }
  path.lanes_forward = lane_count(tags, way.reversed ? "lanes:backward" : "lanes:forward", way);
  path.lanes_backward = lane_count(tags, way.reversed ? "lanes:forward" : "lanes:backward", way);
  path.lanes_both_ways = lane_count(tags, "lanes:both_ways", way);
  const std::string centre = tag_value(tags, "centre_turn_lane"), oneway = tag_value(tags, "oneway");
  if (path.lanes_both_ways == 0 && (centre == "yes" || !tag_value(tags, "turn:lanes:both_ways").empty()))
    path.lanes_both_ways = 1;
  if (oneway == "reversible" || oneway == "alternating") share_all_lanes(way);
  path.turn_forward = lane_value(tags, way, "turn:lanes", true);
  path.turn_backward = lane_value(tags, way, "turn:lanes", false);
}

/// Where no tag tells how many lanes a direction has, its arrows do: mappers may leave turn lanes out of `lanes`. Then
/// its widths.
void count_listed_lanes(RoadPath& path) {
  if (path.lanes_both_ways > 0 && path.lanes_both_ways == path.lanes) return;  // reversible
  for (const auto& [forward, backward] :
       {std::pair{&path.turn_forward, &path.turn_backward}, std::pair{&path.widths_forward, &path.widths_backward}}) {
    if (path.lanes_forward == 0 && shared_lanes(path) == 0) path.lanes_forward = static_cast<int>(lanes_in(*forward));
    if (path.lanes_backward == 0) path.lanes_backward = static_cast<int>(lanes_in(*backward));
  }
}

/// turn=* without lanes holds for all of them.
void spread_turns(const OsmTags& tags, WayAttributes& way, bool forward) {
  const int lanes = forward ? way.path.lanes_forward : way.path.lanes_backward;
  std::string& turns = forward ? way.path.turn_forward : way.path.turn_backward;
  const std::string turn = lane_value(tags, way, "turn", forward);
  if (!turns.empty() || turn.empty() || lanes == 0) return;
  turns = joined_lanes(std::vector<std::string>(static_cast<std::size_t>(lanes), turn));
}

/// A limit as tags say it: a number, or the name of a case of the law ("CZ:urban"); neither: they say nothing of it.
struct SaidSpeed {
  double kmh = 0.0;
  std::string context;
  [[nodiscard]] bool is_said() const { return kmh > 0.0 || !context.empty(); }
  [[nodiscard]] std::string text() const { return kmh > 0.0 ? fmt::format("{:g}", kmh) : context; }
};

SaidSpeed said_speed(const std::string& text) {
  if (const double kmh = parse_speed_kmh(text); kmh > 0.0) return {kmh, ""};
  return {0.0, is_speed_context(text) ? text : ""};
}

/// What maxspeed, zone:maxspeed, maxspeed:type or source:maxspeed says with such an ending.
SaidSpeed speed_of(const OsmTags& tags, const std::string& ending, WayAttributes& way) {
  for (const char* key : {"maxspeed", "zone:maxspeed", "maxspeed:type", "source:maxspeed"}) {
    const std::string& text = tag_value(tags, key + ending);
    if (SaidSpeed said = said_speed(text); said.is_said()) return said;
    const bool says_no_speed = text == "signals" || text == "variable" || text == "sign";
    if (!text.empty() && !says_no_speed && key == std::string_view("maxspeed"))
      way.doubts.push_back(fmt::format("maxspeed{}={} is no speed, took the limit of the law", ending, text));
  }
  return {};
}

/// Limits of a direction: lane by lane where maxspeed:lanes tells, else one of all its lanes; empty: the road's.
std::string direction_speeds(const OsmTags& tags, WayAttributes& way, bool forward) {
  std::vector<std::string> speeds;
  for (const std::string& text : lane_list(lane_value(tags, way, "maxspeed:lanes", forward))) {
    const SaidSpeed said = said_speed(text);
    if (!text.empty() && text != "variable" && text != "signals" && !said.is_said())
      way.doubts.push_back(fmt::format("maxspeed:lanes: {} is no speed, left out", text));
    speeds.push_back(said.text());
  }
  if (!speeds.empty()) return joined_lanes(speeds);
  return speed_of(tags, forward != way.reversed ? ":forward" : ":backward", way).text();
}

/// Whether the road lies in a town, as its tags say: zone:traffic, then what is built where people walk. The second is
/// what osm-legal-default-speeds takes for "urban" and "rural" too.
std::string surroundings_of(const OsmTags& tags, const std::string& highway) {
  if (const std::string& zone = tag_value(tags, "zone:traffic"); zone.ends_with("urban") || zone.ends_with("rural"))
    return zone;
  if (is_street_class(highway) || tag_value(tags, "lit") == "yes") return "urban";
  bool has_none = tag_value(tags, "lit") == "no";
  for (const char* key : {"sidewalk", "sidewalk:both", "sidewalk:left", "sidewalk:right"}) {
    const std::string& value = tag_value(tags, key);
    if (value == "yes" || value == "both" || value == "left" || value == "right" || value == "separate") return "urban";
    has_none = has_none || value == "no" || value == "none";
  }
  return has_none ? "rural" : "";
}

void read_speeds(const OsmTags& tags, WayAttributes& way) {
  RoadPath& path = way.path;
  SaidSpeed said = speed_of(tags, "", way);
  if (!said.is_said()) said = speed_of(tags, ":both", way);
  path.speed_limit_kmh = said.kmh;
  path.speed_context = said.context;
  path.speeds_forward = direction_speeds(tags, way, true);
  path.speeds_backward = direction_speeds(tags, way, false);
  if (path.speed_context.empty() && tag_value(tags, "motorroad") == "yes") path.speed_context = "motorroad";
  if (path.speed_context.empty()) path.speed_context = surroundings_of(tags, path.highway);
  if (path.speed_limit_kmh > 0.0) return;
  for (const std::string* list : {&path.speeds_forward, &path.speeds_backward})
    for (const std::string& text : lane_list(*list))
      path.speed_limit_kmh = std::max(path.speed_limit_kmh, parse_speed_kmh(text));
}

/// surface with the sides and directions that it may have. Roads are of one material: where both differ, the first.
std::string surface_value(const OsmTags& tags, WayAttributes& way) {
  std::string found;
  for (const char* key : {"surface", "surface:both", "surface:forward", "surface:backward", "surface:right",
                          "surface:left", "surface:lanes", "surface:lanes:forward", "surface:lanes:backward"}) {
    const std::string text = tag_value(tags, key);
    for (const std::string& value : lane_list(text)) {
      if (found.empty()) found = value;
      if (value == found || value.empty()) continue;
      way.doubts.push_back(fmt::format("{}={} but {} for all of the road, took that", key, text, found));
      return found;
    }
    if (!found.empty() && key == std::string_view("surface")) break;
  }
  return found;
}
}  // namespace

double parse_speed_kmh(const std::string& text) {
  if (text == "none") return no_limit_kmh;
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
  read_lanes(tags, way);
  path.sidewalk = sides_of(tags, "sidewalk");
  path.shoulder = sides_of(tags, "shoulder");
  path.surface = surface_value(tags, way);
  path.known_surface = surface_of_tags(path.highway, path.surface, tag_value(tags, "tracktype"));
  if (!path.surface.empty() && path.known_surface.source != SurfaceSource::tag)
    way.doubts.push_back(fmt::format("surface={} is not known, took {}", path.surface,
                                     roadquery::to_string(path.known_surface.surface)));
  if (way.reversed) path.sidewalk = mirrored(path.sidewalk), path.shoulder = mirrored(path.shoulder);
  read_speeds(tags, way);
  read_lane_widths(tags, way);
  read_uses(tags, way);
  read_side_lanes(tags, way);
  if (path.oneway == Oneway::forward && path.lanes_backward == 0)
    path.turn_backward.clear(), path.widths_backward.clear();
  count_listed_lanes(path);
  path.oneway == Oneway::forward ? settle_one_way(tags, way) : settle_two_way(way);
  settle_lists(way);
  spread_direction_widths(tags, way);
  spread_turns(tags, way, true), spread_turns(tags, way, false);
  read_placement(tags, way);
}

}  // namespace orthodrive::io
