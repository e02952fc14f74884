// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/network/lanes/lanes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <string_view>
#include <utility>

#include "orthodrive/model/roads/highway_class.hpp"

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
  const bool is_race = is_raceway(highway);
  const bool both_ways = layout.is_shared() || (layout.left > 0 && layout.right > 0);
  marks.edges = is_race || (is_major && width_m >= (both_ways ? centre_line_from_m : 0.0));
  marks.lanes = !is_race && (is_major || layout.left > 2 || layout.right > 2);
  marks.centre = is_major && width_m >= centre_line_from_m;
  if (is_fast) marks.line_m = 0.15, marks.edge_m = 0.30;
  if (is_race) marks.edge_m = 0.15;  // FIA, International Sporting Code, appendix O: at least 0.10 m
  return marks;
}

RoadMark no_mark() { return {0.0, "none", 0.0}; }

RoadMark centre_mark(const Markings& marks, const LaneLayout& layout) {
  if (layout.left == 0 || layout.right == 0)  // the inner edge of a one-way road, or of a lane for both directions
    return marks.edges ? RoadMark{0.0, "solid", marks.edge_m} : no_mark();
  if (!marks.centre) return no_mark();
  return {0.0, layout.left > 1 && layout.right > 1 ? "solid" : "broken", marks.line_m};
}

// ---- lanes

/// How a carriageway is divided at one place along a road.
struct Division {
  RoadEndLanes open;
  LaneRests rests;
  LaneWeights weights;
  std::optional<double> shift;  ///< of the centre lane; not set: all is centred
  bool both_on_left = false;    ///< on which side of the centre lane the lanes for both directions lie

  /// Of all open lanes.
  [[nodiscard]] double sum_of_weights() const {
    double sum = 0.0;
    for (const bool left : {true, false})
      for (int i = 0; i < lanes_of(left).count; ++i) sum += weight(lanes_of(left).first + i, left);
    for (int i = 0; i < open.both_ways; ++i) sum += LaneWeights::at(weights.both_ways, i);
    return sum;
  }
  [[nodiscard]] double share_of(int lane, bool left) const {
    const OpenLanes& lanes = lanes_of(left);
    return lane >= lanes.first && lane < lanes.first + lanes.count ? lane_share(weight(lane, left)) : 0.0;
  }
  [[nodiscard]] double both_share_of(int lane) const {
    return lane < open.both_ways ? lane_share(LaneWeights::at(weights.both_ways, lane)) : 0.0;
  }
  /// Of all lanes for both directions.
  [[nodiscard]] double both_share() const {
    double share = 0.0;
    for (int i = 0; i < open.both_ways; ++i) share += both_share_of(i);
    return share;
  }
  [[nodiscard]] double rest_share(bool left) const { return left ? rests.left.share : rests.right.share; }
  [[nodiscard]] double cycle_share(bool left) const {
    return left ? rests.left_cycles.share : rests.right_cycles.share;
  }
  /// How far the centre lane lies left of the reference line: the left edge lies at half the width, and all that lies
  /// left of the centre lane between them.
  [[nodiscard]] double centre_share() const {
    double lanes = both_on_left ? both_share() : 0.0;
    for (int i = 0; i < open.left.count; ++i) lanes += share_of(open.left.first + i, true);
    return shift.value_or(0.5 - (rests.left_share() + lanes));
  }

 private:
  [[nodiscard]] const OpenLanes& lanes_of(bool left) const { return left ? open.left : open.right; }
  [[nodiscard]] double weight(int lane, bool left) const {
    return LaneWeights::at(left ? weights.left : weights.right, lane);
  }
  [[nodiscard]] double lane_share(double weight) const { return (1.0 - rests.share()) * weight / sum_of_weights(); }
};

