// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/elevate/terrain/grade_separations.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <queue>
#include <set>

#include "orthodrive/model/roads/highway_class.hpp"
#include "orthodrive/model/roads/osm_node_id.hpp"
#include "orthodrive/roads/path_overlaps.hpp"

namespace orthodrive::elevate {
namespace {

constexpr double meeting_m = 50.0;   // roads that meet this near cross because their lines overlap
constexpr double overshoot_m = 5.0;  // beyond the half width: an end drawn across the road it should meet
constexpr double parting_reach = 57.3, farthest_parting_m = 300.0;  // twice the cotangent of 2 degrees
constexpr double clear_dip_m = 0.75;  // difference of two dips that decides: several sigma of a 10 m grid

/// Where the shared nodes of the network are, and how far along the ways from each other.
class SharedNodes {
 public:
  explicit SharedNodes(const RoadNetwork& roads) {
    for (std::size_t k = 0; k < roads.paths.size(); ++k) {
      s_.push_back(arc_lengths_m(centerline(roads.paths[k])));
      auto& on_path = of_path_.emplace_back();
      for (std::size_t n = 0; n < roads.paths[k].nodes.size(); ++n)
        if (const std::int64_t id = roads.paths[k].nodes[n].osm_node; is_osm_node(id)) {
          on_path.push_back({id, s_[k][n]});
          paths_at_[id].push_back(k);
        }
    }
  }
  [[nodiscard]] double length_m(std::size_t path) const { return s_[path].back(); }
  [[nodiscard]] double s_m(std::size_t path, std::size_t segment, double fraction) const {
    return s_[path][segment] + fraction * (s_[path][segment + 1] - s_[path][segment]);
  }
  [[nodiscard]] const std::vector<double>& stations(std::size_t path) const { return s_[path]; }
  [[nodiscard]] bool is_loose_end(const RoadNetwork& roads, std::size_t path, bool at_back) const {
    const auto& nodes = roads.paths[path].nodes;
    const auto at = paths_at_.find((at_back ? nodes.back() : nodes.front()).osm_node);
    return at == paths_at_.end() || at->second.size() < 2;
  }
  /// Whether a way leads from place to place within `reach_m` along the network (Dijkstra over the shared nodes).
  [[nodiscard]] bool meet_within(std::size_t path_a, double s_a, std::size_t path_b, double s_b, double reach_m) const {
    if (path_a == path_b && std::abs(s_a - s_b) <= reach_m) return true;
    std::map<std::int64_t, double> nearest;
    std::priority_queue<std::pair<double, std::int64_t>, std::vector<std::pair<double, std::int64_t>>, std::greater<>>
        queue;
    const auto visit = [&](std::size_t path, double s, double so_far) {
      for (const auto& [id, at] : of_path_[path]) {
        const double d = so_far + std::abs(at - s);
        const auto known = nearest.find(id);
        if (d > reach_m || (known != nearest.end() && known->second <= d)) continue;
        nearest[id] = d, queue.push({d, id});
      }
    };
    visit(path_a, s_a, 0.0);
    while (!queue.empty()) {
      const auto [d, id] = queue.top();
      queue.pop();
      if (d > nearest[id]) continue;
      for (const std::size_t path : paths_at_.at(id))
        for (const auto& [other, at] : of_path_[path]) {
          if (other != id) continue;
          if (path == path_b && d + std::abs(at - s_b) <= reach_m) return true;
          visit(path, at, d);
        }
    }
    return false;
  }

