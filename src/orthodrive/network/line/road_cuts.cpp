// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/network/line/road_cuts.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <tuple>
#include <utility>

#include "orthodrive/network/lanes/lanes.hpp"
#include "roadquery/surface/road_surface.hpp"

namespace orthodrive::network {
namespace {

constexpr double min_part_m = 0.5;   // shorter pieces of way are left to the road before or behind them
constexpr double min_lanes_m = 5.0;  // the same where numbers of lanes change: none can begin or end in less
constexpr double min_split_m = 0.8;  // shorter roads are not divided
constexpr double sample_m = 2.0;     // step of polylines: SUMO's default
// SUMO warns below 9 m; a car at walking pace turns with 5 - 6 m.
constexpr double calm_radius_m = 14.0;
constexpr double flat_turn_rad = std::numbers::pi / 180.0;  // less does not show
// Between two roads the line goes on: they should not meet in or right beside a corner either.
constexpr double corner_reach_m = 8.0, calm_joint_radius_m = 24.0;
constexpr double fold_margin = 1.5, long_rest_m = 1.4;
constexpr double element_reach_m = 5.0;  // so far a cut goes to lie where an element ends: then none is cut in two
constexpr double cut_step_m = 0.25;
constexpr double min_road_m = 3.0;  // shorter ones are hardly shortened further
constexpr double short_road_reach_m = 0.5;
constexpr double dead_end_m = 3.0;  // a dead end may become this much shorter
constexpr double outwards_m = 15.0, along_m = 25.0;
constexpr double abutment_m = 1.0;  // bridges and tunnels begin where they begin

/// How a road lies on its chain.
struct RoadSide {
  bool reversed = false;  ///< it runs against the chain
  double offset_m = 0.0;  ///< of the inner edge of its lanes, to the left of the chain
};

/// The last three vertices of a road from s0 to s1 as a polyline that has each element's ends and a vertex every 2 m
/// from its start, as seen from the end `at_s1` (or s0) inwards.
std::array<Vec2, 3> end_vertices(const std::vector<roadquery::PlanElement>& plan, double s0, double s1, bool at_s1,
                                 const RoadSide& road) {
  const bool reversed = road.reversed;
  std::array<Vec2, 3> vertices;
  std::size_t count = 0;
  const auto add = [&](double s) {
    if (count >= vertices.size()) return;
    const Pose pose = pose_at(plan, std::clamp(s, s0, s1));
    vertices[count++] = pose.p + left_normal(pose.direction) * road.offset_m;
  };
  const double end = at_s1 ? s1 : s0, inwards = at_s1 ? -1.0 : 1.0;
  auto element = std::upper_bound(plan.begin() + 1, plan.end(), end + (at_s1 ? -1e-6 : 1e-6),
                                  [](double s, const roadquery::PlanElement& e) { return s < e.s; }) -
                 1;
  add(end);
  while (count < vertices.size()) {
    const double a = std::max(s0, element->s), b = std::min(s1, element->s + element->length);
    const double first = at_s1 ? b : a, last = at_s1 ? a : b;
    if (!std::holds_alternative<roadquery::Line>(element->shape)) {
      // Counted from the element's start in the road's direction: what is left over lies at its end.
      const double rest = std::fmod(b - a, sample_m);
      const bool rest_here = at_s1 != reversed;
      for (double d = rest_here && rest > 1e-6 ? rest : sample_m; d < b - a - 1e-6 && count < vertices.size();
           d += sample_m)
        add(first + inwards * d);
    }
    add(last);
    if (last == (at_s1 ? s0 : s1)) break;
    if (at_s1 ? element == plan.begin() : element + 1 == plan.end()) break;
    element += at_s1 ? -1 : 1;
  }
  while (count < vertices.size()) vertices[count++] = vertices[1] * 2.0 - vertices[0];  // one segment: straight on
  return vertices;
}

/// Radius of the turn at the end of a road that such a polyline shows.
double end_radius_m(const std::vector<roadquery::PlanElement>& plan, double s0, double s1, bool at_s1,
                    const RoadSide& road) {
  const auto [a, b, c] = end_vertices(plan, s0, s1, at_s1, road);
  const double turn = std::abs(std::atan2(cross(b - a, c - b), dot(b - a, c - b)));
  return turn < flat_turn_rad ? INFINITY : distance(a, b) / std::tan(0.5 * turn);
}

/// Roads of one stretch while their cuts are found.
class StretchCuts {
 public:
  StretchCuts(const RoadNetwork& roads, const Topology& topology, const ChainGeometry& geometry, const Stretch& stretch,
              DrivingSide driving_side)
      : driving_side_(driving_side),
        roads_(roads),
        topology_(topology),
        geometry_(geometry),
        chain_(topology.chains[stretch.chain]),
        stretch_(stretch) {
    const double begin = stretch.s0 + stretch.trim0_m, end = stretch.s1 - stretch.trim1_m;
    cuts_.push_back(begin);
    for (std::size_t k = 1; k + 1 < geometry.vertex_s.size(); ++k) {
      const double s = geometry.vertex_s[k],
                   least_m = have_same_lanes(k - 1, k) || !same_level(k - 1, k) ? min_part_m : min_lanes_m;
      if (s > cuts_.back() + least_m && s < end - least_m) cuts_.push_back(s);
    }
    cuts_.push_back(end);
  }