bool tapers(const Division& end, const Division& middle) {
  return end.weights != middle.weights || end.open.left.count != middle.open.left.count ||
         end.open.right.count != middle.open.right.count || end.open.both_ways != middle.open.both_ways ||
         end.rests.left.share != middle.rests.left.share || end.rests.right.share != middle.rests.right.share ||
         end.rests.left_cycles.share != middle.rests.left_cycles.share ||
         end.rests.right_cycles.share != middle.rests.right_cycles.share ||
         ((end.shift || middle.shift) && end.centre_share() != middle.centre_share());
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

/// Untagged: one lane for each direction.
bool has_one_lane(const RoadPath& path, double width_m) {
  constexpr std::string_view narrow[] = {"unclassified", "residential", "road", "living_street", "service", "track"};
  return path.roundabout ? width_m < one_lane_ring_m : is_one_of(path.highway, narrow);
}

/// A lane of a direction as the tags tell of it.
struct ToldLane {
  std::string use;       ///< the word for its users
  double width_m = 0.0;  ///< 0: not told
  [[nodiscard]] bool is_for_cars() const { return use.empty(); }
};
/// From the inside out.
using ToldLanes = std::vector<ToldLane>;

LaneUse use_of_word(std::string_view word, LaneType for_cars) {
  if (word == "psv") return {LaneType::bus, {"bus", "taxi"}};
  if (word == "bus") return {LaneType::bus, {"bus"}};
  if (word == "taxi") return {LaneType::taxi, {"taxi"}};
  if (word == "bicycle") return {LaneType::biking, {"bicycle"}};
  if (word == "none") return {LaneType::other, {}};
  return {for_cars, {}};
}

double told_width_m(std::string_view word) { return std::strtod(std::string(word).c_str(), nullptr); }

/// What the lists of a direction say, from the inside out; `otherwise` uses every lane where they say nothing.
ToldLanes listed_lanes(const std::string& uses, const std::string& widths, int lanes, const std::string& otherwise,
                       DrivingSide driving_side) {
  ToldLanes told(static_cast<std::size_t>(lanes), ToldLane{otherwise});
  const std::vector<std::string_view> use_words = lane_words(uses), width_words = lane_words(widths);
  for (std::size_t i = 0; i < told.size(); ++i) {
    if (use_words.size() == told.size()) told[i].use = use_words[i];
    if (width_words.size() == told.size()) told[i].width_m = told_width_m(width_words[i]);
  }
  if (driving_side == DrivingSide::left) std::reverse(told.begin(), told.end());
  return told;
}

/// A lane at the outside (or the inside) of a direction becomes one of that kind. A direction keeps a lane for cars: it
/// gets one more where it has one alone.
void give_away(ToldLanes& lanes, const std::string& kind, bool outside) {
  const auto cars = std::ranges::count_if(lanes, &ToldLane::is_for_cars);
  if (cars == 0) return;
  if (cars == 1) {
    lanes.insert(outside ? lanes.end() : lanes.begin(), ToldLane{kind});
    return;
  }
  if (outside)
    std::find_if(lanes.rbegin(), lanes.rend(), [](const ToldLane& lane) { return lane.is_for_cars(); })->use = kind;
  else
    std::ranges::find_if(lanes, &ToldLane::is_for_cars)->use = kind;
}

/// Bus lanes that side_lanes names, in the lanes of both directions.
void give_side_lanes(const RoadPath& path, DrivingSide driving_side, ToldLanes& forward, ToldLanes& backward) {
  const bool one_way = path.oneway == Oneway::forward, left_hand = driving_side == DrivingSide::left;
  for (const std::string_view word : side_lanes_of(path)) {
    const std::size_t colon = std::min(word.find(':'), word.size());
    const std::string kind(word.substr(0, colon));
    const std::string_view side = word.substr(std::min(colon + 1, word.size()));
    if (kind == "bicycle") continue;
    if (side == "along" || side == "against") {
      give_away(side == "along" ? forward : backward, kind, true);
      continue;
    }
    const bool of_forward = one_way || (side == "left") == left_hand;
    give_away(of_forward ? forward : backward, kind, !one_way || (side == "left") == left_hand);
  }
}

/// Lanes of both directions as the tags have them, or as the width has room for.
std::pair<int, int> lane_numbers(const RoadPath& path, double median_width_m) {
  const bool one_way = path.oneway == Oneway::forward;
  if (path.lanes > 0 || path.lanes_forward > 0 || path.lanes_backward > 0) {
    const int lanes = std::max(path.lanes - path.lanes_both_ways, path.lanes_forward + path.lanes_backward);
    if (one_way) return {std::max(1, lanes - path.lanes_backward), path.lanes_backward};
    const int forward = path.lanes_forward > 0    ? path.lanes_forward
                        : path.lanes_backward > 0 ? lanes - path.lanes_backward
                                                  : (lanes + 1) / 2;
    return {std::max(1, forward), std::max(1, path.lanes_backward > 0 ? path.lanes_backward : lanes - forward)};
  }
  if (has_one_lane(path, median_width_m)) return {1, one_way ? 0 : 1};
  const bool fast = is_fast_class(path.highway);
  const double lane_m = one_way ? (fast ? fast_lane_m : one_way_lane_m) : two_way_lane_m;
  const double lanes_m = one_way ? median_width_m - (fast ? fast_rests_m : 0.0) : 0.5 * median_width_m;
  const int forward = std::clamp(static_cast<int>(lanes_m / lane_m), 1, max_untagged_lanes);
  return {forward, one_way ? 0 : forward};
}

std::vector<LaneUse> uses_of(const ToldLanes& lanes) {
  if (std::ranges::all_of(lanes, &ToldLane::is_for_cars)) return {};
  std::vector<LaneUse> uses;
  for (const ToldLane& lane : lanes) uses.push_back(use_of_word(lane.use, LaneType::driving));
  return uses;
}

std::vector<double> widths_of(const ToldLanes& lanes) {
  std::vector<double> widths;
  for (const ToldLane& lane : lanes) widths.push_back(lane.width_m);
  return widths;
}

/// Of the lanes for both directions, the innermost ones on the side of the forward lanes.
std::vector<double> both_widths(const RoadPath& path, int lanes, DrivingSide driving_side) {
  std::vector<double> widths;
  for (const std::string_view word : lane_words(path.widths_both_ways)) widths.push_back(told_width_m(word));
  if (driving_side == DrivingSide::left) std::reverse(widths.begin(), widths.end());
  if (lane_words(path.widths_both_ways).size() < static_cast<std::size_t>(lanes)) widths.clear();
  widths.resize(static_cast<std::size_t>(lanes));
  return widths;
}

/// Nothing where no lane's width is told.
LaneWeights told_of(LaneWeights told) {
  double sum = 0.0;
  for (const auto* side : {&told.left, &told.right, &told.both_ways})
    for (const double width_m : *side) sum += width_m;
  return sum > 0.0 ? std::move(told) : LaneWeights{};
}

}  // namespace

