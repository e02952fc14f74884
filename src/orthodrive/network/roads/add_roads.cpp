// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "orthodrive/core/median.hpp"
#include "orthodrive/network/curves/crown_shape.hpp"
#include "orthodrive/network/lanes/lanes.hpp"
#include "orthodrive/network/line/road_cuts.hpp"
#include "orthodrive/network/roads/road_parts.hpp"
#include "roadquery/surface/road_surface.hpp"

namespace orthodrive::network {
namespace {

using roadquery::ContactPoint;
using roadquery::LinkKind;
using roadquery::Road;
using roadquery::RoadLink;
using roadquery::RoadMap;

std::size_t index_of(int i) { return static_cast<std::size_t>(i); }

/// In multiples of a centimetre: nobody measures more, and lanes that keep their width are written as such.
std::vector<ProfileSample> widths_between(const ChainGeometry& geometry, std::size_t piece, double s0, double s1) {
  constexpr double unit_m = 0.01;
  std::vector<ProfileSample> samples{{0.0, width_at(geometry, s0)}};
  for (const ProfileSample& sample : geometry.widths[piece])
    if (sample.s > s0 + 1e-3 && sample.s < s1 - 1e-3) samples.push_back({sample.s - s0, sample.value});
  samples.push_back({s1 - s0, width_at(geometry, s1)});
  for (ProfileSample& sample : samples) sample.value = std::round(sample.value / unit_m) * unit_m;
  return samples;
}

double median_value(const std::vector<ProfileSample>& samples) {
  std::vector<double> values;
  values.reserve(samples.size());
  for (const ProfileSample& sample : samples) values.push_back(sample.value);
  return median(std::move(values));
}

/// A road that still lacks its lanes: those depend on the roads it is linked to.
struct Draft {
  std::size_t path = 0;
  bool reversed = false;  ///< the chain runs against the road
  LaneLayout layout;
  std::vector<ProfileSample> widths;
  double median_m = 0.0;                ///< of the widths of its piece
  std::vector<roadquery::Cubic> crown;  ///< along the road; its tangent
  std::optional<RoadEndLanes> start, end;
  LaneRests rests;
  std::optional<LaneRests> start_rests, end_rests;
  LaneShift shift;
  LaneWeights weights;
  std::optional<LaneWeights> start_weights, end_weights;
};

const RoadPath& path_of(const NetworkPlan& plan, const Draft& draft) { return plan.roads.paths[draft.path]; }

Draft draft_road(const NetworkPlan& plan, ChainIndex chain, double s0, double s1, Road& road) {
  const ChainGeometry& geometry = plan.geometry[chain];
  const std::size_t k = piece_at(geometry, 0.5 * (s0 + s1));
  const DirectedPiece part = plan.topology.chains[chain].pieces[k];
  Draft draft{.path = plan.topology.pieces[part.piece].path,
              .reversed = part.reversed,
              .widths = widths_between(geometry, k, s0, s1)};
  const RoadPath& path = path_of(plan, draft);
  const double median_m = draft.median_m = median_value(geometry.widths[k]);
  draft.layout = lane_layout(path, median_m, plan.options.driving_side);
  draft.rests = lane_rests(path, draft.layout, median_m, plan.options.driving_side);
  draft.weights = lane_weights(draft.layout, draft.rests, median_m);
  const auto shift_at = [&](double along) {
    return placed_shift(path, draft.layout, all_open(draft.layout), draft.rests, draft.weights, along,
                        plan.options.driving_side);
  };
  draft.shift = {shift_at(0.0), shift_at(0.5), shift_at(1.0)};

  road.name = path.name;
  road.driving_side = plan.options.driving_side;
  road.osm_id = std::to_string(path.osm_id);
  road.highway = path.highway;
  road.layer = path.layer, road.bridge = path.bridge, road.tunnel = path.tunnel;
  road.speed_limit_mps = path.speed_limit_kmh / kmh_per_mps;
  road.plan = slice_plan(geometry.plan, s0, s1);
  road.length = plan_length(road.plan);
  road.elevation = slice_profile(geometry.elevation, s0, s1);
  road.superelevation = slice_profile(geometry.superelevation, s0, s1);
  draft.crown = slice_profile(geometry.crown, s0, s1);
  if (part.reversed) {
    road.plan = reverse_plan(road.plan);
    road.elevation = reverse_profile(road.elevation, road.length);
    road.superelevation = reverse_profile(road.superelevation, road.length, -1.0);
    draft.crown = reverse_profile(draft.crown, road.length);
    std::reverse(draft.widths.begin(), draft.widths.end());
    for (ProfileSample& sample : draft.widths) sample.s = (s1 - s0) - sample.s;
  }
  const double left =
      plan.options.driving_side == DrivingSide::left ? -1.0 : 1.0;  // the inner edge of a one-way road's lanes
  road.plan = divide_slivers(std::move(road.plan),
                             path.oneway == Oneway::forward ? left * 0.5 * median_value(draft.widths) : 0.0);
  return draft;
}

/// One end of a road.
struct LinkedEnd {
  int road = 0;
  bool at_end = false;
};

void set_link(RoadMap& map, LinkedEnd end, RoadLink link) {
  Road& road = map.roads[index_of(end.road)];
  (end.at_end ? road.successor : road.predecessor) = link;
}

void report_reduced_lanes(const NetworkPlan& plan, const Draft& draft, Findings& findings) {
  const RoadPath& path = path_of(plan, draft);
  const Vec2 p = path.nodes[path.nodes.size() / 2].p;
  std::vector<double> given;  // who reads it knows the width of the map or the photo, not that of the lanes
  const bool is_given = draft.path < plan.given.paths.size();  // else a part of a way, or the ring of a mini-roundabout
  for (const RoadNode& node : (is_given ? plan.given.paths[draft.path] : path).nodes) given.push_back(node.width_m);
  findings.push_back({Severity::warning, "network.too_many_lanes",
                      fmt::format("way {}: {} lanes do not fit in {:.1f} m, took {}", path.osm_id,
                                  std::max(path.lanes, path.lanes_forward + path.lanes_backward + path.lanes_both_ways),
                                  std::min(median(std::move(given)), median_value(draft.widths)), draft.layout.total()),
                      p.x, p.y});
}

/// Cycle lanes that the carriageway has no room for.
void report_cycle_lanes(const NetworkPlan& plan, const Draft& draft, Findings& findings) {
  const RoadPath& path = path_of(plan, draft);
  if (sides_with(path, "bicycle", plan.options.driving_side) == Sides::none) return;
  if (draft.rests.left_cycles.exists() || draft.rests.right_cycles.exists()) return;
  const Vec2 p = path.nodes[path.nodes.size() / 2].p;
  findings.push_back({Severity::info, "network.no_room_for_cycle_lanes",
                      fmt::format("way {}: no room for its cycle lanes beside {} lanes on {:.1f} m, left out",
                                  path.osm_id, draft.layout.total(), median_value(draft.widths)),
                      p.x, p.y});
}

OpenLanes& open_lanes(RoadEndLanes& lanes, bool left) { return left ? lanes.left : lanes.right; }

/// Lanes for the oncoming side's turns at the far end of the road that these lanes drive: they open inside.
int inner_turn_lanes(const NetworkPlan& plan, const Draft& draft, bool forward) {
  const unsigned inner = plan.options.driving_side == DrivingSide::left ? turn_right : turn_left;
  int count = 0;
  for (const unsigned bits : turn_lanes(path_of(plan, draft), forward, plan.options.driving_side)) {
    if (bits != inner) break;
    ++count;
  }
  return count;
}

/// Where the centre lanes lie at a joint: so far from the line as placement tells of the one road or the other, in the
/// middle where they tell different things; lanes that open or end there move nothing. A road that tells nothing goes
/// over from there to where it lies else.
void match_shifts(Draft& a, bool a_at_end, Draft& b, bool b_at_end) {
  std::optional<double>&of_a = a_at_end ? a.shift.end : a.shift.start, &of_b = b_at_end ? b.shift.end : b.shift.start;
  if (!of_a && !of_b) return;
  const double sign = a_at_end != b_at_end ? 1.0 : -1.0, a_m = of_a.value_or(0.0) * a.median_m,
               b_m = sign * of_b.value_or(0.0) * b.median_m;
  const double at_joint_m = of_a && of_b ? 0.5 * (a_m + b_m) : of_a ? a_m : b_m;
  of_a = at_joint_m / (a_at_end ? a.widths.back() : a.widths.front()).value;
  of_b = sign * at_joint_m / (b_at_end ? b.widths.back() : b.widths.front()).value;
}

/// A way from one placement to another: halfway between both.
void settle_transition(const NetworkPlan& plan, Draft& draft) {
  if (!path_of(plan, draft).placement.transition) return;
  if (draft.shift.start && draft.shift.end) draft.shift.middle = 0.5 * (*draft.shift.start + *draft.shift.end);
}

/// The weights of a side's lanes, as shares of all that are open.
struct OpenWeights {
  std::vector<double>* weights = nullptr;
  int first = 0, count = 0;
  [[nodiscard]] double& at(int i) const { return (*weights)[index_of(first + i)]; }
};

/// All lanes of a road that are open at a joint, its weights grown to all its lanes and their sum 1 over the open ones.
struct JointWeights {
  JointWeights(const Draft& draft, const RoadEndLanes& open) : all(draft.weights), is_told(all.are_told()) {
    all.left.resize(index_of(draft.layout.left), 1.0), all.right.resize(index_of(draft.layout.right), 1.0);
    all.both_ways.resize(index_of(draft.layout.both_ways), 1.0);
    left = {&all.left, open.left.first, open.left.count};
    right = {&all.right, open.right.first, open.right.count};
    both_ways = {&all.both_ways, 0, open.both_ways};
    double sum = 0.0;
    for (const OpenWeights* side : {&left, &right, &both_ways})
      for (int i = 0; i < side->count; ++i) sum += side->at(i);
    for (std::vector<double>* weights : {&all.left, &all.right, &all.both_ways})
      for (double& weight : *weights) weight /= sum;
  }
  JointWeights(const JointWeights&) = delete;
  JointWeights& operator=(const JointWeights&) = delete;