  void divide(int parts) {
    while (static_cast<int>(cuts_.size()) <= parts) {
      std::size_t longest = 0;
      for (std::size_t k = 0; k + 1 < cuts_.size(); ++k)
        if (cuts_[k + 1] - cuts_[k] > cuts_[longest + 1] - cuts_[longest] + 1e-9) longest = k;
      const double length = cuts_[longest + 1] - cuts_[longest];
      if (length < min_split_m) return;
      // A loop in three at once: thirds.
      const double share = parts == 3 && cuts_.size() == 2 ? 1.0 / 3.0 : 0.5;
      cuts_.insert(cuts_.begin() + static_cast<std::ptrdiff_t>(longest) + 1, cuts_[longest] + share * length);
    }
  }

  std::vector<double> settle() {
    const bool ring = geometry_.closed && !stretch_.vertex0;  // its ends stay where they meet
    const std::size_t last = cuts_.size() - 1;
    if (!ring) move(0, 0.0, stretch_.vertex0 ? outwards_m : dead_end_m);
    for (std::size_t k = 1; k < last; ++k) {
      const double reach = same_level(piece_before(k), piece_before(k + 1)) ? along_m : abutment_m;
      move(k, -reach, reach);
    }
    if (!ring) move(last, stretch_.vertex1 ? -outwards_m : -dead_end_m, 0.0);
    return std::move(cuts_);
  }

 private:
  /// Index along the chain of the piece in the middle of the road before a cut.
  [[nodiscard]] std::size_t piece_before(std::size_t cut) const {
    return piece_at(geometry_, 0.5 * (cuts_[cut - 1] + cuts_[cut]));
  }
  /// All lanes of a one-way road lie to one side of its centre lane, half the width beside the reference line.
  [[nodiscard]] RoadSide side(std::size_t road) const {
    const DirectedPiece part = chain_.pieces[piece_before(road + 1)];
    const bool one_way = roads_.paths[topology_.pieces[part.piece].path].oneway == Oneway::forward;
    const double left = part.reversed == (driving_side_ == DrivingSide::left) ? 1.0 : -1.0;
    return {part.reversed, one_way ? left * 0.5 * width_at(geometry_, 0.5 * (cuts_[road] + cuts_[road + 1])) : 0.0};
  }
  /// Whether as many lanes go on from a piece of the chain to the next one.
  [[nodiscard]] bool have_same_lanes(std::size_t before, std::size_t behind) const {
    const auto lanes_of = [&](std::size_t k) {
      const std::vector<ProfileSample>& widths = geometry_.widths[k];
      const LaneLayout layout = lane_layout(path_of(k), widths[widths.size() / 2].value, driving_side_);
      const bool reversed = chain_.pieces[k].reversed;
      return std::tuple(reversed ? layout.right : layout.left, reversed ? layout.left : layout.right, layout.both_ways);
    };
    return lanes_of(before) == lanes_of(behind);
  }
  [[nodiscard]] const RoadPath& path_of(std::size_t piece) const {
    return roads_.paths[topology_.pieces[chain_.pieces[piece].piece].path];
  }
  [[nodiscard]] bool same_level(std::size_t before, std::size_t behind) const {
    const RoadPath &a = path_of(before), &b = path_of(behind);
    return a.bridge == b.bridge && a.tunnel == b.tunnel && a.layer == b.layer;
  }

