// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/network/paint/gores.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <utility>

#include "orthodrive/network/lanes/lanes.hpp"
#include "orthodrive/network/paint/waiting_lines.hpp"
#include "roadquery/surface/road_surface.hpp"

namespace orthodrive::network {
namespace {

using roadquery::Lane;
using roadquery::LaneType;
using roadquery::Road;
using roadquery::RoadMap;

constexpr double gore_step_m = 1.0, corner_step_m = 4.0;
constexpr double gore_side_cos = 0.866, apart_at_junction_m = 1.5;
constexpr double least_mark_m = 0.3;  // narrower parts are paved only
constexpr double least_gore_width_m = 0.8, least_length_m = 6.0, same_gore_height_m = 0.3;
constexpr double flush_gore_m = 0.02;  // higher steps between both surfaces are left to a bank
constexpr double nose_m = 3.0;         // over which the lanes end
constexpr double opening = 0.5;        // m a metre, where the edges part at once
constexpr double nearest_m = 30.0;     // between the ends of both roads

/// One of the two roads, seen from the junction outwards.
struct GoreArm {
  std::size_t road = 0;
  bool at_end = false;  ///< the road's end touches the junction
  bool left = false;    ///< the side of the road that faces the other one

  [[nodiscard]] double s_at(const Road& of, double out_m) const { return at_end ? of.length - out_m : out_m; }
};

roadquery::PlanPoint outwards(const Road& road, const GoreArm& arm, double out_m) {
  roadquery::PlanPoint p = roadquery::reference_point(road, arm.s_at(road, out_m));
  if (arm.at_end) p.hdg += std::numbers::pi;
  return p;
}

double edge_t(const Road& road, bool left, double s) {
  const roadquery::Edges edges = roadquery::road_edges(road, s);
  return left ? edges.left_t : edges.right_t;
}

/// Between both facing edges.
struct Gap {
  double width_m = 0.0;  ///< negative where the roads lie on each other
  double step_m = 0.0;   ///< at the other road's edge between its surface and the own one, carried on
  [[nodiscard]] bool is_flush() const { return step_m < flush_gore_m; }
  /// How much of it the own road paves: all of it, or as much as leaves a bank.
  [[nodiscard]] double paved_m() const {
    return is_flush() ? std::max(0.0, width_m) : std::max(0.0, 0.5 * width_m - step_m);
  }
};

/// At places step_m apart from the junction outwards, as long as both roads are there at one height. Where the other
/// road ends on the way, the last ones are left out: lanes have ended before.
std::vector<Gap> gaps_of(const Road& own, const GoreArm& own_arm, const Road& other, const GoreArm& other_arm) {
  std::vector<Gap> gaps;
  double other_s = other_arm.s_at(other, 0.0);
  const double most_m = std::min(own.length, longest_gore_m + nose_m);
  for (double out_m = 0.0; out_m <= most_m; out_m += gore_step_m) {
    const double s = own_arm.s_at(own, out_m);
    const auto edge = roadquery::surface_point(own, s, edge_t(own, own_arm.left, s));
    roadquery::PlanPoint foot;
    double beyond_m = 0.0;
    for (int i = 0; i < 8; ++i) {
      foot = roadquery::reference_point(other, other_s);
      const double along = std::cos(foot.hdg) * (edge.x - foot.x) + std::sin(foot.hdg) * (edge.y - foot.y);
      const double next = std::clamp(other_s + along, 0.0, other.length);
      beyond_m = std::abs(other_s + along - next);
      if (std::abs(next - other_s) < 1e-4) break;
      other_s = next;
    }
    if (beyond_m > gore_step_m) {
      if (gaps.empty()) continue;  // the other road begins further out
      gaps.resize(gaps.size() - std::min(gaps.size(), static_cast<std::size_t>(nose_m / gore_step_m)));
      break;
    }
    const double left_m = std::cos(foot.hdg) * (edge.y - foot.y) - std::sin(foot.hdg) * (edge.x - foot.x);
    const double other_t = edge_t(other, other_arm.left, other_s);
    const double other_z = roadquery::surface_height(other, other_s, other_t);
    if (std::abs(other_z - edge.z) > same_gore_height_m) break;
    while (static_cast<double>(gaps.size()) * gore_step_m < out_m - 0.5 * gore_step_m) gaps.push_back({-1.0, 0.0});
    const double width_m = other_arm.left ? left_m - other_t : other_t - left_m;
    const double beyond_t = edge_t(own, own_arm.left, s) + (own_arm.left ? width_m : -width_m);
    gaps.push_back({width_m, std::abs(other_z - roadquery::surface_height(own, s, beyond_t))});
    if (width_m > widest_gore_m + 1.0) break;
  }
  return gaps;
}

/// Indices of gaps: where the edges part, and the last place that belongs to the gore.
struct Extent {
  std::size_t first = 0, last = 0;
};

std::optional<Extent> extent_of(const std::vector<Gap>& gaps) {
  if (gaps.empty() || gaps.front().width_m > apart_at_junction_m) return std::nullopt;
  std::size_t last = 0;
  while (last + 1 < gaps.size() && gaps[last + 1].width_m <= widest_gore_m &&
         static_cast<double>(last + 1) * gore_step_m <= longest_gore_m)
    ++last;
  std::size_t first = last;
  while (first > 0 && gaps[first - 1].width_m > 0.0) --first;
  if (gaps[last].width_m < least_gore_width_m || static_cast<double>(last - first) * gore_step_m < least_length_m)
    return std::nullopt;
  return Extent{first, last};
}

bool is_one_way(const Road& road, bool at_end, bool out) {
  return !lanes_of_direction(road, out != at_end).empty() && lanes_of_direction(road, out == at_end).empty();
}

bool has_sidewalk(const Road& road, bool left) {
  return std::ranges::any_of(left ? road.sections.front().left : road.sections.front().right,
                             [](const Lane& lane) { return lane.type == LaneType::sidewalk; });
}

/// Widths of a road's gore lane at places step_m apart.
using WidthsBySide = std::map<std::pair<std::size_t, bool>, std::vector<double>>;  ///< by road and side

class GoreBuilder {
 public:
  GoreBuilder(const NetworkPlan& plan, RoadMap& map) : plan_(plan), map_(map) {}