  /// Takes its side of the joint: nothing where that leaves the lanes as they are, and all of them are open.
  void settle(const JointWeights& before, const RoadEndLanes& open, std::optional<LaneWeights>& at_joint) const {
    constexpr double same_share = 1e-9;
    bool is_same =
        is_told && open.count() == static_cast<int>(all.left.size() + all.right.size() + all.both_ways.size());
    for (const auto weights : {&LaneWeights::left, &LaneWeights::right, &LaneWeights::both_ways})
      for (std::size_t i = 0; i < (all.*weights).size(); ++i)
        is_same = is_same && std::abs((all.*weights)[i] - (before.all.*weights)[i]) < same_share;
    if (!is_same) at_joint = all;
  }

  LaneWeights all;
  bool is_told = false;
  OpenWeights left, right, both_ways;
};

/// How wide the lanes are beside each other where two roads are linked: as tags tell of the one road or the other, in
/// the middle where they tell of both. Lanes of a road that tells nothing go over from there to equal widths.
void match_weights(Draft& a, bool a_at_end, const RoadEndLanes& open_a, Draft& b, bool b_at_end,
                   const RoadEndLanes& open_b) {
  if (!a.weights.are_told() && !b.weights.are_told()) return;
  JointWeights of_a(a, open_a), of_b(b, open_b);
  const double share_of_a = of_a.is_told && of_b.is_told ? 0.5 : of_a.is_told ? 1.0 : 0.0;
  const auto blend = [&](double& x, double& y) { x = y = share_of_a * x + (1.0 - share_of_a) * y; };
  const bool same_direction = a_at_end != b_at_end;
  const OpenWeights &left_of_b = same_direction ? of_b.left : of_b.right,
                    &right_of_b = same_direction ? of_b.right : of_b.left;
  for (int i = 0; i < of_a.left.count; ++i) blend(of_a.left.at(i), left_of_b.at(i));
  for (int i = 0; i < of_a.right.count; ++i) blend(of_a.right.at(i), right_of_b.at(i));
  const int both = of_a.both_ways.count;
  for (int i = 0; i < both; ++i) blend(of_a.both_ways.at(i), of_b.both_ways.at(same_direction ? i : both - 1 - i));
  of_a.settle(JointWeights(a, open_a), open_a, a_at_end ? a.end_weights : a.start_weights);
  of_b.settle(JointWeights(b, open_b), open_b, b_at_end ? b.end_weights : b.start_weights);
}

/// Settles which lanes are open where two roads are linked, in both directions.
void match_ends(const NetworkPlan& plan, Draft& a, bool a_at_end, Draft& b, bool b_at_end) {
  RoadEndLanes open_a, open_b;
  // Lanes on the left of road s run against s where one drives on the right.
  const bool left_is_forward = plan.options.driving_side == DrivingSide::left;
  const auto side_is_left = [&](bool forward) { return forward == left_is_forward; };
  for (const bool out_of_a : {true, false}) {
    const bool a_left = side_is_left(out_of_a == a_at_end), b_left = side_is_left(out_of_a != b_at_end);
    const int n_a = a_left ? a.layout.left : a.layout.right, n_b = b_left ? b.layout.left : b.layout.right;
    const Draft& to = out_of_a ? b : a;
    const int inner = inner_turn_lanes(plan, to, out_of_a ? !b_at_end : !a_at_end);
    const LaneMatch match = out_of_a ? match_lanes(n_a, n_b, inner) : match_lanes(n_b, n_a, inner);
    open_lanes(open_a, a_left) = out_of_a ? match.from : match.to;
    open_lanes(open_b, b_left) = out_of_a ? match.to : match.from;
  }
  open_a.both_ways = open_b.both_ways = std::min(a.layout.both_ways, b.layout.both_ways);
  if (open_a.count() == 0) return;  // one-way roads that face each other
  (a_at_end ? a.end : a.start) = open_a;
  (b_at_end ? b.end : b.start) = open_b;
  const bool same_direction = a_at_end != b_at_end;
  (a_at_end ? a.end_rests : a.start_rests) = rests_at_joint(a.rests, b.rests, same_direction);
  (b_at_end ? b.end_rests : b.start_rests) = rests_at_joint(b.rests, a.rests, same_direction);
  match_shifts(a, a_at_end, b, b_at_end);
  match_weights(a, a_at_end, open_a, b, b_at_end, open_b);
}

/// Whether two lanes outside the driven ones are one. Strips that end at the joint are not.
bool goes_on(const roadquery::Lane& from, const Road& a, bool a_at_end, const roadquery::Lane& to, const Road& b,
             bool b_at_end) {
  constexpr double least_m = 1e-3;
  using roadquery::LaneType;
  const bool beside = is_rest(from.type) || from.type == LaneType::sidewalk || from.type == LaneType::biking;
  return from.type == to.type && beside && roadquery::lane_width(from, a_at_end ? a.length : 0.0) > least_m &&
         roadquery::lane_width(to, b_at_end ? b.length : 0.0) > least_m;
}

/// A side of a road at a joint.
struct JointSide {
  Road& road;
  bool at_end = false, left = false;
  OpenLanes open;
  int first = 0;  ///< of the lanes of one direction