  /// How well cut k would lie at s. Each counts only as far as it is short of calm.
  struct Calm {
    double end_radius_m = 0.0;    ///< the smaller one of the roads that end here
    double joint_radius_m = 0.0;  ///< of the line before and after the joint of two roads
    [[nodiscard]] bool enough() const { return end_radius_m >= calm_radius_m && joint_radius_m >= calm_joint_radius_m; }
    auto operator<=>(const Calm&) const = default;
  };
  [[nodiscard]] Calm calm_at(std::size_t k, double s) const {
    Calm calm{calm_radius_m, calm_joint_radius_m};
    if (k > 0)
      calm.end_radius_m = std::min(calm.end_radius_m, end_radius_m(geometry_.plan, cuts_[k - 1], s, true, side(k - 1)));
    if (k + 1 < cuts_.size())
      calm.end_radius_m = std::min(calm.end_radius_m, end_radius_m(geometry_.plan, s, cuts_[k + 1], false, side(k)));
    if (k > 0 && k + 1 < cuts_.size()) calm.joint_radius_m = std::min(calm.joint_radius_m, turn_radius_m(s));
    return calm;
  }

  /// Radius of the turn within a few metres about s.
  [[nodiscard]] double turn_radius_m(double s) const {
    const double s0 = std::max(s - corner_reach_m, cuts_.front()), s1 = std::min(s + corner_reach_m, cuts_.back());
    const Vec2 a = pose_at(geometry_.plan, s0).direction, b = pose_at(geometry_.plan, s1).direction;
    const double turn = std::abs(std::atan2(cross(a, b), dot(a, b)));
    return turn > 0.0 ? (s1 - s0) / turn : INFINITY;
  }

  /// Moves cut k to the nearest calm place, at worst to the calmest; from there to a joint of elements that is as calm.
  void move(std::size_t k, double back_m, double forth_m) {
    const double wish = cuts_[k];
    // Half of the roads beside it stays, and 3 m (all but 0.5 m of shorter ones).
    const auto kept = [&](double other) {
      const double length = std::abs(other - wish);
      return std::max(0.5 * length, std::min(min_road_m, length - short_road_reach_m));
    };
    const double low = k > 0 ? std::max(wish + back_m, cuts_[k - 1] + kept(cuts_[k - 1])) : wish + back_m;
    const double high =
        k + 1 < cuts_.size() ? std::min(wish + forth_m, cuts_[k + 1] - kept(cuts_[k + 1])) : wish + forth_m;
    double best = wish;
    Calm calmest = calm_at(k, wish);
    for (double away = cut_step_m; !calmest.enough() && away <= std::max(-back_m, forth_m) + 1e-9; away += cut_step_m)
      for (const double s : {wish + away, wish - away}) {
        if (s < low || s > high) continue;
        const Calm calm = calm_at(k, s);
        if (calm > calmest) best = s, calmest = calm;
      }
    cuts_[k] = joint_near(k, best, calmest, low, high);
  }

