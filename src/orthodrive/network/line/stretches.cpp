// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/network/line/stretches.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>

#include "orthodrive/geo/segment.hpp"

namespace orthodrive::network {
namespace {

// Room beyond the carriageways for the curve of the corner. Where cars meet in lanes narrower than calm_lane_m, a car
// that turns in has to be straight again before it passes one that waits: that takes longer.
constexpr double corner_m = 4.0, corner_per_narrow_m = 4.0, calm_lane_m = 2.75;
constexpr double joint_taper_m =
    10.0;  // to each side of a joint at which lanes move sideways: half a lane in 2 s at 10 m/s
constexpr double turn_back_m = 25.0;   // and where a road turns back beside itself, at most
constexpr double fork_reach_m = 80.0;  // narrow forks overlap for long: roads are cut back no further than this
constexpr double stretch_step_m = 0.5;
constexpr double narrowest_carriageway_m = 1.5;  // no carriageway is narrower
// The carriageways of one road, into the junction and out of it, have parted when so much of their widths has: they
// share no traffic and make room for each other from there on (room_beside.hpp). Slip roads part for good.
constexpr double parted_share = 0.6;
const double side_by_side_sine = std::sin(15.0 * std::numbers::pi / 180.0);
constexpr double beside_gap_m = 1.5;  // a kerb between the carriageways of one road
constexpr double clear_m = 3.0;       // free of the others for this long counts as having left them
constexpr double fork_part_m = 15.0;  // roads of two junctions that lie on each other have parted within this: a fork
constexpr double min_rest_m = 1.0;    // what is left of a road between two junctions
constexpr double join_rest_m =
    7.5;  // junctions join when less is left between them: a car and its distance to the next
constexpr double widest_join_m = 40.0;  // largest distance between vertices of a joined junction
constexpr double widest_twin_m = 60.0;  // the same where two roads that would lie on each other are all that is between
constexpr double roundabout_join_m = 4.0;  // the ring of a roundabout stays a ring where it can

std::vector<Stretch> cut_at_junctions(const Topology& topology, const ChainGeometries& geometry) {
  std::vector<Stretch> stretches;
  for (const ChainIndex c : topology.chains.indices()) {
    const Chain& chain = topology.chains[c];
    if (geometry[c].empty()) continue;
    const auto junction_at = [&](std::size_t k) {
      const VertexIndex vertex =
          k < chain.pieces.size() ? start_vertex(topology, chain.pieces[k]) : end_vertex(topology, chain.pieces.back());
      return topology.vertices[vertex].is_junction() ? vertex : VertexIndex{};
    };
    Stretch open{.chain = c, .s0 = 0.0, .vertex0 = junction_at(0)};
    for (std::size_t k = 1; k <= chain.pieces.size(); ++k) {
      const VertexIndex vertex = junction_at(k);
      if (!vertex && k < chain.pieces.size()) continue;
      open.s1 = geometry[c].vertex_s[k], open.vertex1 = vertex;
      stretches.push_back(open);
      open.s0 = open.s1, open.vertex0 = vertex;
    }
  }
  return stretches;
}

bool on_roundabout(const Topology& topology, const ChainGeometry& geometry, const Stretch& stretch) {
  const std::size_t k = piece_at(geometry, 0.5 * (stretch.s0 + stretch.s1));
  return topology.ring_of_piece[topology.chains[stretch.chain].pieces[k].piece] >= 0;
}

/// Cuts that do not fit leave min_road_m of the road, or half of it.
void shorten_cuts(Stretch& stretch) {
  const double gap = stretch.s1 - stretch.s0, wished = stretch.trim0_m + stretch.trim1_m;
  const double room = std::max(gap - min_rest_m, 0.5 * gap);
  if (wished <= room) return;
  stretch.trim0_m *= room / wished;
  stretch.trim1_m *= room / wished;
}

/// Sampled from the junction outwards.
struct ArmLine {
  int way = 0;                       ///< where one may drive: 0 = both ways, 1 = out of the junction, -1 = into it
  std::vector<Vec2> center, across;  ///< across: to the left edge
  std::vector<double> half_width_m;
};

ArmLine sample_arm(const ChainGeometries& geometry, const Stretch& stretch, bool at_s1, double longest_m) {
  const ChainGeometry& g = geometry[stretch.chain];
  ArmLine line;
  const double reach = std::min(longest_m, stretch.s1 - stretch.s0);
  const int steps = std::max(1, static_cast<int>(reach / stretch_step_m));
  for (int i = 0; i <= steps; ++i) {
    const double d = std::min(i * stretch_step_m, reach), s = at_s1 ? stretch.s1 - d : stretch.s0 + d;
    const Pose pose = pose_at(g.plan, s);
    // Half a step off the vertex, where the width may change from road to road.
    const double half = 0.5 * width_at(g, at_s1 ? s - 0.5 * std::min(stretch_step_m, reach) : s);
    line.center.push_back(pose.p);
    line.half_width_m.push_back(half);
    line.across.push_back(left_normal(pose.direction) * half);
  }
  return line;
}

/// Whether the other carriageway reaches p, a place of this arm that goes `along` there, `share` of half its width off
/// its axis. Without a direction: however the two lie to each other.
bool covers(const ArmLine& other, Vec2 p, Vec2 along = {}, double share = 0.0) {
  for (std::size_t i = 1; i < other.center.size(); ++i) {
    const Vec2 a = other.center[i - 1], d = other.center[i] - a;
    const double n2 = dot(d, d), t = share_along(a, other.center[i], p);
    const Vec2 off = p - (a + d * t);
    double half = other.half_width_m[i - 1] + (other.half_width_m[i] - other.half_width_m[i - 1]) * t;
    if (along != Vec2{} && std::abs(cross(along, d)) < side_by_side_sine * std::sqrt(n2))
      half *= share <= parted_share ? parted_share : 0.0;
    if (dot(off, off) < half * half) return true;
  }
  return false;
}

/// Calls `covered` with places across an arm and their share of half its width. Not only its edges count: a narrow
/// branch begins in the middle of a wide road.
template <typename F>
bool any_across(const ArmLine& arm, std::size_t i, const F& covered) {
  const int steps = std::max(1, static_cast<int>(std::ceil(2.0 * arm.half_width_m[i] / narrowest_carriageway_m)));
  for (int k = 0; k <= steps; ++k)
    if (const double share = 2.0 * k / steps - 1.0; covered(arm.center[i] + arm.across[i] * share, std::abs(share)))
      return true;
  return false;
}

/// Whether the other carriageway reaches into the cross section i of an arm.
bool meets(const ArmLine& arm, std::size_t i, const ArmLine& other) {
  return any_across(arm, i, [&](Vec2 p, double) { return covers(other, p); });
}

/// The same, but carriageways of one road may overlap by what they can give each other.
bool crowds(const ArmLine& arm, std::size_t i, const ArmLine& other) {
  if (arm.way * other.way >= 0) return meets(arm, i, other);
  const Vec2 along = normalized(left_normal(arm.across[i]));
  return any_across(arm, i, [&](Vec2 p, double share) { return covers(other, p, along, share); });
}

/// Distance from its own vertex at which an arm has left all others, and the corner.
double clear_distance_m(const std::vector<ArmLine>& arms, std::size_t self) {
  const ArmLine& arm = arms[self];
  double covered_until = 0.0;
  for (std::size_t i = 0; i < arm.center.size(); ++i) {
    const double d = static_cast<double>(i) * stretch_step_m;
    if (d > covered_until + clear_m || d > fork_reach_m) break;
    for (std::size_t other = 0; other < arms.size(); ++other)
      if (other != self && crowds(arm, i, arms[other])) {
        covered_until = d;
        break;
      }
  }
  const std::size_t there = std::min(static_cast<std::size_t>(covered_until / stretch_step_m), arm.center.size() - 1);
  const double narrow_m = arm.way == 0 ? std::max(0.0, calm_lane_m - arm.half_width_m[there]) : 0.0;
  return covered_until + corner_m + corner_per_narrow_m * narrow_m;
}

/// Where on `other` the cross section of an arm at `trim_m` lies, if that is the other carriageway of its road and
/// close beside it: the distance from the other's vertex.
std::optional<double> place_beside(const ArmLine& arm, double trim_m, const ArmLine& other) {
  const std::size_t i = std::min(static_cast<std::size_t>(std::lround(trim_m / stretch_step_m)), arm.center.size() - 1);
  if (arm.way * other.way >= 0) return std::nullopt;
  const Vec2 p = arm.center[i], left = normalized(arm.across[i]);
  for (std::size_t k = 0; k < other.center.size(); ++k) {
    const Vec2 d = other.center[k] - p;
    if (std::abs(cross(left, d)) > 0.5 * stretch_step_m) continue;
    if (std::abs(cross(left, normalized(other.across[k]))) > side_by_side_sine) return std::nullopt;
    const double gap_m = std::abs(dot(left, d)) - arm.half_width_m[i] - other.half_width_m[k];
    return gap_m < beside_gap_m ? std::optional(static_cast<double>(k) * stretch_step_m) : std::nullopt;
  }
  return std::nullopt;
}

/// The part of an arm that its road has, up to part_m of it.
ArmLine road_part(ArmLine line, double trim_m) {
  const auto from = static_cast<std::ptrdiff_t>(std::min(std::ceil(trim_m / stretch_step_m), line.center.size() - 1.0));
  const auto to = std::min(from + static_cast<std::ptrdiff_t>(fork_part_m / stretch_step_m) + 1,
                           static_cast<std::ptrdiff_t>(line.center.size()));
  const auto cut = [&](auto& values) { values = {values.begin() + from, values.begin() + to}; };
  cut(line.center), cut(line.across), cut(line.half_width_m);
  return line;
}

/// Whether a cross section of an arm reaches into the other carriageway.
bool lies_on(const ArmLine& arm, const ArmLine& other) {
  for (std::size_t i = 0; i < arm.center.size(); ++i)
    if (meets(arm, i, other)) return true;
  return false;
}

/// Whether two roads lie on each other where they begin and have parted a little further on: roads that run side by
/// side for long are no fork.
bool forks(const ArmLine& a, const ArmLine& b) {
  return lies_on(a, b) && !meets(a, a.center.size() - 1, b) && !meets(b, b.center.size() - 1, a);
}

class JunctionPlanner {
 public:
  JunctionPlanner(const RoadNetwork& roads, const Topology& topology, const ChainGeometries& geometry)
      : roads_(roads),
        topology_(topology),
        geometry_(geometry),
        group_(topology.vertices.size()),
        places_(topology.vertices.size()),
        arms_(topology.vertices.size()) {
    for (const VertexIndex v : topology.vertices.indices()) group_[v] = v;
    plan_.stretches = cut_at_junctions(topology, geometry);
    for (const Stretch& stretch : plan_.stretches) {
      const std::vector<roadquery::PlanElement>& plan = geometry[stretch.chain].plan;
      if (stretch.vertex0) places_[stretch.vertex0] = {pose_at(plan, stretch.s0).p};
      if (stretch.vertex1) places_[stretch.vertex1] = {pose_at(plan, stretch.s1).p};
    }
  }