  [[nodiscard]] std::vector<roadquery::Lane>& lanes() const {
    return left ? road.sections.front().left : road.sections.front().right;
  }
  [[nodiscard]] roadquery::Lane& open_lane(int i) const { return lanes()[index_of(first + open.first + i)]; }
};

void link_open_lanes(roadquery::Lane& from, bool from_end, roadquery::Lane& to, bool to_end) {
  (from_end ? from.successor : from.predecessor) = to.id;
  (to_end ? to.successor : to.predecessor) = from.id;
}

/// Links the open lanes of a side to those of the other road, and the strips and walks beside them.
void link_side(const JointSide& a, const JointSide& b) {
  for (int i = 0; i < a.open.count; ++i) link_open_lanes(a.open_lane(i), a.at_end, b.open_lane(i), b.at_end);
  for (roadquery::Lane& from : a.lanes())
    for (roadquery::Lane& to : b.lanes())
      if (goes_on(from, a.road, a.at_end, to, b.road, b.at_end)) link_open_lanes(from, a.at_end, to, b.at_end);
}

void link_roads(RoadMap& map, LinkedEnd a, const Draft& draft_a, LinkedEnd b, const Draft& draft_b) {
  const auto contact = [](LinkedEnd e) { return e.at_end ? ContactPoint::end : ContactPoint::start; };
  set_link(map, a, {LinkKind::road, map.roads[index_of(b.road)].id, contact(b)});
  set_link(map, b, {LinkKind::road, map.roads[index_of(a.road)].id, contact(a)});
  const std::optional<RoadEndLanes>& open_a = a.at_end ? draft_a.end : draft_a.start;
  const std::optional<RoadEndLanes>& open_b = b.at_end ? draft_b.end : draft_b.start;
  if (!open_a || !open_b) return;
  Road &road_a = map.roads[index_of(a.road)], &road_b = map.roads[index_of(b.road)];
  const DrivingSide side = road_a.driving_side;
  for (const bool a_left : {true, false}) {
    const bool b_left = a_left == (a.at_end != b.at_end);
    link_side(
        {road_a, a.at_end, a_left, a_left ? open_a->left : open_a->right, first_own_lane(draft_a.layout, a_left, side)},
        {road_b, b.at_end, b_left, b_left ? open_b->left : open_b->right,
         first_own_lane(draft_b.layout, b_left, side)});
  }
  const auto both_ways = [side](Road& road) -> std::vector<roadquery::Lane>& {
    return side == DrivingSide::left ? road.sections.front().left : road.sections.front().right;
  };
  for (int i = 0; i < open_a->both_ways; ++i)
    link_open_lanes(both_ways(road_a)[index_of(i)], a.at_end,
                    both_ways(road_b)[index_of(a.at_end != b.at_end ? i : open_b->both_ways - 1 - i)], b.at_end);
}

/// Lanes and direct links of the roads of a stretch, `drafts` in the order along the chain; a ring's last one leads
/// into its first.
void add_stretch_lanes(const NetworkPlan& plan, RoadMap& map, int first_road, std::vector<Draft>& drafts, bool ring) {
  const std::size_t joints = drafts.size() - (ring ? 0 : 1);
  const auto next = [&](std::size_t k) { return (k + 1) % drafts.size(); };
  for (std::size_t k = 0; k < joints; ++k)
    match_ends(plan, drafts[k], !drafts[k].reversed, drafts[next(k)], drafts[next(k)].reversed);
  for (std::size_t k = 0; k < drafts.size(); ++k) {
    const Draft& draft = drafts[k];
    const RoadPath& path = path_of(plan, draft);
    Road& road = map.roads[index_of(first_road) + k];
    settle_transition(plan, drafts[k]);
    add_lanes(road, draft.layout, draft.widths,
              {plan.options.width_tolerance_m, path.sidewalk, draft.rests, draft.start, draft.end, draft.start_rests,
               draft.end_rests, draft.shift, draft.weights, draft.start_weights, draft.end_weights});
    set_lane_speeds(road, path);
    set_material(road, path.known_surface.surface, plan.options.weather);
    add_crown(road, draft.crown, plan.options.shape_tolerance_m, max_rate_jump_of(road));
  }
  for (std::size_t k = 0; k < joints; ++k)
    link_roads(map, {first_road + static_cast<int>(k), !drafts[k].reversed}, drafts[k],
               {first_road + static_cast<int>(next(k)), drafts[next(k)].reversed}, drafts[next(k)]);
}

/// The roads of one stretch, along its chain.
struct StretchRoads {
  LinkedEnd begin, end;  ///< where the stretch begins and ends
  std::size_t first_path = 0, last_path = 0;
};

StretchRoads add_stretch(const NetworkPlan& plan, const Stretch& stretch, const std::vector<double>& cuts, RoadMap& map,
                         std::set<std::size_t>& told, Findings& findings) {
  const int first_road = static_cast<int>(map.roads.size());
  std::vector<Draft> drafts;
  for (std::size_t k = 0; k + 1 < cuts.size(); ++k) {
    map.roads.emplace_back();
    drafts.push_back(draft_road(plan, stretch.chain, cuts[k], cuts[k + 1], map.roads.back()));
    map.roads.back().id = static_cast<int>(map.roads.size());
    if (!told.insert(drafts.back().path).second) continue;
    if (drafts.back().layout.reduced) report_reduced_lanes(plan, drafts.back(), findings);
    report_cycle_lanes(plan, drafts.back(), findings);
  }
  add_stretch_lanes(plan, map, first_road, drafts, plan.geometry[stretch.chain].closed && !stretch.vertex0);
  const int last_road = static_cast<int>(map.roads.size()) - 1;
  return {{first_road, drafts.front().reversed},
          {last_road, !drafts.back().reversed},
          drafts.front().path,
          drafts.back().path};
}

/// The ends at every junction, and between which of them a chain runs on.
class JunctionEnds {
 public:
  explicit JunctionEnds(const NetworkPlan& plan) : plan_(plan), ends_(index_of(plan.junctions.junctions)) {}