  [[nodiscard]] double joint_near(std::size_t k, double s, const Calm& calm, double low, double high) const {
    const std::vector<roadquery::PlanElement>& plan = geometry_.plan;
    auto element = std::lower_bound(plan.begin(), plan.end(), std::max(low, s - element_reach_m),
                                    [](const roadquery::PlanElement& e, double a) { return e.s < a; });
    double nearest = s, way = INFINITY;
    for (; element != plan.end() && element->s <= std::min(high, s + element_reach_m); ++element) {
      if (std::abs(element->s - s) >= way || calm_at(k, element->s) < calm) continue;
      nearest = element->s, way = std::abs(element->s - s);
    }
    return nearest;
  }

  DrivingSide driving_side_;
  const RoadNetwork& roads_;
  const Topology& topology_;
  const ChainGeometry& geometry_;
  const Chain& chain_;
  const Stretch& stretch_;
  std::vector<double> cuts_;
};

}  // namespace

std::vector<std::vector<double>> cut_roads(const RoadNetwork& roads, const Topology& topology,
                                           const ChainGeometries& geometry, const JunctionPlan& junctions,
                                           DrivingSide driving_side) {
  std::map<std::pair<int, int>, int> roads_between;  // pairs of junctions
  std::vector<std::vector<double>> result(junctions.stretches.size());
  for (std::size_t i = 0; i < result.size(); ++i) {
    const Stretch& stretch = junctions.stretches[i];
    if (stretch.inside) continue;
    StretchCuts cuts(roads, topology, geometry[stretch.chain], stretch, driving_side);
    if (stretch.vertex0 && stretch.vertex1) {
      const auto ends =
          std::minmax(junctions.junction_of_vertex[stretch.vertex0], junctions.junction_of_vertex[stretch.vertex1]);
      if (ends.first == ends.second)
        cuts.divide(3);
      else if (roads_between[ends]++ > 0)
        cuts.divide(2);
    }
    result[i] = cuts.settle();
  }
  return result;
}

std::vector<roadquery::PlanElement> divide_slivers(std::vector<roadquery::PlanElement> plan, double offset_m) {
  for (std::size_t i = 0; i < plan.size(); ++i) {
    const roadquery::PlanElement& e = plan[i];
    const double rest = std::fmod(e.length, sample_m);
    if (std::holds_alternative<roadquery::Line>(e.shape) || e.length < sample_m || rest < 1e-6) continue;
    const double curvature = roadquery::evaluate(e, e.length).curvature;
    const double turn = std::abs(curvature) * 0.5 * (sample_m + rest);  // at the last vertex but one
    const bool last = i + 1 == plan.size();
    const double next = last ? 0.0 : std::min(plan[i + 1].length, sample_m);
    const double next_turn = last ? 0.0 : std::abs(curvature) * 0.5 * (rest + next);
    const double inside_m = curvature > 0.0 ? offset_m : -offset_m;  // the lanes' line is that much sharper
    const bool corner =
        last && turn >= flat_turn_rad && rest < long_rest_m && rest < (calm_radius_m + inside_m) * std::tan(0.5 * turn);
    const bool folds = rest < fold_margin * inside_m * (std::tan(0.5 * turn) + std::tan(0.5 * next_turn));
    if (!corner && !folds) continue;
    const double cut = e.s + e.length - 0.5 * (sample_m + rest), end = e.s + e.length;
    std::vector<roadquery::PlanElement> halves = slice_plan(plan, e.s, cut);
    for (roadquery::PlanElement half : slice_plan(plan, cut, end)) halves.push_back(half);
    if (halves.size() != 2) continue;
    halves[0].s = e.s, halves[1].s = cut;
    halves[1].length = end - cut;
    plan[i] = halves[0];
    plan.insert(plan.begin() + static_cast<std::ptrdiff_t>(i) + 1, halves[1]);
    ++i;
  }
  return plan;
}

}  // namespace orthodrive::network
