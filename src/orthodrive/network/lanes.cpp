#include "orthodrive/network/lanes.hpp"

#include <algorithm>
#include <cmath>
#include <string_view>

namespace orthodrive::network {
namespace {

using roadquery::Cubic;
using roadquery::Lane;
using roadquery::Road;
using roadquery::RoadMark;

// Room a lane needs before another one is assumed: RASt 06 builds urban lanes from 2.75 m (two-way) upwards; one-way
// streets keep room for parking.
constexpr double two_way_lane_m = 3.0, one_way_lane_m = 3.25;
constexpr int max_untagged_lanes = 4;  // a direction

std::vector<Cubic> scaled(const std::vector<Cubic>& cubics, double factor) {
  std::vector<Cubic> result = cubics;
  for (Cubic& c : result) c.a *= factor, c.b *= factor, c.c *= factor, c.d *= factor;
  return result;
}

bool has_markings(const std::string& highway) {
  constexpr std::string_view marked[] = {"motorway", "motorway_link", "trunk", "trunk_link", "primary", "primary_link",
                                         "secondary", "secondary_link", "tertiary", "tertiary_link"};
  return std::find(std::begin(marked), std::end(marked), highway) != std::end(marked);
}

Lane driving_lane(int id, bool outermost, const std::vector<Cubic>& width, bool marked) {
  Lane lane{.id = id, .width = width};
  lane.marks.push_back(marked ? RoadMark{0.0, outermost ? "solid" : "broken", 0.12} : RoadMark{0.0, "none", 0.0});
  return lane;
}

}  // namespace

LaneLayout lane_layout(const RoadPath& path, double median_width_m, bool left_hand_traffic) {
  const bool one_way = path.oneway == Oneway::forward;
  int forward = 1, backward = one_way ? 0 : 1;
  if (path.lanes > 0) {
    forward = one_way ? path.lanes : std::max(1, (path.lanes + 1) / 2);
    backward = one_way ? 0 : std::max(1, path.lanes / 2);
  } else if (one_way) {
    forward = std::clamp(static_cast<int>(median_width_m / one_way_lane_m), 1, max_untagged_lanes);
  } else {
    forward = backward = std::clamp(static_cast<int>(0.5 * median_width_m / two_way_lane_m), 1, max_untagged_lanes);
  }
  return left_hand_traffic ? LaneLayout{forward, backward} : LaneLayout{backward, forward};
}

void add_lanes(Road& road, const LaneLayout& layout, std::span<const ProfileSample> widths, double tolerance_m) {
  const std::vector<Cubic> total = fit_profile(widths, {.tolerance = tolerance_m}).cubics;
  const std::vector<Cubic> width = scaled(total, 1.0 / layout.total());
  const bool marked = has_markings(road.highway);
  roadquery::LaneSection section;
  for (int i = 1; i <= layout.left; ++i) section.left.push_back(driving_lane(i, i == layout.left, width, marked));
  for (int i = 1; i <= layout.right; ++i) section.right.push_back(driving_lane(-i, i == layout.right, width, marked));
  section.center.type = roadquery::LaneType::none;
  const bool two_way = layout.left > 0 && layout.right > 0;
  section.center.marks.push_back(marked ? RoadMark{0.0, two_way ? "broken" : "solid", 0.12} : RoadMark{0.0, "none", 0.0});
  road.sections.push_back(std::move(section));
  // The left edge lies at half the width: the centre lane is that far to the left less the left lanes.
  if (layout.left != layout.right)
    road.lane_offset = scaled(total, 0.5 - static_cast<double>(layout.left) / layout.total());
}

std::vector<int> lanes_of_direction(const Road& road, bool forward) {
  const bool right = forward != road.left_hand_traffic;
  std::vector<int> ids;
  for (const Lane& lane : right ? road.sections.front().right : road.sections.front().left) ids.push_back(lane.id);
  return ids;
}

}  // namespace orthodrive::network
