// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/io/osm/osm_tags.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string_view>

#include "orthodrive/core/printable.hpp"
#include "orthodrive/io/osm/lane_widths.hpp"
#include "orthodrive/io/osm/osm_structure_tags.hpp"
#include "orthodrive/io/osm/tag_rules.hpp"
#include "orthodrive/model/roads/traffic_calming.hpp"
#include "roadquery/text/text.hpp"

namespace orthodrive::io {
namespace {
constexpr double foot_m = 0.3048, inch_m = 0.0254;
}  // namespace

const std::string& tag_value(const OsmTags& tags, const std::string& key) {
  static const std::string none;
  const auto it = tags.find(key);
  return it == tags.end() ? none : it->second;
}

std::optional<int> parse_whole_number(const std::string& text) {
  int value = 0;
  const char* end = text.data() + text.size();
  const auto [stopped, failed] = std::from_chars(text.data(), end, value);
  return failed == std::errc() && stopped == end ? std::optional(value) : std::nullopt;
}

double parse_width_m(const std::string& text) {
  std::string clean;
  for (const char c : text)
    if (c != ' ') clean += c == ',' ? '.' : c;
  double value = 0.0;
  const char* end = clean.data() + clean.size();
  auto [rest, failed] = std::from_chars(clean.data(), end, value);
  if (failed != std::errc() || !std::isfinite(value) || value <= 0.0) return 0.0;
  const std::string unit(rest, end);
  if (unit.empty() || unit == "m" || unit == "metres" || unit == "meters") return value;
  for (const std::string_view feet : {"'", "ft", "feet"}) {
    if (!unit.starts_with(feet)) continue;
    if (unit == feet) return value * foot_m;
    for (const std::string_view inch : {"\"", "in", "''"}) {
      if (!unit.ends_with(inch) || unit.size() < feet.size() + inch.size()) continue;
      const std::size_t digits = unit.size() - feet.size() - inch.size();
      const int inches = parse_whole_number(unit.substr(feet.size(), digits)).value_or(-1);
      return inches < 0 ? 0.0 : value * foot_m + inches * inch_m;
    }
  }
  return 0.0;
}

namespace {
/// What Key:oneway knows, and nothing.
bool is_oneway_value(std::string_view value) {
  for (const std::string_view known :
       {"", "yes", "true", "1", "-1", "reverse", "no", "false", "0", "reversible", "alternating"})
    if (value == known) return true;
  return false;
}
}  // namespace

WayAttributes way_attributes(const OsmTags& tags) {
  WayAttributes way;
  RoadPath& path = way.path;
  path.highway = tag_value(tags, "highway");
  path.name = tag_value(tags, "name");
  read_structure_tags(tags, way);
  path.lanes = std::max(0, parse_whole_number(tag_value(tags, "lanes")).value_or(0));
  const std::string junction = tag_value(tags, "junction"), oneway = roadquery::lowered(tag_value(tags, "oneway"));
  path.roundabout = junction == "roundabout" || junction == "circular";
  way.reversed = oneway == "-1" || oneway == "reverse";
  const bool implied = oneway.empty() && (path.roundabout || path.highway == "motorway");
  if (way.reversed || implied || oneway == "yes" || oneway == "true" || oneway == "1") path.oneway = Oneway::forward;
  if (!is_oneway_value(oneway))
    way.doubts.push_back(fmt::format("oneway={} is not known, took both directions", printable(oneway)));
  read_lane_tags(tags, way);
  const TaggedWidth width = tagged_width(tags, way);
  way.width_m = width.width_m;
  path.width_source = width.width_m > 0.0 && width.of_all ? WidthSource::tag
                      : path.lanes > 0                    ? WidthSource::lanes
                                                          : WidthSource::highway;
  for (const std::string& value : calming_values(tag_value(tags, "traffic_calming")))
    if (path.traffic_calming.empty() && hump_profile(value)) path.traffic_calming = value;
  const std::string lanes = tag_value(tags, "lanes");
  if (!lanes.empty() && path.lanes == 0) way.odd.push_back("lanes=" + lanes);
  if (way.width_m == 0.0) way.width_m = default_width_m(path.highway, path.lanes, path.oneway) + cycle_lanes_m(path);
  for (const UnreadTag& tag : unread_tags(tags, TaggedObject::way)) way.unread.emplace_back(tag.tag, tag.reason);
  return way;
}

}  // namespace orthodrive::io