int LaneLayout::main_lanes(bool of_left) const {
  const auto cars = [this](bool side) {
    int count = 0;
    for (int i = 0; i < (side ? left : right); ++i) count += use(side, i).type == LaneType::driving ? 1 : 0;
    return count;
  };
  if (is_shared()) return both_ways;
  return cars(true) + cars(false) > 0 ? cars(of_left) : of_left ? left : right;
}

RoadEndLanes all_open(const LaneLayout& layout) { return {{0, layout.left}, {0, layout.right}, layout.both_ways}; }

LaneLayout lane_layout(const RoadPath& path, double median_width_m, DrivingSide driving_side) {
  const bool one_way = path.oneway == Oneway::forward;
  LaneLayout layout;
  const auto fits = [&](std::size_t lanes) { return static_cast<double>(lanes) * min_tagged_lane_m <= median_width_m; };
  if (const int shared = shared_lanes(path); shared > 0) {
    layout = {.left = 0, .right = 0, .both_ways = shared, .both_use = use_of_word(path.use, LaneType::bidirectional)};
    while (layout.both_ways > 1 && !fits(static_cast<std::size_t>(layout.both_ways)))
      --layout.both_ways, layout.reduced = true;
    layout.told_m = told_of({{}, {}, both_widths(path, layout.both_ways, driving_side)});
    return layout;
  }
  const auto [lanes_forward, lanes_backward] = lane_numbers(path, median_width_m);
  ToldLanes forward = listed_lanes(path.use_forward, path.widths_forward, lanes_forward, path.use, driving_side);
  ToldLanes backward = listed_lanes(path.use_backward, path.widths_backward, lanes_backward,
                                    one_way && path.use.empty() ? "none" : path.use, driving_side);
  const std::size_t tagged = forward.size() + backward.size();
  give_side_lanes(path, driving_side, forward, backward);
  layout.both_ways = one_way ? 0 : path.lanes_both_ways;
  const bool is_tagged =
      path.lanes > 0 || path.lanes_forward > 0 || path.lanes_backward > 0 || tagged != forward.size() + backward.size();
  // Two lanes of a narrow road that is used both ways stay: cars meet there at walking pace.
  const std::size_t least = one_way ? 1 : 2, least_backward = one_way ? 0 : 1;
  const auto total = [&] { return forward.size() + backward.size() + static_cast<std::size_t>(layout.both_ways); };
  while (is_tagged && total() > least && !fits(total())) {
    layout.reduced = true;
    if (layout.both_ways > 0 && forward.size() + backward.size() <= least)
      --layout.both_ways;
    else if (backward.size() > least_backward && (backward.size() > forward.size() || forward.size() == 1))
      backward.pop_back();
    else
      forward.pop_back();
  }
  const bool left_hand = driving_side == DrivingSide::left;
  const ToldLanes &left = left_hand ? forward : backward, &right = left_hand ? backward : forward;
  layout.left = static_cast<int>(left.size()), layout.right = static_cast<int>(right.size());
  layout.left_uses = uses_of(left), layout.right_uses = uses_of(right);
  layout.told_m = told_of({widths_of(left), widths_of(right), both_widths(path, layout.both_ways, driving_side)});
  return layout;
}