  /// Stretches in order, each with its roads.
  void add(std::size_t index, const std::vector<double>& cuts, const StretchRoads& roads) {
    const Stretch& stretch = plan_.junctions.stretches[index];
    begin_chain(stretch.chain);
    if (stretch.vertex0) {
      const EndInJunction begin =
          add_end({roads.begin.road, roads.begin.at_end, stretch.vertex0, index, true, cuts.front(), roads.first_path});
      if (left_.end >= 0)
        connect(left_, begin);
      else
        first_ = begin;
    }
    left_ = {};
    if (stretch.vertex1)
      left_ = add_end({roads.end.road, roads.end.at_end, stretch.vertex1, index, false, cuts.back(), roads.last_path});
  }
  std::vector<std::vector<JunctionEnd>> take() {
    close_chain();
    return std::move(ends_);
  }

 private:
  struct EndInJunction {
    int junction = -1, end = -1;
  };
  void begin_chain(ChainIndex chain) {
    if (chain == chain_) return;
    close_chain();
    chain_ = chain, left_ = first_ = {};
  }
  void close_chain() {
    if (chain_ && plan_.geometry[chain_].closed && left_.end >= 0 && first_.end >= 0) connect(first_, left_);
  }
  EndInJunction add_end(const JunctionEnd& end) {
    const int junction = plan_.junctions.junction_of_vertex[end.vertex];
    ends_[index_of(junction)].push_back(end);
    return {junction, static_cast<int>(ends_[index_of(junction)].size()) - 1};
  }
  void connect(EndInJunction a, EndInJunction b) {
    std::vector<JunctionEnd>& junction = ends_[index_of(b.junction)];
    junction[index_of(a.end)].through = b.end;
    junction[index_of(b.end)].through = a.end;
  }

  const NetworkPlan& plan_;
  std::vector<std::vector<JunctionEnd>> ends_;
  ChainIndex chain_;
  // The chain runs on from the end that it left last into the next one; a closed chain's last end into its first.
  EndInJunction left_, first_;
};

}  // namespace

std::vector<std::vector<JunctionEnd>> add_roads(const NetworkPlan& plan, RoadMap& map, Findings& findings) {
  std::set<std::size_t> told;  // paths whose lanes were looked at
  JunctionEnds ends(plan);
  for (std::size_t i = 0; i < plan.junctions.stretches.size(); ++i) {
    const Stretch& stretch = plan.junctions.stretches[i];
    if (!stretch.inside) ends.add(i, plan.cuts[i], add_stretch(plan, stretch, plan.cuts[i], map, told, findings));
  }
  return ends.take();
}

}  // namespace orthodrive::network
