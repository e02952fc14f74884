// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/io/osm/lane_widths.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>

#include "orthodrive/core/printable.hpp"
#include "orthodrive/io/osm/lane_use.hpp"

namespace orthodrive::io {
namespace {
constexpr double least_lane_m = 0.5, widest_lane_m = 20.0;  // what is beyond is a slip of the keyboard

/// The list with every width in metres.
std::string widths_of(const std::string& key, const std::string& text, WayAttributes& way) {
  std::vector<std::string> widths;
  bool any = false;
  for (const std::string& word : lane_list(text)) {
    const double width_m = parse_width_m(word);
    const bool good = width_m >= least_lane_m && width_m <= widest_lane_m;
    if (!good && !word.empty())
      way.doubts.push_back(
          fmt::format("{}={}: {} is no width of a lane, left out", key, printable(text), printable(word)));
    widths.push_back(good ? fmt::format("{:g}", width_m) : "");
    any = any || good;
  }
  return any ? joined_lanes(widths) : "";
}

/// width:forward or width:backward of the path's direction; 0: not told.
double direction_width_m(const OsmTags& tags, WayAttributes& way, bool forward) {
  const std::string key = forward != way.reversed ? "width:forward" : "width:backward", text = tag_value(tags, key);
  const double width_m = parse_width_m(text);
  if (!text.empty() && width_m == 0.0) way.odd.push_back(key + "=" + printable(text));
  return width_m;
}

/// Lanes that a list tells of: their sum and number.
struct SumOfWidths {
  double sum_m = 0.0;
  int count = 0;
  void add(const std::string& list) {
    for (const std::string& word : lane_list(list))
      if (const double width_m = std::strtod(word.c_str(), nullptr); width_m > 0.0) sum_m += width_m, ++count;
  }
};

/// width:lanes of a road for both directions without saying which lanes are whose: what it says of the road.
SumOfWidths lanes_across(const OsmTags& tags, WayAttributes& way) {
  SumOfWidths told;
  const std::string text = tag_value(tags, "width:lanes");
  if (text.empty() || way.path.oneway == Oneway::forward) return told;
  const std::vector<std::string> widths = lane_list(widths_of("width:lanes", text, way));
  if (widths.empty()) return told;
  if (static_cast<int>(widths.size()) != way.path.lanes) {
    way.doubts.push_back(fmt::format("width:lanes={} tells {} lanes, but there are {}; it is left out", printable(text),
                                     widths.size(), way.path.lanes));
    return told;
  }
  if (std::ranges::any_of(widths, [&](const std::string& width) { return width != widths.front(); }))
    way.doubts.push_back(
        fmt::format("width:lanes={} of a road for both directions does not tell which lane is whose, took their sum: "
                    "width:lanes:forward and width:lanes:backward tell",
                    printable(text)));
  told.add(joined_lanes(widths));
  return told;
}

/// The sum over the lanes; those of which nothing is told are as wide as in the class.
TaggedWidth width_of_lanes(const OsmTags& tags, WayAttributes& way) {
  const RoadPath& path = way.path;
  SumOfWidths told;
  for (const std::string* list : {&path.widths_forward, &path.widths_backward, &path.widths_both_ways}) told.add(*list);
  if (told.count == 0) told = lanes_across(tags, way);
  if (told.count == 0) return {};
  const int against = path.oneway == Oneway::forward ? path.lanes_backward : std::max(1, path.lanes_backward);
  const int sum = path.lanes_forward > 0 ? path.lanes_forward + against + path.lanes_both_ways : 0;
  const int lanes = std::max({path.lanes, sum, told.count}), untold = lanes - told.count;
  const double usual_m = default_width_m(path.highway, lanes, path.oneway) / lanes;
  return {told.sum_m + untold * usual_m + cycle_lanes_m(path), untold == 0};
}
}  // namespace

void read_lane_widths(const OsmTags& tags, WayAttributes& way) {
  RoadPath& path = way.path;
  path.widths_forward = widths_of("width:lanes", lane_value(tags, way, "width:lanes", true), way);
  path.widths_backward = widths_of("width:lanes", lane_value(tags, way, "width:lanes", false), way);
  path.widths_both_ways = widths_of("width:lanes:both_ways", tag_value(tags, "width:lanes:both_ways"), way);
  if (path.lanes_both_ways == 0 && path.oneway == Oneway::no)
    path.lanes_both_ways = static_cast<int>(lane_list(path.widths_both_ways).size());
}

void spread_direction_widths(const OsmTags& tags, WayAttributes& way) {
  for (const bool forward : {true, false}) {
    std::string& widths = forward ? way.path.widths_forward : way.path.widths_backward;
    const int lanes = forward ? way.path.lanes_forward : way.path.lanes_backward;
    const double width_m = direction_width_m(tags, way, forward);
    if (!widths.empty() || lanes == 0 || width_m == 0.0) continue;
    widths =
        joined_lanes(std::vector<std::string>(static_cast<std::size_t>(lanes), fmt::format("{:g}", width_m / lanes)));
  }
}

TaggedWidth tagged_width(const OsmTags& tags, WayAttributes& way) {
  double found_m = 0.0;
  for (const char* key : {"width:carriageway", "width", "est_width"}) {
    const std::string& text = tag_value(tags, key);
    const double width_m = parse_width_m(text);
    if (!text.empty() && width_m == 0.0) way.odd.push_back(std::string(key) + "=" + text);
    if (found_m == 0.0) found_m = width_m;
  }
  if (found_m > 0.0) return {found_m};
  const double forward_m = parse_width_m(tag_value(tags, "width:forward")),
               backward_m = parse_width_m(tag_value(tags, "width:backward"));
  const bool both = forward_m > 0.0 && backward_m > 0.0;
  if (both || (way.path.oneway == Oneway::forward && forward_m + backward_m > 0.0)) return {forward_m + backward_m};
  return width_of_lanes(tags, way);
}

}  // namespace orthodrive::io