  void add(const JunctionEnd& a, const JunctionEnd& b) {
    const Road &road_a = road_of(a), &road_b = road_of(b);
    if (a.road == b.road || !is_fit(a) || !is_fit(b)) return;
    const bool out = is_one_way(road_a, a.at_end, true);
    if (!is_one_way(road_a, a.at_end, out) || !is_one_way(road_b, b.at_end, out)) return;
    const int rank_a = rank_of(plan_, a), rank_b = rank_of(plan_, b);
    const bool a_is_main = rank_a > rank_b || (rank_a == rank_b && width_m(a) >= width_m(b));
    add_between(a_is_main ? a : b, a_is_main ? b : a);
  }

  void finish() {
    for (const auto& [key, widths] : widths_) add_lane(map_.roads[key.first], key.second, widths);
  }

 private:
  [[nodiscard]] const Road& road_of(const JunctionEnd& end) const {
    return map_.roads[static_cast<std::size_t>(end.road)];
  }
  [[nodiscard]] bool is_fit(const JunctionEnd& end) const {
    const Road& road = road_of(end);
    const int rank = rank_of(plan_, end);
    return rank >= road_rank("tertiary_link") && rank < ring_rank && !road.bridge && !road.tunnel &&
           road.sections.size() == 1;
  }
  [[nodiscard]] double width_m(const JunctionEnd& end) const {
    const Road& road = road_of(end);
    const roadquery::Edges edges = roadquery::road_edges(road, end.at_end ? road.length : 0.0);
    return edges.left_t - edges.right_t;
  }

  void add_between(const JunctionEnd& main_end, const JunctionEnd& slip_end) {
    const Road &main = road_of(main_end), &slip = road_of(slip_end);
    GoreArm main_arm{static_cast<std::size_t>(main_end.road), main_end.at_end, false},
        slip_arm{static_cast<std::size_t>(slip_end.road), slip_end.at_end, false};
    const auto p = outwards(main, main_arm, 0.0), q = outwards(slip, slip_arm, 0.0);
    if (std::cos(p.hdg - q.hdg) < gore_side_cos || std::hypot(q.x - p.x, q.y - p.y) > nearest_m) return;
    // Seen outwards the slip road lies on that side of the main road, where it goes.
    const auto far = outwards(slip, slip_arm, std::min(slip.length, 20.0));
    const bool is_left = std::cos(p.hdg) * (far.y - p.y) - std::sin(p.hdg) * (far.x - p.x) > 0.0;
    main_arm.left = is_left != main_arm.at_end, slip_arm.left = is_left == slip_arm.at_end;
    if (has_sidewalk(main, main_arm.left) || has_sidewalk(slip, slip_arm.left)) return;
    const std::vector<Gap> beside_slip = gaps_of(slip, slip_arm, main, main_arm);
    const auto extent = extent_of(beside_slip);
    const std::vector<Gap> beside_main = gaps_of(main, main_arm, slip, slip_arm);
    const auto main_extent = extent_of(beside_main);
    if (!extent || !main_extent) return;
    add_widths(slip, slip_arm, beside_slip, *extent);
    add_widths(main, main_arm, beside_main, *main_extent);
    add_mark(slip, slip_arm, beside_slip, *extent);
  }

