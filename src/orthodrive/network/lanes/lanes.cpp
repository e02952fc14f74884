// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/network/lanes/lanes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>

namespace orthodrive::network {
namespace {

using roadquery::Cubic;
using roadquery::Lane;
using roadquery::LaneType;
using roadquery::Road;
using roadquery::RoadMark;

// Room a lane needs before another one is assumed: RASt 06 builds urban lanes from 2.75 m (two-way) upwards; one-way
// streets keep room for parking.
constexpr double two_way_lane_m = 3.0, one_way_lane_m = 3.25;
constexpr double min_tagged_lane_m = 2.2;  // a car and its mirrors
constexpr double min_lane_m = 2.05, notable_widening_m = 0.3;
constexpr double wheelbase_m = 2.7;    // of a family car
constexpr int max_untagged_lanes = 4;  // a direction
constexpr double taper_m =
    30.0;  // over which a lane opens or ends; at most its share of the road. RASt 06: 30 m at 50 km/h
constexpr double taper_step_m = 3.0;  // between the ends of its cubics: they leave the smooth step by under 1 mm
constexpr double sidewalk_m = 2.0;
// Beside the lanes of an untagged motorway or trunk road: a hard shoulder of 2.5 m and strips (RAA 2008, RQ 28).
constexpr double fast_rests_m = 3.0, fast_lane_m = 3.5;
constexpr double one_lane_ring_m = 8.0;     // narrower rings have one lane (FGSV, Merkblatt Kreisverkehre 2006)
constexpr double centre_line_from_m = 5.5;  // narrower two-way roads have no centre line (RMS: from 5.5 m)

/// A share of the carriageway that changes along the tapers at both ends.
struct Share {
  double start = 0.0, middle = 0.0, end = 0.0;
};

/// Smooth step from 0 at 0 to 1 at `reach`, and its slope.
struct Step {
  double value = 0.0, slope = 0.0;
};
Step step_at(double s, double reach) {
  if (reach <= 0.0 || s >= reach) return {1.0, 0.0};
  const double x = std::max(0.0, s / reach);
  return {x * x * (3.0 - 2.0 * x), 6.0 * x * (1.0 - x) / reach};
}

/// The width of a carriageway and where its lanes open: turns shares into widths.
class Carriageway {
 public:
  Carriageway(std::vector<Cubic> total, double length, bool tapers_at_start, bool tapers_at_end)
      : total_(std::move(total)), length_(length) {
    const double reach = std::min(taper_m, tapers_at_start && tapers_at_end ? 0.5 * length : length);
    start_reach_ = tapers_at_start ? reach : 0.0, end_reach_ = tapers_at_end ? reach : 0.0;
    for (const Cubic& c : total_) breaks_.push_back(c.s);
    breaks_.push_back(length);
    const auto add_breaks = [&](double s0, double s1) {
      const int steps = std::max(4, static_cast<int>(std::ceil((s1 - s0) / taper_step_m)));
      for (int i = 0; i <= steps; ++i) breaks_.push_back(s0 + (s1 - s0) * i / steps);
    };
    if (start_reach_ > 0.0) add_breaks(0.0, start_reach_);
    if (end_reach_ > 0.0) add_breaks(length - end_reach_, length);
    std::sort(breaks_.begin(), breaks_.end());
    constexpr double same_m = 1e-3;
    breaks_.erase(std::unique(breaks_.begin(), breaks_.end(), [](double a, double b) { return b - a < same_m; }),
                  breaks_.end());
    breaks_.back() = length;
  }

  /// Share x width as cubics. All shares have the same breaks, so sums of them are as exact as the width itself.
  [[nodiscard]] std::vector<Cubic> part(const Share& share) const {
    if (share.start == share.middle && share.end == share.middle) {
      std::vector<Cubic> result = total_;
      for (Cubic& c : result) c.a *= share.middle, c.b *= share.middle, c.c *= share.middle, c.d *= share.middle;
      return result;
    }
    std::vector<Cubic> result;
    for (std::size_t i = 0; i + 1 < breaks_.size(); ++i) {
      const double s0 = breaks_[i], s1 = breaks_[i + 1];
      const Cubic& c = total_at(0.5 * (s0 + s1));
      const auto at = [&](double s) {
        const Step open = step_at(s, start_reach_), close = step_at(length_ - s, end_reach_);
        const double x = share.middle + (share.start - share.middle) * (1.0 - open.value) +
                         (share.end - share.middle) * (1.0 - close.value);
        const double slope = -(share.start - share.middle) * open.slope + (share.end - share.middle) * close.slope;
        return std::array{value_at(c, s) * x, slope_at(c, s) * x + value_at(c, s) * slope};
      };
      const auto a = at(s0), b = at(s1);
      result.push_back(hermite(s0, s1, a[0], b[0], a[1], b[1]));
    }
    return result;
  }