  JunctionPlan run() {
    cut_back();
    join(narrow_gaps(), widest_join_m);
    cut_back();  // joined junctions have more arms
    join(gaps_beside_forks(), widest_join_m);
    cut_back();
    join(gaps_of_twins(), widest_twin_m);
    cut_back();
    absorb_inner_roads();
    cut_back();
    for (const std::vector<Arm>& junction : arms_) align_carriageways(junction);
    for (Stretch& stretch : plan_.stretches)
      if (!stretch.inside) shorten_cuts(stretch);
    number_junctions();
    return std::move(plan_);
  }

 private:
  VertexIndex group(VertexIndex vertex) {
    while (group_[vertex] != vertex) vertex = group_[vertex];
    return vertex;
  }

  /// ArmLine::way of a stretch where it begins or ends.
  [[nodiscard]] int way_of(const Stretch& stretch, bool at_s1) const {
    const double s = at_s1 ? stretch.s1 - stretch_step_m : stretch.s0 + stretch_step_m;
    const DirectedPiece part = topology_.chains[stretch.chain].pieces[piece_at(geometry_[stretch.chain], s)];
    if (roads_.paths[topology_.pieces[part.piece].path].oneway == Oneway::no) return 0;
    return part.reversed == at_s1 ? 1 : -1;
  }

