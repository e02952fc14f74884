// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/io/osm/lane_use.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <initializer_list>
#include <string_view>

#include "orthodrive/model/roads/highway_class.hpp"
#include "roadquery/text/text.hpp"

namespace orthodrive::io {
namespace {
bool way_is_one_way(const WayAttributes& way) { return way.path.oneway == Oneway::forward; }

bool has_own(const std::string& value) { return value == "designated" || value == "official"; }
bool may_use(const std::string& value) { return has_own(value) || value == "yes" || value == "permissive"; }

/// What the keys of access say, of a road or of one of its lanes.
struct Permits {
  std::string access, vehicle, motor_vehicle, motorcar, hov, bus, psv, taxi, bicycle;
};

/// The closest key tells of cars: motorcar before motor_vehicle before vehicle before access. Where none does, a lane
/// that is designated to others is theirs. `closed`: a road that is none for cars unless told.
std::string use_of(const Permits& p, bool closed) {
  std::string cars;
  for (const std::string* value : {&p.motorcar, &p.motor_vehicle, &p.vehicle, &p.access})
    if (cars.empty()) cars = *value;
  if (!cars.empty() && cars != "no") return "";
  if (may_use(p.hov)) return "";  // cars, with passengers; tagged beside motor_vehicle=no as often as without
  closed = closed || cars == "no";
  for (const auto may : {&has_own, &may_use}) {
    if (may == &may_use && !closed) break;
    if (may(p.psv) || (may(p.bus) && may(p.taxi))) return "psv";
    if (may(p.bus)) return "bus";
    if (may(p.taxi)) return "taxi";
    if (may(p.bicycle)) return "bicycle";
  }
  return closed ? "none" : "";
}

constexpr std::array<std::pair<const char*, std::string Permits::*>, 9> permit_keys{
    {{"access", &Permits::access},
     {"vehicle", &Permits::vehicle},
     {"motor_vehicle", &Permits::motor_vehicle},
     {"motorcar", &Permits::motorcar},
     {"hov", &Permits::hov},
     {"bus", &Permits::bus},
     {"psv", &Permits::psv},
     {"taxi", &Permits::taxi},
     {"bicycle", &Permits::bicycle}}};

/// Sides in the words of RoadPath::side_lanes; left and right of a path that runs against its way change.
std::string side_word(const char* kind, std::string_view side, bool reversed) {
  if (reversed && side == "left")
    side = "right";
  else if (reversed && side == "right")
    side = "left";
  return fmt::format("{}:{}", kind, side);
}

/// cycleway=* or busway=* with their sides.
std::vector<std::string> tagged_side_lanes(const OsmTags& tags, const WayAttributes& way, const std::string& key,
                                           const char* kind) {
  std::vector<std::string> words;
  const bool one_way = way_is_one_way(way);
  const auto is_lane = [](const std::string& value) { return value == "lane" || value == "opposite_lane"; };
  const auto add = [&](std::string_view side) { words.push_back(side_word(kind, side, way.reversed)); };
  const std::string all = tag_value(tags, key);
  if (all == "lane") add("along");
  if (all == "opposite_lane" || (all == "lane" && !one_way)) add("against");
  const bool both = is_lane(tag_value(tags, key + ":both"));
  for (const char* side : {"left", "right"})
    if (const std::string value = tag_value(tags, fmt::format("{}:{}", key, side)); both || is_lane(value))
      add(one_way && value == "opposite_lane" ? "against" : side);
  return words;
}

/// lanes:bus=1 and neighbours: so many of the outermost lanes of a direction.
void read_lane_counts(const OsmTags& tags, WayAttributes& way, const char* kind) {
  const auto count = [&](const std::string& suffix) {
    const std::string text = tag_value(tags, fmt::format("lanes:{}{}", kind, suffix));
    const int value = parse_whole_number(text).value_or(-1);
    const bool good = value >= 0 && value <= 8;
    if (!text.empty() && !good)
      way.doubts.push_back(fmt::format("lanes:{}{}={} is no number of lanes, left out", kind, suffix, text));
    return good ? value : 0;
  };
  int forward = count(way.reversed ? ":backward" : ":forward"),
      backward = count(way.reversed ? ":forward" : ":backward");
  if (const int all = count(""); all > 0 && forward + backward == 0) {
    if (way_is_one_way(way))
      forward = all;
    else if (all % 2 == 0)
      forward = backward = all / 2;
    else
      way.doubts.push_back(fmt::format("lanes:{}={} does not tell of which direction, left out", kind, all));
  }
  const auto add = [&](int lanes, const char* side) {
    for (int i = 0; i < lanes; ++i) {
      if (!way.path.side_lanes.empty()) way.path.side_lanes += ' ';
      way.path.side_lanes += fmt::format("{}:{}", kind, side);
    }
  };
  if (way.path.use_forward.empty()) add(forward, "along");
  if (way.path.use_backward.empty()) add(backward, "against");
}

bool names_kind(const RoadPath& path, std::string_view kind) {
  const std::string beginning = fmt::format("{}:", kind);
  return std::ranges::any_of(side_lanes_of(path), [&](std::string_view word) { return word.starts_with(beginning); });
}
/// Without blanks beside "|" and ";": slips of the keyboard and of editors.
std::string without_blanks_between(std::string_view text) {
  std::string clean;
  for (const char c : text) {
    const bool is_blank = roadquery::blanks.find(c) != std::string_view::npos, separates = c == '|' || c == ';';
    if (separates)
      while (!clean.empty() && roadquery::blanks.find(clean.back()) != std::string_view::npos) clean.pop_back();
    if (is_blank && (clean.empty() || clean.back() == '|' || clean.back() == ';')) continue;
    clean += c;
  }
  return clean;
}
}  // namespace

std::vector<std::string> lane_list(const std::string& text) {
  std::vector<std::string> words;
  for (const std::string_view word : lane_words(text)) words.emplace_back(roadquery::trimmed(word));
  return words;
}

std::string joined_lanes(const std::vector<std::string>& lanes) {
  std::string text;
  for (std::size_t i = 0; i < lanes.size(); ++i) text += (i > 0 ? "|" : "") + lanes[i];
  return text;
}

std::string lane_value(const OsmTags& tags, const WayAttributes& way, const std::string& key, bool forward) {
  std::string value = tag_value(tags, key + (forward != way.reversed ? ":forward" : ":backward"));
  if (value.empty() && forward && way_is_one_way(way)) value = tag_value(tags, key);
  return without_blanks_between(value);
}

std::string road_use(const OsmTags& tags, const std::string& highway) {
  if (is_raceway(highway)) return "";
  Permits permits;
  for (const auto& [key, member] : permit_keys) permits.*member = tag_value(tags, key);
  const bool busway = highway == "busway";
  // A designation closes a lane to others, but no road.
  if (!busway && permits.access != "no" && permits.vehicle != "no" && permits.motor_vehicle != "no" &&
      permits.motorcar != "no")
    return "";
  if (busway && permits.bus.empty() && permits.psv.empty()) permits.bus = "designated";
  return use_of(permits, busway);
}

std::vector<std::string> lane_uses(const OsmTags& tags, WayAttributes& way, bool forward) {
  std::vector<Permits> lanes;
  for (const auto& [key, member] : permit_keys) {
    const std::vector<std::string> list = lane_list(lane_value(tags, way, fmt::format("{}:lanes", key), forward));
    if (list.empty()) continue;
    if (!lanes.empty() && lanes.size() != list.size()) {
      way.doubts.push_back(
          fmt::format("{}:lanes tells {} lanes, others {}; it is left out", key, list.size(), lanes.size()));
      continue;
    }
    lanes.resize(list.size());
    for (std::size_t i = 0; i < list.size(); ++i) lanes[i].*member = list[i].substr(0, list[i].find(';'));
  }
  std::vector<std::string> uses;
  uses.reserve(lanes.size());
  for (const Permits& lane : lanes) uses.push_back(use_of(lane, false));
  return uses;
}

std::string counter_use(const OsmTags& tags) {
  const auto against = [&](const char* key) { return tag_value(tags, fmt::format("oneway:{}", key)) == "no"; };
  if (against("psv") || (against("bus") && against("taxi"))) return "psv";
  if (against("bus")) return "bus";
  if (against("taxi")) return "taxi";
  if (against("bicycle") || tag_value(tags, "cycleway").starts_with("opposite")) return "bicycle";
  return "none";
}

void add_side_lane(RoadPath& path, std::string_view word) {
  if (std::ranges::any_of(side_lanes_of(path), [&](std::string_view known) { return known == word; })) return;
  if (!path.side_lanes.empty()) path.side_lanes += ' ';
  path.side_lanes += word;
}

void read_side_lanes(const OsmTags& tags, WayAttributes& way) {
  RoadPath& path = way.path;
  for (const std::string& word : tagged_side_lanes(tags, way, "cycleway", "bicycle")) add_side_lane(path, word);
  for (const std::string& word : tagged_side_lanes(tags, way, "busway", "bus")) {
    if (word != "bus:against" || path.oneway == Oneway::no) {
      if (path.use_forward.empty() && path.use_backward.empty()) add_side_lane(path, word);
      continue;
    }
    if (path.lanes_backward > 0) continue;  // lanes:backward counts it already
    path.lanes_backward = 1, path.use_backward = "bus";
    if (path.lanes == 1) path.lanes = 2;  // the one for cars was counted alone
  }
  for (const char* kind : {"psv", "bus", "taxi"})
    if (!names_kind(path, "bus") && !names_kind(path, "psv")) read_lane_counts(tags, way, kind);
}

namespace {
/// left_of:1 is 0, middle_of:1 is 0.5, right_of:1 is 1; -1 for other texts.
double placement_of(std::string_view text) {
  constexpr std::array<std::pair<std::string_view, double>, 3> kinds{
      {{"left_of:", 0.0}, {"middle_of:", 0.5}, {"right_of:", 1.0}}};
  for (const auto& [beginning, share] : kinds) {
    if (!text.starts_with(beginning)) continue;
    if (const int lane = parse_whole_number(std::string(text.substr(beginning.size()))).value_or(0);
        lane >= 1 && lane <= 16)
      return lane - 1 + share;
  }
  return -1.0;
}
}  // namespace

void read_placement(const OsmTags& tags, WayAttributes& way) {
  Placement& placement = way.path.placement;
  for (const bool forward : {true, false}) {
    if (placement.is_told() || placement.transition) return;
    const int lanes = forward ? way.path.lanes_forward : way.path.lanes_backward;
    const auto read = [&](const std::string& text, const std::string& key) {
      const double place = placement_of(text);
      const bool good = place >= 0.0 && (lanes == 0 || place <= lanes);
      if (!text.empty() && text != "transition" && !good)
        way.doubts.push_back(fmt::format("{}={} is no place among its lanes, left out", key, text));
      return good ? place : -1.0;
    };
    const auto value = [&](const std::string& key) { return lane_value(tags, way, key, forward); };
    const std::string whole = value("placement"), start = value("placement:start"), end = value("placement:end");
    placement.backward = !forward;
    placement.start = placement.end = read(whole, "placement");
    placement.transition = whole == "transition";
    if (!start.empty()) (way.reversed ? placement.end : placement.start) = read(start, "placement:start");
    if (!end.empty()) (way.reversed ? placement.start : placement.end) = read(end, "placement:end");
  }
  if (placement.is_told() || placement.transition) return;
  placement = {};
  if (way.path.oneway == Oneway::no) {
    if (tags.contains("placement") && tag_value(tags, "placement") == "transition")
      placement.transition = true;
    else if (tags.contains("placement"))
      way.doubts.push_back(
          fmt::format("placement={} of a road for both directions does not tell of which one, left out",
                      tag_value(tags, "placement")));
  }
}

}  // namespace orthodrive::io