 private:
  std::vector<std::vector<double>> s_;
  std::vector<std::vector<std::pair<std::int64_t, double>>> of_path_;
  std::map<std::int64_t, std::vector<std::size_t>> paths_at_;
};

/// By how much the terrain at a place of a way lies below the line through it at both sides; 0 where it is not known.
double terrain_dip_m(const std::vector<double>& s, const std::vector<TerrainSample>& samples, double at_m,
                     double reach_m) {
  const auto z_at = [&](double s_m) {
    const auto after = std::lower_bound(s.begin(), s.end(), std::clamp(s_m, s.front(), s.back()));
    return samples[static_cast<std::size_t>(after - s.begin())].z_m;
  };
  const double before_m = std::max(s.front(), at_m - reach_m), after_m = std::min(s.back(), at_m + reach_m);
  const double f = after_m > before_m ? (at_m - before_m) / (after_m - before_m) : 0.0;
  const double dip = z_at(before_m) * (1.0 - f) + z_at(after_m) * f - z_at(at_m);
  return std::isnan(dip) ? 0.0 : dip;
}

bool is_never_crossed_at_grade(const RoadPath& path) { return is_fast_class(path.highway); }

void report_missing_junction(const RoadPath& a, const RoadPath& b, const PathCrossing& crossing, const char* why,
                             Findings& findings) {
  findings.push_back(
      {Severity::info, "elevate.missing_junction",
       fmt::format("ways {} and {} cross without a common node, {}: taken for a junction that the map lacks", a.osm_id,
                   b.osm_id, why),
       crossing.p.x, crossing.p.y});
}

double half_width_m(const RoadPath& path, std::size_t segment) {
  return 0.5 * std::max(3.0, path.nodes[segment].width_m);
}

void add_overlaps(const RoadNetwork& roads, const SharedNodes& shared, std::vector<GradeSeparation>& levels) {
  for (const PathOverlap& overlap : find_overlaps(roads)) {
    const PathCrossing& at = overlap.at;
    const double reach_m = std::clamp(parting_reach * overlap.distance_m, meeting_m, farthest_parting_m);
    if (shared.meet_within(at.path_a, shared.s_m(at.path_a, at.segment_a, at.fraction_a), at.path_b,
                           shared.s_m(at.path_b, at.segment_b, at.fraction_b), reach_m))
      continue;
    GradeSeparation level{.crossing = at, .a_is_above = overlap.a_is_above, .is_along = true};
    const bool is_bridge = roads.paths[level.upper()].bridge, is_tunnel = roads.paths[level.lower()].tunnel;
    level.raise = is_bridge || !is_tunnel;
    level.has_room = is_bridge || is_tunnel;  // a layer alone is reported, and moves nothing
    levels.push_back(level);
  }
}

}  // namespace

std::vector<GradeSeparation> find_grade_separations(const RoadNetwork& roads, const TerrainSamples& terrain,
                                                    Findings& findings) {
  const SharedNodes shared(roads);
  std::vector<GradeSeparation> levels;
  for (const PathCrossing& crossing : find_crossings(roads)) {
    const RoadPath &a = roads.paths[crossing.path_a], &b = roads.paths[crossing.path_b];
    GradeSeparation level{.crossing = crossing};
    std::optional<bool> a_is_above;
    if (a.layer != b.layer)
      a_is_above = a.layer > b.layer;
    else if (a.bridge != b.bridge)
      a_is_above = a.bridge;
    else if (a.tunnel != b.tunnel)
      a_is_above = b.tunnel;
    const double s_a = shared.s_m(crossing.path_a, crossing.segment_a, crossing.fraction_a);
    const double s_b = shared.s_m(crossing.path_b, crossing.segment_b, crossing.fraction_b);
    const double half_a = half_width_m(a, crossing.segment_a), half_b = half_width_m(b, crossing.segment_b);
    std::string reason = "by its layer";
    level.has_room = !shared.meet_within(crossing.path_a, s_a, crossing.path_b, s_b, meeting_m);
    if (!a_is_above) {
      if (!level.has_room) continue;
      const auto overshoots = [&](std::size_t path, double s, double half_of_other) {
        return (shared.is_loose_end(roads, path, false) && s <= half_of_other + overshoot_m) ||
               (shared.is_loose_end(roads, path, true) && shared.length_m(path) - s <= half_of_other + overshoot_m);
      };
      if (overshoots(crossing.path_a, s_a, half_b) || overshoots(crossing.path_b, s_b, half_a)) {
        report_missing_junction(a, b, crossing, "near the end of one of them", findings);
        continue;
      }
      const double reach_m = 15.0 + 2.0 * terrain.coarsest_gsd_m;
      const double dip_a =
          terrain_dip_m(shared.stations(crossing.path_a), terrain.of_node[crossing.path_a], s_a, half_b + reach_m);
      const double dip_b =
          terrain_dip_m(shared.stations(crossing.path_b), terrain.of_node[crossing.path_b], s_b, half_a + reach_m);
      const bool terrain_tells = std::abs(dip_a - dip_b) > clear_dip_m;
      if (!terrain_tells && !is_never_crossed_at_grade(a) && !is_never_crossed_at_grade(b)) {
        report_missing_junction(a, b, crossing, "and the terrain shows no second level", findings);
        continue;
      }
      a_is_above = terrain_tells ? dip_a > dip_b : road_rank(a.highway) < road_rank(b.highway);
      reason = terrain_tells ? fmt::format("as the terrain dips by {:.1f} m below it", *a_is_above ? dip_a : dip_b)
                             : "as the less important one";
    }
    level.a_is_above = *a_is_above;
    const RoadPath &upper = roads.paths[level.upper()], &lower = roads.paths[level.lower()];
    level.raise = upper.bridge || !lower.tunnel;
    level.untagged = level.raise ? !upper.bridge : !lower.tunnel;
    if (level.untagged)
      findings.push_back(
          {Severity::info, "elevate.assumed_bridge",
           fmt::format(
               "ways {} and {} cross without a common node and neither is tagged as bridge or tunnel: {} passes "
               "over, {}",
               a.osm_id, b.osm_id, upper.osm_id, reason),
           crossing.p.x, crossing.p.y});
    levels.push_back(level);
  }
  add_overlaps(roads, shared, levels);
  return levels;
}

std::vector<Span> untagged_spans(const RoadNetwork& roads, const std::vector<GradeSeparation>& levels) {
  std::vector<Span> spans;
  for (const GradeSeparation& level : levels) {
    if (!level.untagged) continue;
    const PathCrossing& c = level.crossing;
    const auto segment = [&](std::size_t path, std::size_t index) {
      return roads.paths[path].nodes[index + 1].p - roads.paths[path].nodes[index].p;
    };
    const Vec2 along_a = normalized(segment(c.path_a, c.segment_a)),
               along_b = normalized(segment(c.path_b, c.segment_b));
    const double sine = std::max(0.25, std::abs(cross(along_a, along_b)));  // askew bridges are longer
    const std::size_t path = level.upper(), other_path = level.lower();
    const std::size_t index = level.a_is_above ? c.segment_a : c.segment_b,
                      other_index = level.a_is_above ? c.segment_b : c.segment_a;
    const double fraction = level.a_is_above ? c.fraction_a : c.fraction_b;
    const std::vector<double> s = arc_lengths_m(centerline(roads.paths[path]));
    const double half_m =
        (half_width_m(roads.paths[other_path], other_index) + 0.5 * half_width_m(roads.paths[path], index)) / sine;
    spans.push_back({path, s[index] + fraction * (s[index + 1] - s[index]), half_m});
  }
  return spans;
}

}  // namespace orthodrive::elevate