 private:
  [[nodiscard]] const Cubic& total_at(double s) const {
    const auto after =
        std::upper_bound(total_.begin() + 1, total_.end(), s, [](double v, const Cubic& c) { return v < c.s; });
    return *(after - 1);
  }

  std::vector<Cubic> total_;
  std::vector<double> breaks_;
  double length_, start_reach_ = 0.0, end_reach_ = 0.0;
};

// ---- markings

bool is_one_of(const std::string& highway, std::span<const std::string_view> values) {
  return std::find(values.begin(), values.end(), highway) != values.end();
}

/// What a road of this class and width has painted (German RMS, Czech TP 133 and Swedish VGU agree in this).
struct Markings {
  bool edges = false;   ///< solid lines along the carriageway
  bool lanes = false;   ///< broken lines between lanes of one direction
  bool centre = false;  ///< between the directions
  double line_m = 0.12, edge_m = 0.12;
};

Markings markings_of(const std::string& highway, const LaneLayout& layout, double width_m) {
  constexpr std::string_view fast[] = {"motorway", "motorway_link", "trunk", "trunk_link"};
  constexpr std::string_view major[] = {"primary",        "primary_link", "secondary",
                                        "secondary_link", "tertiary",     "tertiary_link"};
  Markings marks;
  const bool is_fast = is_one_of(highway, fast), is_major = is_fast || is_one_of(highway, major);
  const bool is_race = highway == "raceway";
  marks.edges = is_race || (is_major && width_m >= (layout.left > 0 && layout.right > 0 ? centre_line_from_m : 0.0));
  marks.lanes = !is_race && (is_major || layout.left > 2 || layout.right > 2);
  marks.centre = is_major && width_m >= centre_line_from_m;
  if (is_fast) marks.line_m = 0.15, marks.edge_m = 0.30;
  if (is_race) marks.edge_m = 0.15;  // FIA, International Sporting Code, appendix O: at least 0.10 m
  return marks;
}

RoadMark no_mark() { return {0.0, "none", 0.0}; }

RoadMark centre_mark(const Markings& marks, const LaneLayout& layout) {
  if (layout.left == 0 || layout.right == 0)  // the inner edge of a one-way road
    return marks.edges ? RoadMark{0.0, "solid", marks.edge_m} : no_mark();
  if (!marks.centre) return no_mark();
  return {0.0, layout.left > 1 && layout.right > 1 ? "solid" : "broken", marks.line_m};
}

// ---- lanes

/// How a carriageway is divided at one place along a road.
struct Division {
  RoadEndLanes open;
  LaneRests rests;