double LaneLayout::told_sum_m() const {
  double sum = 0.0;
  for (const auto* side : {&told_m.left, &told_m.right, &told_m.both_ways})
    for (const double width_m : *side) {
      if (width_m <= 0.0) return 0.0;
      sum += width_m;
    }
  return sum;
}

LaneWeights lane_weights(const LaneLayout& layout, const LaneRests& rests, double median_width_m) {
  LaneWeights weights = layout.told_m;
  double left_m = (1.0 - rests.share()) * median_width_m;
  int untold = 0;
  for (const auto* side : {&weights.left, &weights.right, &weights.both_ways})
    for (const double width_m : *side) left_m -= width_m, untold += width_m > 0.0 ? 0 : 1;
  if (untold == 0) return weights;
  const double each_m = std::max(min_tagged_lane_m, left_m / untold);
  for (auto* side : {&weights.left, &weights.right, &weights.both_ways})
    for (double& width_m : *side)
      if (width_m <= 0.0) width_m = each_m;
  return weights;
}

int first_own_lane(const LaneLayout& layout, bool left, DrivingSide driving_side) {
  return left == (driving_side == DrivingSide::left) ? layout.both_ways : 0;
}

std::optional<double> placed_shift(const RoadPath& path, const LaneLayout& layout, const RoadEndLanes& open,
                                   const LaneRests& rests, const LaneWeights& weights, double along,
                                   DrivingSide driving_side) {
  const Placement& placement = path.placement;
  if (!placement.is_told() || layout.is_shared()) return std::nullopt;
  const double start = placement.start >= 0.0 ? placement.start : placement.end,
               end = placement.end >= 0.0 ? placement.end : placement.start;
  const bool left_hand = driving_side == DrivingSide::left, on_left = placement.backward != left_hand;
  const Division division{open, rests, weights, std::nullopt, left_hand};
  const double lanes = on_left ? layout.left : layout.right, told = std::min(start + along * (end - start), lanes);
  // Lanes between the line and the centre lane: drivers count from the inside where one drives on the right.
  const double inner = left_hand ? lanes - told : told;
  double share = 0.0;
  for (int i = 0; i < static_cast<int>(lanes); ++i)
    share += std::clamp(inner - i, 0.0, 1.0) * division.share_of(i, on_left);
  if (!placement.backward) share += division.both_share();
  return on_left ? -share : share;
}

double least_carriageway_m(const RoadPath& path, double curvature_1pm) {
  if (path.oneway == Oneway::no && shared_lanes(path) != 1) return 2.0 * min_lane_m;
  // With the middle of the wheelbase on a circle the rear axle runs wheelbase^2 / 8 R within, the front axle three
  // times that without.
  return min_tagged_lane_m + 0.5 * wheelbase_m * wheelbase_m * std::abs(curvature_1pm);
}

