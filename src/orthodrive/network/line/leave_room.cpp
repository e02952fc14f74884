// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/network/line/leave_room.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "orthodrive/geo/spatial_index.hpp"
#include "orthodrive/network/lanes/lanes.hpp"
#include "roadquery/blend.hpp"
#include "roadquery/road_surface.hpp"

namespace orthodrive::network {
namespace {

constexpr double step_m = 1.0, margin_m = 0.1;  // the second: widths are fitted within 5 cm, on both roads
constexpr double flush_m = 0.01;                // lower steps between two surfaces need no bank
constexpr double widest_bank_m = 0.5;           // between roads of different heights, 45 degrees steep
constexpr double side_by_side_sin = 0.5, deepest_m = 5.0, deepest_fork_m = 1.5;
constexpr double most_given_m =
    1.5;                        // by the greater road, for what the lesser has not got: else that is mapped wrongly
constexpr double taper = 0.05;  // the middle of an outer lane moves by 3/8 of that at most: about 1 degree
constexpr double taper_reach_m = 2.0 * deepest_m / taper;
constexpr double shortest_road_m = 4.0;  // shorter ones lie inside the surfaces of their junctions
constexpr double shortened_m = 10.0;     // dead ends, at most, and by no more than half of their road
constexpr double end_step_m = 0.25, across_step_m = 0.5;

/// A cross section of a road, or of a way inside a junction.
struct Section {
  ChainIndex chain;
  std::size_t stretch = 0;
  int junction = -1;  ///< that it lies in
  double s = 0.0, half_m = 0.0, least_half_m = 0.0, z = 0.0;
  double banking = 0.0, crown = 0.0;  ///< tangents
  int rank = 0;
  Vec2 p, direction;

  /// Of its plane, carried on beyond its edges.
  [[nodiscard]] double height_at(Vec2 at) const {
    const double left_m = cross(direction, at - p);
    return z + left_m * banking - std::abs(left_m) * crown;
  }
};

double curvature_at(const std::vector<roadquery::PlanElement>& plan, double s) {
  const auto after = std::upper_bound(plan.begin() + 1, plan.end(), s,
                                      [](double v, const roadquery::PlanElement& e) { return v < e.s; });
  return roadquery::evaluate(*(after - 1), s - (after - 1)->s).curvature;
}

int junction_at(const JunctionPlan& junctions, VertexIndex vertex) {
  return vertex ? junctions.junction_of_vertex[vertex] : -1;
}

using Cuts = std::vector<std::vector<double>>;

class SectionMaker {
 public:
  SectionMaker(const RoadNetwork& roads, const Topology& topology, const JunctionPlan& junctions,
               const ChainGeometries& geometry)
      : roads_(roads), topology_(topology), junctions_(junctions), geometry_(geometry) {}

  [[nodiscard]] Section at(std::size_t stretch, int junction, double s) const {
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
            .banking = std::tan(value_at(on.superelevation, s)),
            .crown = value_at(on.crown, s),
            .rank = road_rank(path.highway),
            .p = pose.p,
            .direction = pose.direction};
  }