  [[nodiscard]] ArmLine line_of(const Arm& arm, double longest_m) const {
    const Stretch& stretch = plan_.stretches[arm.stretch];
    ArmLine line = sample_arm(geometry_, stretch, arm.at_s1, longest_m);
    line.way = way_of(stretch, arm.at_s1);
    return line;
  }

  void cut_back() {
    arms_ = Table<VertexIndex, std::vector<Arm>>(topology_.vertices.size());  // by the first vertex of the group
    Table<VertexIndex, std::vector<std::size_t>> inner(topology_.vertices.size());
    for (std::size_t i = 0; i < plan_.stretches.size(); ++i) {
      const Stretch& stretch = plan_.stretches[i];
      if (stretch.inside) {
        if (stretch.vertex0 && stretch.vertex1) inner[group(stretch.vertex0)].push_back(i);
        continue;
      }
      if (stretch.vertex0) arms_[group(stretch.vertex0)].push_back({i, false});
      if (stretch.vertex1) arms_[group(stretch.vertex1)].push_back({i, true});
    }
    for (const VertexIndex v : arms_.indices()) {
      const std::vector<Arm>& junction = arms_[v];
      std::vector<ArmLine> lines;
      lines.reserve(junction.size() + inner[v].size());
      for (const Arm& arm : junction) lines.push_back(line_of(arm, fork_reach_m + clear_m));
      for (const std::size_t i : inner[v])  // no arms, but carriageways that arms have to leave
        lines.push_back(sample_arm(geometry_, plan_.stretches[i], false, INFINITY));
      for (std::size_t i = 0; i < junction.size(); ++i) {
        Stretch& stretch = plan_.stretches[junction[i].stretch];
        double& trim_m = junction[i].at_s1 ? stretch.trim1_m : stretch.trim0_m;
        trim_m = junction.size() == 1 ? 0.0 : clear_distance_m(lines, i);
        if (junction.size() == 2) trim_m = std::clamp(trim_m, joint_taper_m, turn_back_m);
      }
    }
  }