  /// Of every open lane.
  [[nodiscard]] double lane_share() const { return (1.0 - rests.share()) / (open.left.count + open.right.count); }
  [[nodiscard]] double share_of(int lane, bool left) const {
    const OpenLanes& lanes = left ? open.left : open.right;
    return lane >= lanes.first && lane < lanes.first + lanes.count ? lane_share() : 0.0;
  }
  [[nodiscard]] double rest_share(bool left) const { return left ? rests.left.share : rests.right.share; }
  /// Of all to the left of the centre lane.
  [[nodiscard]] double left_share() const { return rests.left.share + open.left.count * lane_share(); }
};

RoadEndLanes all_open(const LaneLayout& layout) { return {{0, layout.left}, {0, layout.right}}; }

bool tapers(const Division& end, const Division& middle) {
  return end.open.left.count != middle.open.left.count || end.open.right.count != middle.open.right.count ||
         end.rests.left.share != middle.rests.left.share || end.rests.right.share != middle.rests.right.share;
}

Lane side_lane(int id, LaneType type, std::vector<Cubic> width) {
  Lane lane{.id = id, .type = type, .width = std::move(width)};
  lane.marks.push_back(no_mark());
  return lane;
}

unsigned turn_bits(std::string_view values) {
  unsigned bits = 0;
  for (std::size_t begin = 0; begin <= values.size();) {
    const std::size_t end = std::min(values.find(';', begin), values.size());
    const std::string_view value = values.substr(begin, end - begin);
    if (value == "left" || value == "slight_left" || value == "sharp_left") bits |= turn_left;
    if (value == "through") bits |= turn_through;
    if (value == "right" || value == "slight_right" || value == "sharp_right") bits |= turn_right;
    if (value.starts_with("merge_to")) bits |= turn_merge;
    begin = end + 1;
  }
  return bits;
}

/// Untagged: a direction.
bool has_one_lane(const RoadPath& path, double width_m) {
  constexpr std::string_view narrow[] = {"unclassified", "residential", "road", "living_street", "service", "track"};
  return path.roundabout ? width_m < one_lane_ring_m : is_one_of(path.highway, narrow);
}

}  // namespace

LaneLayout lane_layout(const RoadPath& path, double median_width_m, DrivingSide driving_side) {
  const bool one_way = path.oneway == Oneway::forward;
  int forward = 1, backward = one_way ? 0 : 1;
  bool reduced = false;
  if (path.lanes > 0 || path.lanes_forward > 0 || path.lanes_backward > 0) {
    const int lanes = std::max(path.lanes, path.lanes_forward + path.lanes_backward);
    if (one_way) {
      forward = lanes;
    } else {
      forward = path.lanes_forward > 0    ? path.lanes_forward
                : path.lanes_backward > 0 ? lanes - path.lanes_backward
                                          : (lanes + 1) / 2;
      backward = std::max(1, path.lanes_backward > 0 ? path.lanes_backward : lanes - forward);
      forward = std::max(1, forward);
    }
    // Two lanes of a narrow road that is used both ways stay: OpenDRIVE has no lane for both.
    while (forward + backward > (one_way ? 1 : 2) && (forward + backward) * min_tagged_lane_m > median_width_m) {
      --(forward >= backward ? forward : backward);
      reduced = true;
    }
  } else if (has_one_lane(path, median_width_m)) {
    forward = 1, backward = one_way ? 0 : 1;
  } else {
    const bool fast = path.highway.starts_with("motorway") || path.highway.starts_with("trunk");
    const double lane_m = one_way ? (fast ? fast_lane_m : one_way_lane_m) : two_way_lane_m;
    const double lanes_m = one_way ? median_width_m - (fast ? fast_rests_m : 0.0) : 0.5 * median_width_m;
    forward = std::clamp(static_cast<int>(lanes_m / lane_m), 1, max_untagged_lanes);
    backward = one_way ? 0 : forward;
  }
  return driving_side == DrivingSide::left ? LaneLayout{forward, backward, reduced}
                                           : LaneLayout{backward, forward, reduced};
}

double least_carriageway_m(Oneway oneway, double curvature_1pm) {
  if (oneway == Oneway::no) return 2.0 * min_lane_m;
  // With the middle of the wheelbase on a circle the rear axle runs wheelbase^2 / 8 R within, the front axle three
  // times that without.
  return min_tagged_lane_m + 0.5 * wheelbase_m * wheelbase_m * std::abs(curvature_1pm);
}

RoadNetwork with_lane_room(RoadNetwork roads, Findings& findings) {
  for (RoadPath& path : roads.paths) {
    const double least_m = least_carriageway_m(path.oneway);
    const RoadNode* narrowest = nullptr;
    double narrowest_m = least_m - notable_widening_m;
    for (RoadNode& node : path.nodes) {
      if (node.width_m < narrowest_m) narrowest_m = node.width_m, narrowest = &node;
      node.width_m = std::max(node.width_m, least_m);
    }
    if (narrowest)
      findings.push_back({Severity::info, "network.widened",
                          fmt::format("way {}: {:.1f} m are too narrow for its lanes, took {:.1f} m", path.osm_id,
                                      narrowest_m, least_m),
                          narrowest->p.x, narrowest->p.y});
  }
  return roads;
}

roadquery::LaneMaterial lane_material(SurfaceClass surface, Weather weather) {
  const RoadMaterial m = material_of(surface, weather);
  return {0.0, surface, m.friction, m.roughness_m};
}

void set_material(Road& road, SurfaceClass surface, Weather weather) {
  for (roadquery::LaneSection& section : road.sections)
    for (auto* side : {&section.left, &section.right})
      for (Lane& lane : *side)
        lane.materials = {lane_material(lane.type == LaneType::sidewalk ? SurfaceClass::concrete : surface, weather)};
}

SurfaceClass surface_of(const Road& road) {
  for (const roadquery::LaneSection& section : road.sections)
    for (const auto* side : {&section.right, &section.left})
      for (const Lane& lane : *side)
        if (lane.type == LaneType::driving && !lane.materials.empty()) return lane.materials.front().surface;
  return SurfaceClass::asphalt;
}

LaneMatch match_lanes(int from, int to, int inner) {
  const int count = std::min(from, to);
  const int opened = to - count;
  return {{0, count}, {std::min(inner, opened), count}};
}

void add_lanes(Road& road, const LaneLayout& layout, std::span<const ProfileSample> widths,
               const LaneOptions& options) {
  const Division middle{all_open(layout), options.rests},
      start{options.start.value_or(middle.open), options.start_rests.value_or(options.rests)},
      end{options.end.value_or(middle.open), options.end_rests.value_or(options.rests)};
  const Carriageway carriageway(fit_profile(widths, {.tolerance = options.tolerance_m}).cubics, road.length,
                                tapers(start, middle), tapers(end, middle));
  const Markings marks = markings_of(road.highway, layout, widths[widths.size() / 2].value);
  roadquery::LaneSection section;
  section.center.type = LaneType::none;
  section.center.marks.push_back(centre_mark(marks, layout));
  const auto add_side = [&](std::vector<Lane>& lanes, bool left, int count, const LaneRest& rest) {
    const auto next_id = [&] { return (left ? 1 : -1) * (static_cast<int>(lanes.size()) + 1); };
    for (int i = 0; i < count; ++i) {
      Lane lane{.id = next_id()};
      lane.width = carriageway.part({start.share_of(i, left), middle.share_of(i, left), end.share_of(i, left)});
      const bool outermost = i + 1 == count;
      lane.marks.push_back(outermost ? (marks.edges ? RoadMark{0.0, "solid", marks.edge_m} : no_mark())
                                     : (marks.lanes ? RoadMark{0.0, "broken", marks.line_m} : no_mark()));
      lanes.push_back(std::move(lane));
    }
    if (rest.exists())
      lanes.push_back(
          side_lane(next_id(), rest.type,
                    carriageway.part({start.rest_share(left), middle.rest_share(left), end.rest_share(left)})));
    if (!has_side(options.sidewalk, left ? Sides::left : Sides::right)) return;
    if (!lanes.empty() && lanes.back().marks.front().type == "none") lanes.back().marks.front() = {0.0, "curb", 0.15};
    lanes.push_back(side_lane(next_id(), LaneType::sidewalk, {Cubic{.a = sidewalk_m}}));
  };
  add_side(section.left, true, layout.left, options.rests.left);
  add_side(section.right, false, layout.right, options.rests.right);
  road.sections.push_back(std::move(section));
  // The left edge lies at half the width: the centre lane is that far to the left less all that lies left of it.
  if (start.left_share() != 0.5 || middle.left_share() != 0.5 || end.left_share() != 0.5)
    road.lane_offset = carriageway.part({0.5 - start.left_share(), 0.5 - middle.left_share(), 0.5 - end.left_share()});
}

std::vector<int> lanes_of_direction(const Road& road, bool forward) {
  const bool right = forward != (road.driving_side == roadquery::DrivingSide::left);
  std::vector<int> ids;
  for (const Lane& lane : right ? road.sections.front().right : road.sections.front().left)
    if (lane.type == LaneType::driving) ids.push_back(lane.id);
  return ids;
}

std::vector<unsigned> turn_lanes(const RoadPath& path, bool forward, DrivingSide driving_side) {
  const std::string& tag = forward ? path.turn_forward : path.turn_backward;
  std::vector<unsigned> lanes;
  if (tag.empty()) return lanes;
  const std::string_view text = tag;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find('|', begin), text.size());
    lanes.push_back(turn_bits(text.substr(begin, end - begin)));
    begin = end + 1;
  }
  if (driving_side == DrivingSide::left)
    std::reverse(lanes.begin(), lanes.end());  // from left to right is from the outside in there
  return lanes;
}

}  // namespace orthodrive::network