RoadNetwork with_lane_room(RoadNetwork roads, Findings& findings) {
  for (RoadPath& path : roads.paths) {
    const double least_m = least_carriageway_m(path);
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
        if (roadquery::is_driven(lane.type) && !lane.materials.empty()) return lane.materials.front().surface;
  return SurfaceClass::asphalt;
}

LaneMatch match_lanes(int from, int to, int inner) {
  const int count = std::min(from, to);
  const int opened = to - count;
  return {{0, count}, {std::min(inner, opened), count}};
}

namespace {
/// Builds the lanes of a road's one section.
class SectionBuilder {
 public:
  SectionBuilder(const Road& road, const LaneLayout& layout, std::span<const ProfileSample> widths,
                 const LaneOptions& options)
      : layout_(layout),
        options_(options),
        both_on_left_(road.driving_side == roadquery::DrivingSide::left),
        middle_{all_open(layout), options.rests, options.weights, options.shift.middle, both_on_left_},
        start_{options.start.value_or(middle_.open), options.start_rests.value_or(options.rests),
               options.start_weights.value_or(options.weights), options.shift.start, both_on_left_},
        end_{options.end.value_or(middle_.open), options.end_rests.value_or(options.rests),
             options.end_weights.value_or(options.weights), options.shift.end, both_on_left_},
        carriageway_(fit_profile(widths, {.tolerance = options.tolerance_m, .level_ends = true}).cubics, road.length,
                     tapers(start_, middle_), tapers(end_, middle_)),
        marks_(markings_of(road.highway, layout, widths[widths.size() / 2].value)) {}

  void add_to(Road& road) const {
    roadquery::LaneSection section;
    section.center.type = LaneType::none;
    section.center.marks.push_back(centre_mark(marks_, layout_));
    add_side(section.left, true, layout_.left);
    add_side(section.right, false, layout_.right);
    road.sections.push_back(std::move(section));
    const auto offset = share([](const Division& d) { return d.centre_share(); });
    if (offset.start != 0.0 || offset.middle != 0.0 || offset.end != 0.0) road.lane_offset = carriageway_.part(offset);
  }

 private:
  template <typename ShareAt>
  [[nodiscard]] Share share(const ShareAt& at) const {
    return {at(start_), at(middle_), at(end_)};
  }
  static int next_id(const std::vector<Lane>& lanes, bool left) {
    return (left ? 1 : -1) * (static_cast<int>(lanes.size()) + 1);
  }
  void add_lane(std::vector<Lane>& lanes, bool left, const LaneUse& use, const Share& share) const {
    Lane lane{.id = next_id(lanes, left), .type = use.type, .allowed = use.allowed};
    lane.width = carriageway_.part(share);
    lanes.push_back(std::move(lane));
  }
  /// Between the lanes of a side, and along its edge.
  void mark(std::vector<Lane>& lanes) const {
    for (std::size_t i = 0; i < lanes.size(); ++i) {
      const bool outermost = i + 1 == lanes.size();
      const bool other_traffic = !outermost && lanes[i].type != lanes[i + 1].type;
      lanes[i].marks.push_back(outermost       ? (marks_.edges ? RoadMark{0.0, "solid", marks_.edge_m} : no_mark())
                               : other_traffic ? RoadMark{0.0, "solid", marks_.line_m}
                               : marks_.lanes  ? RoadMark{0.0, "broken", marks_.line_m}
                                               : no_mark());
    }
  }
  void add_side(std::vector<Lane>& lanes, bool left, int count) const {
    if (left == both_on_left_)
      for (int i = 0; i < layout_.both_ways; ++i)
        add_lane(lanes, left, layout_.both_use, share([i](const Division& d) { return d.both_share_of(i); }));
    for (int i = 0; i < count; ++i)
      add_lane(lanes, left, layout_.use(left, i), share([=](const Division& d) { return d.share_of(i, left); }));
    const LaneRest &cycles = left ? options_.rests.left_cycles : options_.rests.right_cycles,
                   &rest = left ? options_.rests.left : options_.rests.right;
    if (cycles.exists())
      add_lane(lanes, left, {cycles.type, {}}, share([left](const Division& d) { return d.cycle_share(left); }));
    mark(lanes);
    if (rest.exists())
      lanes.push_back(side_lane(next_id(lanes, left), rest.type,
                                carriageway_.part(share([left](const Division& d) { return d.rest_share(left); }))));
    if (!has_side(options_.sidewalk, left ? Sides::left : Sides::right)) return;
    if (!lanes.empty() && lanes.back().marks.front().type == "none") lanes.back().marks.front() = {0.0, "curb", 0.15};
    lanes.push_back(side_lane(next_id(lanes, left), LaneType::sidewalk, {Cubic{.a = sidewalk_m}}));
  }

  const LaneLayout& layout_;
  const LaneOptions& options_;
  bool both_on_left_;
  Division middle_, start_, end_;
  Carriageway carriageway_;
  Markings marks_;
};
}  // namespace

void add_lanes(Road& road, const LaneLayout& layout, std::span<const ProfileSample> widths,
               const LaneOptions& options) {
  SectionBuilder(road, layout, widths, options).add_to(road);
}

void set_lane_speeds(Road& road, const RoadPath& path) {
  const bool left_hand = road.driving_side == roadquery::DrivingSide::left;
  for (const bool forward : {true, false}) {
    std::vector<double> limits;
    for (const std::string_view text : lane_words(forward ? path.speeds_forward : path.speeds_backward))
      limits.push_back(text.empty() ? 0.0 : std::strtod(std::string(text).c_str(), nullptr) / kmh_per_mps);
    if (limits.empty()) continue;
    if (left_hand) std::reverse(limits.begin(), limits.end());
    std::vector<Lane*> lanes;
    for (Lane& lane : forward == left_hand ? road.sections.front().left : road.sections.front().right)
      if (lane.type == LaneType::driving || lane.type == LaneType::bus || lane.type == LaneType::taxi)
        lanes.push_back(&lane);
    if (limits.size() > 1 && limits.size() != lanes.size()) continue;
    for (std::size_t i = 0; i < lanes.size(); ++i)
      if (const double limit = limits[limits.size() > 1 ? i : 0]; limit > 0.0) lanes[i]->speeds = {{0.0, limit}};
  }
}

std::vector<int> lanes_of_direction(const Road& road, bool forward) {
  const bool right = forward != (road.driving_side == roadquery::DrivingSide::left);
  const roadquery::LaneSection& section = road.sections.front();
  const auto ids_of = [](const std::vector<Lane>& lanes, auto&& is_of) {
    std::vector<int> ids;
    for (const Lane& lane : lanes)
      if (is_of(lane.type)) ids.push_back(lane.id);
    return ids;
  };
  const auto is_car = [](LaneType type) { return type == LaneType::driving; };
  const auto is_both = [](LaneType type) { return type == LaneType::bidirectional; };
  const auto is_vehicle = [](LaneType type) {
    return type == LaneType::bus || type == LaneType::taxi || type == LaneType::biking || type == LaneType::other;
  };
  const std::vector<Lane>&own = right ? section.right : section.left, &others = right ? section.left : section.right;
  std::vector<int> ids = ids_of(own, is_car);
  if (!ids.empty() || !ids_of(others, is_car).empty()) return ids;
  ids = ids_of(own, is_both);
  if (!ids.empty()) return ids;
  ids = ids_of(others, is_both);
  std::reverse(ids.begin(), ids.end());  // from the inside of those that drive against the road
  return ids.empty() ? ids_of(own, is_vehicle) : ids;
}

std::vector<unsigned> turn_lanes(const RoadPath& path, bool forward, DrivingSide driving_side) {
  const std::string& tag = forward ? path.turn_forward : path.turn_backward;
  const std::vector<std::string_view> turns = lane_words(tag),
                                      uses = lane_words(forward ? path.use_forward : path.use_backward);
  std::vector<unsigned> lanes;
  for (std::size_t i = 0; i < turns.size(); ++i)
    if (uses.size() != turns.size() || uses[i].empty()) lanes.push_back(turn_bits(turns[i]));
  if (driving_side == DrivingSide::left)
    std::reverse(lanes.begin(), lanes.end());  // from left to right is from the outside in there
  return lanes;
}

}  // namespace orthodrive::network