  /// The carriageways of one road end side by side, as its stop line and its crossing do: else the one would run on
  /// beside the junction that the other has already reached. Each keeps what makes it a road of its own.
  void align_carriageways(const std::vector<Arm>& junction) {
    std::vector<ArmLine> lines;
    std::vector<double> trims_m;
    for (const Arm& arm : junction) {
      lines.push_back(line_of(arm, 1.5 * fork_reach_m));
      const Stretch& stretch = plan_.stretches[arm.stretch];
      trims_m.push_back(arm.at_s1 ? stretch.trim1_m : stretch.trim0_m);
    }
    for (std::size_t i = 0; i < junction.size(); ++i) {
      Stretch& stretch = plan_.stretches[junction[i].stretch];
      double& trim_m = junction[i].at_s1 ? stretch.trim1_m : stretch.trim0_m;
      const double other_trim_m = junction[i].at_s1 ? stretch.trim0_m : stretch.trim1_m;
      const double longest_m = stretch.s1 - stretch.s0 - other_trim_m - join_rest_m;
      for (std::size_t k = 0; k < junction.size(); ++k)
        if (const std::optional<double> there = place_beside(lines[k], trims_m[k], lines[i]);
            k != i && there && *there > trim_m && *there <= longest_m)
          trim_m = *there;
    }
  }

  /// A stretch over which two junctions join.
  struct Gap {
    double rest_m = 0.0;  ///< what the wished cuts leave of it
    std::size_t stretch = 0;
    auto operator<=>(const Gap&) const = default;
  };

  /// Those of which `is_reason` says so.
  template <typename IsReason>
  std::vector<Gap> gaps_where(const IsReason& is_reason) {
    std::vector<Gap> gaps;
    for (std::size_t i = 0; i < plan_.stretches.size(); ++i) {
      const Stretch& stretch = plan_.stretches[i];
      if (stretch.inside || !stretch.vertex0 || !stretch.vertex1) continue;
      const double rest_m = stretch.s1 - stretch.s0 - stretch.trim0_m - stretch.trim1_m;
      if (is_reason(i, rest_m)) gaps.push_back({rest_m, i});
    }
    return gaps;
  }
  std::vector<Gap> narrow_gaps() {
    return gaps_where([&](std::size_t i, double rest_m) {
      const Stretch& stretch = plan_.stretches[i];
      if (on_roundabout(topology_, geometry_[stretch.chain], stretch))
        return stretch.s1 - stretch.s0 < roundabout_join_m;
      return rest_m < join_rest_m;
    });
  }
  std::vector<Gap> gaps_beside_forks() {
    return gaps_where([&](std::size_t i, double) {
      const Stretch& stretch = plan_.stretches[i];
      return !on_roundabout(topology_, geometry_[stretch.chain], stretch) &&
             group(stretch.vertex0) != group(stretch.vertex1) && arms_fork(i);
    });
  }

  /// Of two roads between the same two junctions only a metre each would be left, and the metres lie on each other.
  std::vector<Gap> gaps_of_twins() {
    std::map<std::pair<VertexIndex, VertexIndex>, std::vector<Gap>> between;
    for (const Gap& gap : gaps_where([](std::size_t, double rest_m) { return rest_m < min_rest_m; })) {
      const Stretch& stretch = plan_.stretches[gap.stretch];
      const auto ends = std::minmax({group(stretch.vertex0), group(stretch.vertex1)});
      if (ends.first != ends.second && !on_roundabout(topology_, geometry_[stretch.chain], stretch))
        between[ends].push_back(gap);
    }
    std::vector<Gap> twins;
    for (const auto& [ends, gaps] : between)
      for (const Gap& gap : gaps)
        if (std::ranges::any_of(gaps, [&](const Gap& other) {
              return other.stretch != gap.stretch && lies_on(rest_of_road(gap.stretch), rest_of_road(other.stretch));
            }))
          twins.push_back(gap);
    return twins;
  }