  /// Of all roads and of what lies inside junctions.
  [[nodiscard]] std::vector<Section> all(const Cuts& cuts) const {
    std::vector<Section> sections;
    for (std::size_t i = 0; i < junctions_.stretches.size(); ++i) {
      const Stretch& stretch = junctions_.stretches[i];
      const auto add = [&](double from, double to, int junction) {
        const int steps = static_cast<int>(std::ceil((to - from) / step_m));
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

 private:
  const RoadNetwork& roads_;
  const Topology& topology_;
  const JunctionPlan& junctions_;
  const ChainGeometries& geometry_;
};

class SectionIndex {
 public:
  explicit SectionIndex(const std::vector<Section>& sections) {
    std::vector<Box2> boxes;
    for (const Section& q : sections) {
      widest_m_ = std::max(widest_m_, q.half_m);
      boxes.push_back({q.p.x, q.p.y, q.p.x, q.p.y});
    }
    index_ = SpatialIndex(boxes);
  }
  /// All whose roads may reach so near.
  [[nodiscard]] std::vector<std::uint32_t> near(Vec2 p, double reach_m) const {
    return index_.near(p, reach_m + widest_m_ + step_m);
  }

 private:
  SpatialIndex index_;
  double widest_m_ = 0.0;
};

bool gives_way(const Section& a, const Section& b) {
  if (a.rank != b.rank) return a.rank < b.rank;
  return a.half_m != b.half_m ? a.half_m < b.half_m : a.stretch > b.stretch;
}

/// Whether the junction that `other` lies in is one of the road's own.
bool is_own_junction(const Section& road, const Section& other, const JunctionPlan& junctions) {
  const Stretch& stretch = junctions.stretches[road.stretch];
  return other.junction >= 0 && (other.junction == junction_at(junctions, stretch.vertex0) ||
                                 other.junction == junction_at(junctions, stretch.vertex1));
}

double bank_m(double z_step_m) { return z_step_m < flush_m ? 0.0 : std::min(z_step_m, widest_bank_m); }

/// Roads that part at one node lie on each other until they are apart: there both keep their width for longer.
bool part_at_a_node(const Section& a, const Section& b, const JunctionPlan& junctions) {
  const Stretch &of_a = junctions.stretches[a.stretch], &of_b = junctions.stretches[b.stretch];
  const auto ends_at = [&](VertexIndex vertex) { return vertex && (vertex == of_b.vertex0 || vertex == of_b.vertex1); };
  return ends_at(of_a.vertex0) || ends_at(of_a.vertex1);
}

/// By how much the two lie on each other; not positive where they do not, or where they are no neighbours.
double overlap_m(const Section& a, const Section& b, const JunctionPlan& junctions) {
  const Vec2 d = b.p - a.p;
  if (a.stretch == b.stretch || std::abs(dot(d, a.direction)) > step_m) return 0.0;
  if (std::abs(cross(a.direction, b.direction)) > side_by_side_sin || !roadquery::is_same_level(a.z, b.z)) return 0.0;
  const double left_m = cross(a.direction, d), apart_m = std::abs(left_m);
  const double overlap = a.half_m + b.half_m + margin_m - apart_m;
  if (overlap > (part_at_a_node(a, b, junctions) ? deepest_fork_m : deepest_m) || overlap < -widest_bank_m) return 0.0;
  // Both surfaces where they meet.
  const double meet_m = 0.5 * (a.half_m + apart_m - b.half_m);
  const Vec2 at = a.p + left_normal(a.direction) * (left_m < 0.0 ? -meet_m : meet_m);
  return overlap + bank_m(std::abs(a.height_at(at) - b.height_at(at)));
}

/// Half widths that are left, by section. Those inside junctions keep theirs.
std::vector<double> room_of(const std::vector<Section>& sections, const JunctionPlan& junctions) {
  const SectionIndex index(sections);
  std::vector<double> room;
  for (const Section& q : sections) {
    double half = q.half_m;
    if (q.junction >= 0) {
      room.push_back(half);
      continue;
    }
    for (const std::uint32_t k : index.near(q.p, q.half_m)) {
      const Section& other = sections[k];
      const double overlap = is_own_junction(q, other, junctions) ? 0.0 : overlap_m(q, other, junctions);
      if (overlap <= margin_m) continue;
      if (other.junction >= 0) {
        half = std::min(half, q.half_m - overlap);
        continue;
      }
      // What the one that gives way has not got falls to the other.
      const bool yields = gives_way(q, other);
      const Section& lesser = yields ? q : other;
      const double given = std::min(overlap, lesser.half_m - lesser.least_half_m);
      const double lacks = overlap - given;
      half = std::min(half, q.half_m - (yields ? given : lacks > most_given_m ? 0.0 : lacks));
    }
    room.push_back(std::max(half, q.least_half_m));
  }
  return room;
}

/// Whether a cross section at a dead end touches no other surface of another height.
bool is_clear(const Section& end, const std::vector<Section>& sections, const SectionIndex& index) {
  const int steps = std::max(1, static_cast<int>(std::ceil(2.0 * end.half_m / across_step_m)));
  const std::vector<std::uint32_t> near = index.near(end.p, end.half_m + margin_m + widest_bank_m);
  for (int k = 0; k <= steps; ++k) {
    const Vec2 at = end.p + left_normal(end.direction) * (end.half_m * (2.0 * k / steps - 1.0));
    for (const std::uint32_t i : near) {
      const Section& other = sections[i];
      const Vec2 d = at - other.p;
      if (other.stretch == end.stretch || std::abs(dot(d, other.direction)) > step_m) continue;
      if (!roadquery::is_same_level(end.z, other.z)) continue;
      const double bank = bank_m(std::abs(end.height_at(at) - other.height_at(at)));
      if (bank > 0.0 && std::abs(cross(other.direction, d)) - other.half_m < margin_m + bank) return false;
    }
  }
  return true;
}

struct RoomLimit {
  double s = 0.0, width_m = 0.0;
};

/// Widths of a piece under the limits, which taper.
std::vector<ProfileSample> narrowed(const std::vector<ProfileSample>& widths, const std::vector<RoomLimit>& limits) {
  std::vector<double> places;
  places.reserve(widths.size());
  for (const ProfileSample& sample : widths) places.push_back(sample.s);
  const double from = widths.front().s, to = widths.back().s;
  for (const RoomLimit& limit : limits)
    if (limit.s > from && limit.s < to) places.push_back(limit.s);
  // Where the taper ends, too, there must be places: a metre apart it is near enough.
  for (double s = std::max(from, limits.front().s - taper_reach_m); s < std::min(to, limits.back().s + taper_reach_m);
       s += step_m)
    places.push_back(s);
  std::sort(places.begin(), places.end());
  std::vector<ProfileSample> result;
  for (const double s : places) {
    if (!result.empty() && s - result.back().s < 1e-3 && s < to) continue;
    const auto after = std::lower_bound(widths.begin(), widths.end(), s,
                                        [](const ProfileSample& sample, double x) { return sample.s < x; });
    double width = after == widths.begin() ? widths.front().value : after == widths.end() ? widths.back().value : 0.0;
    if (after != widths.begin() && after != widths.end()) {
      const ProfileSample &a = *(after - 1), &b = *after;
      width = b.s > a.s ? a.value + (b.value - a.value) * (s - a.s) / (b.s - a.s) : b.value;
    }
    for (const RoomLimit& limit : limits) width = std::min(width, limit.width_m + taper * std::abs(s - limit.s));
    result.push_back({s, width});
  }
  return result;
}

}  // namespace

void end_before_roads(const RoadNetwork& roads, const Topology& topology, const JunctionPlan& junctions,
                      const ChainGeometries& geometry, std::vector<std::vector<double>>& cuts) {
  const SectionMaker maker(roads, topology, junctions, geometry);
  const std::vector<Section> sections = maker.all(cuts);
  const SectionIndex index(sections);
  for (std::size_t i = 0; i < cuts.size(); ++i) {
    const Stretch& stretch = junctions.stretches[i];
    if (stretch.inside || geometry[stretch.chain].closed) continue;
    const auto shorten = [&](double& end, double other) {
      const double reach_m = std::min(shortened_m, 0.5 * std::abs(end - other)), inwards = other > end ? 1.0 : -1.0;
      for (double by_m = 0.0; by_m <= reach_m; by_m += end_step_m)
        if (is_clear(maker.at(i, -1, end + inwards * by_m), sections, index)) {
          end += inwards * by_m;
          return;
        }
    };
    if (!stretch.vertex0) shorten(cuts[i].front(), cuts[i][1]);
    if (!stretch.vertex1) shorten(cuts[i].back(), cuts[i][cuts[i].size() - 2]);
  }
}

void leave_room_beside(const RoadNetwork& roads, const Topology& topology, const JunctionPlan& junctions,
                       const std::vector<std::vector<double>>& cuts, ChainGeometries& geometry) {
  const std::vector<Section> sections = SectionMaker(roads, topology, junctions, geometry).all(cuts);
  const std::vector<double> room = room_of(sections, junctions);
  std::map<std::size_t, std::vector<RoomLimit>> limits;  // by the stretch
  for (std::size_t i = 0; i < sections.size(); ++i)
    if (room[i] < sections[i].half_m) limits[sections[i].stretch].push_back({sections[i].s, 2.0 * room[i]});
  for (const auto& [stretch, of_stretch] : limits) {
    ChainGeometry& chain = geometry[junctions.stretches[stretch].chain];
    const Stretch& whole = junctions.stretches[stretch];
    const std::size_t first = piece_at(chain, std::max(whole.s0, of_stretch.front().s - taper_reach_m)),
                      last = piece_at(chain, std::min(whole.s1, of_stretch.back().s + taper_reach_m) - 1e-6);
    for (std::size_t k = first; k <= last; ++k) chain.widths[k] = narrowed(chain.widths[k], of_stretch);
  }
}

}  // namespace orthodrive::network
