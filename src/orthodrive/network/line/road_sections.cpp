// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/network/line/road_sections.hpp"

#include <algorithm>
#include <cmath>

#include "orthodrive/network/lanes/lanes.hpp"
#include "roadquery/surface/blend.hpp"
#include "roadquery/surface/road_surface.hpp"

namespace orthodrive::network {
namespace {

constexpr double side_by_side_sin = 0.5, deepest_fork_m = 1.5;
constexpr double most_given_m =
    1.5;  // by the greater road, for what the lesser has not got: else that is mapped wrongly
constexpr double shortest_road_m = 4.0;  // shorter ones lie inside the surfaces of their junctions

double curvature_at(const std::vector<roadquery::PlanElement>& plan, double s) {
  const auto after = std::upper_bound(plan.begin() + 1, plan.end(), s,
                                      [](double v, const roadquery::PlanElement& e) { return v < e.s; });
  return roadquery::evaluate(*(after - 1), s - (after - 1)->s).curvature;
}

int junction_at(const JunctionPlan& junctions, VertexIndex vertex) {
  return vertex ? junctions.junction_of_vertex[vertex] : -1;
}

/// By how much the two lie on each other; not positive where they do not, or where they are no neighbours.
double overlap_m(const RoadSection& a, const RoadSection& b, const JunctionPlan& junctions) {
  if (!are_side_by_side(a, b) || !roadquery::is_same_level(a.z, b.z)) return 0.0;
  const double left_m = cross(a.direction, b.p - a.p), apart_m = std::abs(left_m);
  const double overlap = a.half_m + b.half_m + section_margin_m - apart_m;
  if (overlap > (part_at_a_node(a, b, junctions) ? deepest_fork_m : deepest_overlap_m) || overlap < -widest_bank_m)
    return 0.0;
  // Both surfaces where they meet.
  const double meet_m = 0.5 * (a.half_m + apart_m - b.half_m);
  const Vec2 at = a.p + left_normal(a.direction) * (left_m < 0.0 ? -meet_m : meet_m);
  return overlap + bank_m(std::abs(a.height_at(at) - b.height_at(at)));
}

}  // namespace

RoadSection SectionMaker::at(std::size_t stretch, int junction, double s) const {
  const ChainIndex chain = junctions_.stretches[stretch].chain;
  const ChainGeometry& on = geometry_[chain];
  const Pose pose = pose_at(on.plan, s);
  const DirectedPiece piece = topology_.chains[chain].pieces[piece_at(on, s)];
  const RoadPath& path = roads_.paths[topology_.pieces[piece.piece].path];
  const double half = 0.5 * width_at(on, s);
  const double least = 0.5 * least_carriageway_m(path, curvature_at(on.plan, s));
  return {.chain = chain,
          .stretch = stretch,
          .junction = junction,
          .s = s,
          .half_m = half,
          .least_half_m = std::min(half, least),
          .z = value_at(on.elevation, s),
          .gradient = slope_at(on.elevation, s),
          .banking = std::tan(value_at(on.superelevation, s)),
          .crown = value_at(on.crown, s),
          .rank = road_rank(path.highway),
          .p = pose.p,
          .direction = pose.direction};
}

std::vector<RoadSection> SectionMaker::all(const Cuts& cuts) const {
  std::vector<RoadSection> sections;
  for (std::size_t i = 0; i < junctions_.stretches.size(); ++i) {
    const Stretch& stretch = junctions_.stretches[i];
    const auto add = [&](double from, double to, int junction) {
      const int steps = static_cast<int>(std::ceil((to - from) / section_step_m));
      for (int k = 0; k <= steps; ++k) sections.push_back(at(i, junction, from + (to - from) * k / steps));
    };
    const int before = junction_at(junctions_, stretch.vertex0), after = junction_at(junctions_, stretch.vertex1);
    if (stretch.inside) {
      if (before >= 0 && stretch.s1 > stretch.s0) add(stretch.s0, stretch.s1, before);
      continue;
    }
    const double from = cuts[i].front(), to = cuts[i].back();
    if (before >= 0 && from > stretch.s0) add(stretch.s0, from, before);
    if (to - from >= shortest_road_m) add(from, to, -1);
    if (after >= 0 && to < stretch.s1) add(to, stretch.s1, after);
  }
  return sections;
}

SectionIndex::SectionIndex(const std::vector<RoadSection>& sections) {
  std::vector<Box2> boxes;
  for (const RoadSection& q : sections) {
    widest_m_ = std::max(widest_m_, q.half_m);
    boxes.push_back({q.p.x, q.p.y, q.p.x, q.p.y});
  }
  index_ = SpatialIndex(boxes);
}

std::vector<std::uint32_t> SectionIndex::near(Vec2 p, double reach_m) const {
  return index_.near(p, reach_m + widest_m_ + section_step_m);
}

double bank_m(double z_step_m) { return z_step_m < flush_m ? 0.0 : std::min(z_step_m, widest_bank_m); }

bool gives_way(const RoadSection& a, const RoadSection& b) {
  if (a.rank != b.rank) return a.rank < b.rank;
  return a.half_m != b.half_m ? a.half_m < b.half_m : a.stretch > b.stretch;
}

bool is_own_junction(const RoadSection& road, const RoadSection& other, const JunctionPlan& junctions) {
  const Stretch& stretch = junctions.stretches[road.stretch];
  return other.junction >= 0 && (other.junction == junction_at(junctions, stretch.vertex0) ||
                                 other.junction == junction_at(junctions, stretch.vertex1));
}

bool part_at_a_node(const RoadSection& a, const RoadSection& b, const JunctionPlan& junctions) {
  const Stretch &of_a = junctions.stretches[a.stretch], &of_b = junctions.stretches[b.stretch];
  const auto ends_at = [&](VertexIndex vertex) { return vertex && (vertex == of_b.vertex0 || vertex == of_b.vertex1); };
  return ends_at(of_a.vertex0) || ends_at(of_a.vertex1);
}

bool are_side_by_side(const RoadSection& a, const RoadSection& b) {
  return a.stretch != b.stretch && std::abs(dot(b.p - a.p, a.direction)) <= section_step_m &&
         std::abs(cross(a.direction, b.direction)) <= side_by_side_sin;
}

std::vector<double> room_of(const std::vector<RoadSection>& sections, const JunctionPlan& junctions) {
  const SectionIndex index(sections);
  std::vector<double> room;
  for (const RoadSection& q : sections) {
    double half = q.half_m;
    if (q.junction >= 0) {
      room.push_back(half);
      continue;
    }
    for (const std::uint32_t k : index.near(q.p, q.half_m)) {
      const RoadSection& other = sections[k];
      const double overlap = is_own_junction(q, other, junctions) ? 0.0 : overlap_m(q, other, junctions);
      if (overlap <= section_margin_m) continue;
      if (other.junction >= 0) {
        half = std::min(half, q.half_m - overlap);
        continue;
      }
      // What the one that gives way has not got falls to the other.
      const bool yields = gives_way(q, other);
      const RoadSection& lesser = yields ? q : other;
      const double given = std::min(overlap, lesser.half_m - lesser.least_half_m);
      const double lacks = overlap - given;
      half = std::min(half, q.half_m - (yields ? given : lacks > most_given_m ? 0.0 : lacks));
    }
    room.push_back(std::max(half, q.least_half_m));
  }
  return room;
}

}  // namespace orthodrive::network