  /// What its cuts leave of a stretch.
  ArmLine rest_of_road(std::size_t i) const {
    Stretch rest = plan_.stretches[i];
    shorten_cuts(rest);
    rest.s0 += rest.trim0_m, rest.s1 -= rest.trim1_m;
    return sample_arm(geometry_, rest, false, INFINITY);
  }

  /// The narrowest gaps first: what they leave of a group's extent the others may take.
  void join(std::vector<Gap> gaps, double widest_m) {
    std::sort(gaps.begin(), gaps.end());
    for (const Gap& gap : gaps) {
      Stretch& stretch = plan_.stretches[gap.stretch];
      const VertexIndex a = group(stretch.vertex0), b = group(stretch.vertex1);
      if (a != b && extent_m(places_[a], places_[b]) > widest_m) continue;
      stretch.inside = true;
      if (a == b) continue;
      std::vector<Vec2>&all = places_[std::min(a, b)], &others = places_[std::max(a, b)];
      all.insert(all.end(), others.begin(), others.end());
      group_[std::max(a, b)] = std::min(a, b);
    }
  }

  /// Whether a road of the one junction forks off a road of the other.
  bool arms_fork(std::size_t between) {
    const Stretch& stretch = plan_.stretches[between];
    if (stretch.s1 - stretch.s0 > widest_join_m) return false;
    const auto roads_of = [&](VertexIndex vertex) {
      std::vector<ArmLine> roads;
      for (const Arm& arm : arms_[group(vertex)]) {
        if (arm.stretch == between) continue;
        const Stretch& own = plan_.stretches[arm.stretch];
        const double trim = arm.at_s1 ? own.trim1_m : own.trim0_m;
        roads.push_back(road_part(sample_arm(geometry_, own, arm.at_s1, trim + fork_part_m), trim));
      }
      return roads;
    };
    const std::vector<ArmLine> a = roads_of(stretch.vertex0), b = roads_of(stretch.vertex1);
    return std::any_of(a.begin(), a.end(), [&](const ArmLine& p) {
      return std::any_of(b.begin(), b.end(), [&](const ArmLine& q) { return forks(p, q); });
    });
  }

  static double extent_m(const std::vector<Vec2>& a, const std::vector<Vec2>& b) {
    double largest = 0.0;
    for (const Vec2 p : a)
      for (const Vec2 q : b) largest = std::max(largest, distance(p, q));
    return largest;
  }

  /// What is left between two vertices of one junction is a road of its own only if both its cuts fit; a dead end that
  /// lies beside the other roads as far as it goes is a part of the junction's pavement.
  void absorb_inner_roads() {
    for (Stretch& stretch : plan_.stretches) {
      if (stretch.inside || (!stretch.vertex0 && !stretch.vertex1)) continue;
      const bool dead_end = !stretch.vertex0 || !stretch.vertex1;
      if (dead_end ? arms_[group(stretch.vertex0 ? stretch.vertex0 : stretch.vertex1)].size() < 3
                   : group(stretch.vertex0) != group(stretch.vertex1))
        continue;
      if (stretch.vertex0 == stretch.vertex1 && on_roundabout(topology_, geometry_[stretch.chain], stretch)) continue;
      stretch.inside = stretch.s1 - stretch.s0 - min_rest_m < stretch.trim0_m + stretch.trim1_m;
    }
  }

  void number_junctions() {
    plan_.junction_of_vertex = Table<VertexIndex, int>(topology_.vertices.size(), -1);
    for (const VertexIndex v : topology_.vertices.indices()) {
      if (!topology_.vertices[v].is_junction()) continue;
      const VertexIndex first = group(v);
      if (plan_.junction_of_vertex[first] < 0) plan_.junction_of_vertex[first] = plan_.junctions++;
      plan_.junction_of_vertex[v] = plan_.junction_of_vertex[first];
    }
  }

  const RoadNetwork& roads_;
  const Topology& topology_;
  const ChainGeometries& geometry_;
  Table<VertexIndex, VertexIndex> group_;         ///< union-find: the lowest vertex of the joined junction
  Table<VertexIndex, std::vector<Vec2>> places_;  ///< of a joined junction's vertices, by its lowest vertex
  Table<VertexIndex, std::vector<Arm>> arms_;     ///< of the joined junction, by its lowest vertex
  JunctionPlan plan_;
};

}  // namespace

JunctionPlan plan_junctions(const RoadNetwork& roads, const Topology& topology, const ChainGeometries& geometry) {
  return JunctionPlanner(roads, topology, geometry).run();
}

}  // namespace orthodrive::network