  void add_widths(const Road& road, const GoreArm& arm, const std::vector<Gap>& gaps, const Extent& extent) {
    std::vector<double>& widths = widths_[{arm.road, arm.left}];
    const int steps = std::max(1, static_cast<int>(std::ceil(road.length / gore_step_m)));
    widths.resize(static_cast<std::size_t>(steps) + 1, 0.0);
    const double first_m = static_cast<double>(extent.first) * gore_step_m,
                 last_m = static_cast<double>(extent.last) * gore_step_m;
    for (int i = 0; i <= steps; ++i) {
      const double s = road.length * i / steps, out_m = arm.at_end ? road.length - s : s;
      if (out_m < first_m || out_m > last_m + nose_m) continue;
      const double at = std::min(out_m, last_m) / gore_step_m;
      const auto k = std::min(static_cast<std::size_t>(at), gaps.size() - 2);
      const double share = at - static_cast<double>(k);
      const Gap gap{gaps[k].width_m + share * (gaps[k + 1].width_m - gaps[k].width_m),
                    gaps[k].step_m + share * (gaps[k + 1].step_m - gaps[k].step_m)};
      double width = gap.paved_m() + (gap.is_flush() ? gore_overlap_m : 0.0);
      if (extent.first > 0) width = std::min(width, opening * (out_m - first_m));
      width *= std::clamp((last_m + nose_m - out_m) / nose_m, 0.0, 1.0);
      widths[static_cast<std::size_t>(i)] = std::max(widths[static_cast<std::size_t>(i)], width);
    }
  }

  void add_mark(const Road& of, const GoreArm& arm, const std::vector<Gap>& gaps, const Extent& extent) {
    std::vector<std::size_t> places;
    const auto every = static_cast<std::size_t>(corner_step_m / gore_step_m);
    std::size_t first = extent.first;
    while (first < extent.last && gaps[first].width_m < least_mark_m) ++first;
    for (std::size_t i = first; i < extent.last; i += every) places.push_back(i);
    places.push_back(extent.last);
    roadquery::RoadObject mark{.type = "roadMark", .subtype = "hatchedArea", .name = gore_mark};
    double low_s = of.length, high_s = 0.0, low_t = 1e9, high_t = -1e9;
    const auto add_corner = [&](std::size_t i, double off_m) {
      const double s = arm.s_at(of, static_cast<double>(i) * gore_step_m);
      const double t = edge_t(of, arm.left, s) + (arm.left ? off_m : -off_m);
      low_s = std::min(low_s, s), high_s = std::max(high_s, s), low_t = std::min(low_t, t),
      high_t = std::max(high_t, t);
      mark.outline.push_back({s, t});
    };
    for (const std::size_t i : places) add_corner(i, 0.0);
    for (auto i = places.rbegin(); i != places.rend(); ++i) add_corner(*i, gaps[*i].paved_m());
    mark.s = 0.5 * (low_s + high_s), mark.t = 0.5 * (low_t + high_t);
    mark.length = high_s - low_s, mark.width = high_t - low_t;
    marks_[arm.road].push_back(std::move(mark));
  }

  void add_lane(Road& road, bool left, const std::vector<double>& widths) {
    std::vector<Lane>& lanes = left ? road.sections.front().left : road.sections.front().right;
    const int number = static_cast<int>(lanes.size()) + 1;
    Lane lane{.id = left ? number : -number, .type = LaneType::other};
    const double apart_m = road.length / static_cast<double>(widths.size() - 1);
    for (std::size_t i = 0; i + 1 < widths.size(); ++i) {
      const double slope = (widths[i + 1] - widths[i]) / apart_m;
      constexpr double same_slope = 1e-9;
      if (!lane.width.empty() && std::abs(lane.width.back().b - slope) < same_slope) continue;
      lane.width.push_back({static_cast<double>(i) * apart_m, widths[i], slope, 0.0, 0.0});
    }
    for (const auto* side : {&road.sections.front().right, &road.sections.front().left})
      for (const Lane& driven : *side)
        if (roadquery::is_driven(driven.type) && lane.materials.empty()) lane.materials = driven.materials;
    lane.marks.push_back({0.0, "none", 0.0});
    lanes.push_back(std::move(lane));
    auto& marks = marks_[static_cast<std::size_t>(&road - map_.roads.data())];
    road.objects.insert(road.objects.end(), marks.begin(), marks.end());
    marks.clear();
  }

  const NetworkPlan& plan_;
  RoadMap& map_;
  WidthsBySide widths_;
  std::map<std::size_t, std::vector<roadquery::RoadObject>> marks_;  ///< by road
};

}  // namespace

void add_gores(const NetworkPlan& plan, const std::vector<std::vector<JunctionEnd>>& ends, RoadMap& map) {
  GoreBuilder builder(plan, map);
  for (const std::vector<JunctionEnd>& junction : ends)
    for (std::size_t i = 0; i < junction.size(); ++i)
      for (std::size_t k = i + 1; k < junction.size(); ++k) builder.add(junction[i], junction[k]);
  builder.finish();
}

}  // namespace orthodrive::network
