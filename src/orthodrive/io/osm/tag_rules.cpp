// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/io/osm/tag_rules.hpp"

#include <fmt/format.h>

#include <array>
#include <string_view>

#include "orthodrive/model/roads/traffic_calming.hpp"

namespace orthodrive::io {
namespace {
constexpr TaggedObject on_road = TaggedObject::way, on_node = TaggedObject::node;
constexpr bool is_taken = true, left_out = false;

constexpr std::array all_tag_rules{
    TagRule{on_road, "highway", is_taken, "Key:highway",
            "class of the road: width, lanes, limit and markings where no tag tells"},
    TagRule{on_road, "oneway", is_taken, "Key:oneway",
            "yes, true, 1; -1, reverse; reversible, alternating: all lanes for both directions"},
    TagRule{on_road, "oneway:*", is_taken, "Key:oneway:bicycle",
            "no of bus, psv, taxi, bicycle: who uses the lanes against a one-way road"},
    TagRule{on_road, "junction", is_taken, "Key:junction", "roundabout, circular: a ring, one-way"},
    TagRule{on_road, "lanes", is_taken, "Key:lanes", "number; 1 without oneway: one lane for both directions"},
    TagRule{on_road, "lanes:forward", is_taken, "Lanes", "number of lanes along the way"},
    TagRule{on_road, "lanes:backward", is_taken, "Lanes", "number against it; on a one-way road none for cars"},
    TagRule{on_road, "lanes:both_ways", is_taken, "Lanes", "number of lanes for both directions, between the others"},
    TagRule{on_road, "centre_turn_lane", is_taken, "Key:centre_turn_lane", "yes: one lane for both directions"},
    TagRule{on_road, "turn", is_taken, "Key:turn", "of all lanes of a direction"},
    TagRule{on_road, "turn:*", is_taken, "Key:turn",
            "turn:forward, turn:lanes and its directions: arrows, and which lane leads where"},
    TagRule{on_road, "lanes:bus", is_taken, "Bus_lanes", "the outermost lanes of a direction are for buses"},
    TagRule{on_road, "lanes:bus:*", is_taken, "Bus_lanes", "of one direction"},
    TagRule{on_road, "lanes:psv", is_taken, "Bus_lanes", "the outermost lanes are for buses and taxis"},
    TagRule{on_road, "lanes:psv:*", is_taken, "Bus_lanes", "of one direction"},
    TagRule{on_road, "lanes:taxi", is_taken, "Lanes", "the outermost lanes are for taxis"},
    TagRule{on_road, "lanes:taxi:*", is_taken, "Lanes", "of one direction"},
    TagRule{on_road, "busway", is_taken, "Key:busway", "lane, opposite_lane: bus lanes at the edges"},
    TagRule{on_road, "busway:*", is_taken, "Key:busway", "left, right, both"},
    TagRule{on_road, "bus:lanes*", is_taken, "Lanes",
            "who may use each lane, with motorcar, motor_vehicle, vehicle and access"},
    TagRule{on_road, "psv:lanes*", is_taken, "Lanes", "likewise"},
    TagRule{on_road, "taxi:lanes*", is_taken, "Lanes", "likewise"},
    TagRule{on_road, "bicycle:lanes*", is_taken, "Lanes", "cycle lanes at the edge of a direction's lanes"},
    TagRule{on_road, "access:lanes*", is_taken, "Lanes", "likewise"},
    TagRule{on_road, "vehicle:lanes*", is_taken, "Lanes", "likewise"},
    TagRule{on_road, "motor_vehicle:lanes*", is_taken, "Lanes", "likewise"},
    TagRule{on_road, "motorcar:lanes*", is_taken, "Lanes", "likewise"},
    TagRule{on_road, "hov:lanes*", is_taken, "Key:hov",
            "lanes for cars with passengers are lanes for cars, also where others are shut out"},
    TagRule{on_road, "hov", is_taken, "Key:hov", "designated, yes: likewise of the whole road"},
    TagRule{on_road, "access", is_taken, "Key:access",
            "no closes the road to cars; bus, psv, taxi, bicycle may be let in"},
    TagRule{on_road, "vehicle", is_taken, "Key:access", "likewise, before access"},
    TagRule{on_road, "motor_vehicle", is_taken, "Key:access", "likewise, before vehicle"},
    TagRule{on_road, "motorcar", is_taken, "Key:access", "likewise, before motor_vehicle"},
    TagRule{on_road, "bus", is_taken, "Key:access", "lets buses onto a closed road"},
    TagRule{on_road, "psv", is_taken, "Key:access", "lets buses and taxis onto a closed road"},
    TagRule{on_road, "taxi", is_taken, "Key:access", "lets taxis onto a closed road"},
    TagRule{on_road, "bicycle", is_taken, "Key:access", "lets bicycles onto a closed road"},
    TagRule{on_road, "cycleway", is_taken, "Key:cycleway", "lane, opposite_lane: lanes of 1.5 m beside those of cars"},
    TagRule{on_road, "cycleway:left", is_taken, "Key:cycleway", "likewise"},
    TagRule{on_road, "cycleway:right", is_taken, "Key:cycleway", "likewise"},
    TagRule{on_road, "cycleway:both", is_taken, "Key:cycleway", "likewise"},
    TagRule{on_road, "placement", is_taken, "Key:placement",
            "left_of, middle_of, right_of, transition: where the line lies among the lanes"},
    TagRule{on_road, "placement:*", is_taken, "Key:placement", "forward, backward, start, end"},
    TagRule{on_road, "width", is_taken, "Key:width", "of the carriageway"},
    TagRule{on_road, "width:lanes*", is_taken, "Lanes",
            "of each lane; where the road has another width than they have together, lanes keep their ratio"},
    TagRule{on_road, "width:*", is_taken, "Key:width",
            "carriageway; forward and backward: of all lanes of a direction, in equal parts"},
    TagRule{on_road, "est_width", is_taken, "Key:est_width", "where width does not tell"},
    TagRule{on_road, "maxspeed", is_taken, "Key:maxspeed",
            "number with unit, none; cases of a country's law, as CZ:urban, walk"},
    TagRule{on_road, "maxspeed:forward", is_taken, "Key:maxspeed", "of the lanes along the way"},
    TagRule{on_road, "maxspeed:backward", is_taken, "Key:maxspeed", "of the lanes against it"},
    TagRule{on_road, "maxspeed:both", is_taken, "Key:maxspeed", "as maxspeed"},
    TagRule{on_road, "maxspeed:lanes*", is_taken, "Lanes", "lane by lane"},
    TagRule{on_road, "zone:maxspeed*", is_taken, "Key:zone:maxspeed", "where maxspeed does not tell: DE:30, 30"},
    TagRule{on_road, "maxspeed:type*", is_taken, "Key:maxspeed:type", "where zone:maxspeed does not tell: GB:nsl_dual"},
    TagRule{on_road, "source:maxspeed*", is_taken, "Key:source:maxspeed", "where maxspeed:type does not tell"},
    TagRule{on_road, "zone:traffic", is_taken, "Key:zone:traffic",
            "in a town or outside: the limit where no tag tells"},
    TagRule{on_road, "motorroad", is_taken, "Key:motorroad", "yes: the limit where no tag tells"},
    TagRule{on_road, "lit", is_taken, "Key:lit", "yes: as in a town, no: as outside, for the limit where no tag tells"},
    TagRule{on_road, "sidewalk", is_taken, "Key:sidewalk",
            "left, right, both, yes; with one, or separate, a road lies in a town, with none outside"},
    TagRule{on_road, "sidewalk:*", is_taken, "Key:sidewalk", "left, right, both"},
    TagRule{on_road, "shoulder", is_taken, "Key:shoulder", "left, right, both, yes"},
    TagRule{on_road, "shoulder:*", is_taken, "Key:shoulder", "left, right, both"},
    TagRule{on_road, "surface", is_taken, "Key:surface", "what the road is made of"},
    TagRule{on_road, "surface:*", is_taken, "Key:surface",
            "where surface does not tell; of a road that has several, the first"},
    TagRule{on_road, "tracktype", is_taken, "Key:tracktype", "where surface does not tell"},
    TagRule{on_road, "traffic_calming", is_taken, "Key:traffic_calming",
            "table: the whole way is one; other humps where the way is not much longer than one"},
    TagRule{on_road, "bridge", is_taken, "Key:bridge", "the road lies on a bridge"},
    TagRule{on_road, "tunnel", is_taken, "Key:tunnel", "the road lies in a tunnel"},
    TagRule{on_road, "layer", is_taken, "Key:layer", "order of roads that cross"},

    TagRule{on_road, "maxspeed:conditional*", left_out, "Conditional_restrictions",
            "the map has one limit for all hours and weathers"},
    TagRule{on_road, "maxspeed:variable*", left_out, "Key:maxspeed",
            "limits of changing signs are known to them alone"},
    TagRule{on_road, "maxspeed:hgv*", left_out, "Key:maxspeed", "limits are those of cars"},
    TagRule{on_road, "maxspeed:advisory*", left_out, "Key:maxspeed:advisory", "no limit, an advice"},
    TagRule{on_road, "minspeed*", left_out, "Key:minspeed", "OpenDRIVE has no least speed"},
    TagRule{on_road, "lanes:conditional*", left_out, "Conditional_restrictions", "lanes are those of the day"},
    TagRule{on_road, "oneway:conditional", left_out, "Conditional_restrictions", "the direction is that of most hours"},
    TagRule{on_road, "access:conditional", left_out, "Conditional_restrictions", "access is that of most hours"},
    TagRule{on_road, "motor_vehicle:conditional", left_out, "Conditional_restrictions", "access is that of most hours"},
    TagRule{on_road, "change*", left_out, "Key:change", "lines between lanes follow the class of the road"},
    TagRule{on_road, "overtaking*", left_out, "Key:overtaking", "the centre line follows the class of the road"},
    TagRule{on_road, "hgv:lanes*", left_out, "Key:hgv", "lanes for lorries are lanes for cars, too"},
    TagRule{on_road, "cycleway:*", left_out, "Key:cycleway",
            "how a cycle lane is painted or who it is for; its width is 1.5 m"},
    TagRule{on_road, "parking:*", left_out, "Street_parking", "strips for parking come from the width of the road"},
    TagRule{on_road, "embedded_rails*", left_out, "Key:embedded_rails", "rails in the road are not built"},
    TagRule{on_road, "passing_places", left_out, "Key:passing_places",
            "where they lie is not told; nodes with highway=passing_place are built"},
    TagRule{on_road, "ford", left_out, "Key:ford", "the road goes through the water on the terrain"},

    TagRule{on_node, "highway=turning_circle", is_taken, "Tag:highway=turning_circle",
            "a paved circle, 12 m wide unless diameter or width tells"},
    TagRule{on_node, "highway=turning_loop", is_taken, "Tag:highway=turning_loop",
            "a paved circle of 18 m, its island paved, too"},
    TagRule{on_node, "highway=passing_place", is_taken, "Tag:highway=passing_place", "5.5 m of road for 15 m"},
    TagRule{on_node, "highway=stop", is_taken, "Tag:highway=stop", "a line where one waits"},
    TagRule{on_node, "highway=give_way", is_taken, "Tag:highway=give_way", "likewise"},
    TagRule{on_node, "highway=traffic_signals", is_taken, "Tag:highway=traffic_signals", "likewise"},
    TagRule{on_node, "highway=crossing", is_taken, "Tag:highway=crossing", "what is painted"},
    TagRule{on_node, "crossing*", is_taken, "Key:crossing", "likewise"},
    TagRule{on_node, "highway=mini_roundabout", is_taken, "Tag:highway=mini_roundabout",
            "a ring on a paved disc, 16 m wide unless diameter or width tells"},
    TagRule{on_node, "traffic_calming", is_taken, "Key:traffic_calming",
            "hump, bump, table, cushion, mini_bumps: heights of the road"},
    TagRule{on_node, "barrier", is_taken, "Key:barrier",
            "an object across the road; what keeps cars out is told (access, locked)"},
    TagRule{on_node, "barrier=kerb", left_out, "Tag:barrier=kerb", "a kerb across the road is not built"},
    TagRule{on_node, "kerb", left_out, "Key:kerb", "is of the walk that crosses; kerbs of roads follow the sidewalks"},
    TagRule{on_node, "ford", left_out, "Key:ford", "the road goes through the water on the terrain"},
    TagRule{on_node, "maxspeed", left_out, "Key:maxspeed", "the limit of the way counts"}};

bool fits_tag(std::string_view key, const std::string& tag_key, const std::string& tag) {
  if (key.ends_with('*')) return tag_key.starts_with(key.substr(0, key.size() - 1));
  return key.find('=') == key.npos ? key == tag_key : key == tag;
}

/// Of a value of traffic_calming that is no hump.
std::string_view why_no_hump(std::string_view value) {
  if (value == "yes") return "which kind is not told";
  for (const std::string_view flat : {"rumble_strip", "dynamic_bump", "painted_table", "painted_island"})
    if (value == flat) return "has no height that is known";
  return "narrowings and islands are not built";
}
}  // namespace

std::span<const TagRule> tag_rules() { return all_tag_rules; }

std::vector<UnreadTag> unread_tags(const OsmTags& tags, TaggedObject on) {
  std::vector<UnreadTag> found;
  for (const auto& [key, value] : tags) {
    if (value == "no" || value == "none" || value == "separate") continue;
    const std::string tag = fmt::format("{}={}", key, value);
    const TagRule* best = nullptr;
    for (const TagRule& rule : all_tag_rules)
      if (rule.on == on && fits_tag(rule.key, key, tag) && (!best || rule.key.size() > best->key.size())) best = &rule;
    if (best && !best->is_read) found.push_back({tag, best->meaning});
  }
  for (const std::string& value : calming_values(tag_value(tags, "traffic_calming")))
    if (!hump_profile(value)) found.push_back({fmt::format("traffic_calming={}", value), why_no_hump(value)});
  // Values of keys that are read, for lanes beyond the kerb or shared ones.
  const auto beyond = [&](const std::string& key) {
    const auto at = tags.find(key);
    if (on != TaggedObject::way || at == tags.end()) return;
    const std::string& value = at->second;
    if (value == "track" || value == "opposite_track")
      found.push_back({fmt::format("{}={}", key, value), "a cycle track beyond the kerb is not built"});
  };
  for (const char* key : {"cycleway", "cycleway:left", "cycleway:right", "cycleway:both"}) beyond(key);
  return found;
}

}  // namespace orthodrive::io
