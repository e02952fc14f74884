// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/network/junctions/junction_area.hpp"

#include <algorithm>
#include <cmath>

#include "orthodrive/geo/overlay.hpp"
#include "orthodrive/model/roads/road_network.hpp"
#include "orthodrive/network/curves/fit_plan.hpp"

namespace orthodrive::network {
namespace {

constexpr double grid_m = 1e-3;
constexpr double join_m = 1e-4;  // pieces that grow by so little join, several times as fast as by a union
constexpr double area_overlap_m = 0.015, simplify_m = 0.005;  // the first holds the second and the millimetres of files
constexpr double sliver_m = 0.05;                             // tips of corners narrower than twice this are left out
constexpr double other_width_m = 15.0;                        // half the width of other roads, at most
constexpr double side_by_side_m = 15.0, side_by_side_cos = 0.77;  // arms so near to each other, 40 degrees apart
constexpr double turned_round_m = 4.0;  // radius of the end of a gore: a car turns in and out while it goes round
// Of a quarter circle: chords of kerbs within 1.5 cm of their arcs; what only bounds or rounds needs no more than a
// few.
constexpr double arc_steps_of_1_m = 4.5;
constexpr int near_arc_steps = 4, tip_arc_steps = 2;
constexpr double largest_gap_m2 = 30.0;  // larger holes are islands, unless the closing filled them
constexpr double least_verge_m2 = 4.0;   // between arms; what is smaller and paved all round is paved

const Box2 everywhere{-INFINITY, -INFINITY, INFINITY, INFINITY};

std::vector<Polygon> pieces_of(const std::vector<const roadquery::Road*>& roads, Vec2 origin, bool with_sidewalks,
                               const Box2& box = everywhere) {
  std::vector<Polygon> all;
  for (const roadquery::Road* road : roads)
    for (Polygon& piece : RoadCover(*road, origin, 0.0, road->length).pieces(with_sidewalks, box))
      all.push_back(std::move(piece));
  return all;
}

/// The carriageways (or whole widths) of the arms within reach.
std::vector<Polygon> arm_pieces(const JunctionRoads& roads, Vec2 origin, bool with_sidewalks) {
  std::vector<Polygon> all;
  for (std::size_t i = 0; i < roads.arms.size(); ++i) {
    const roadquery::Road& road = *roads.arms[i];
    const double reach = std::min(arm_reach_m, road.length);
    const double s0 = roads.at_end[i] ? road.length - reach : 0.0;
    for (Polygon& piece : RoadCover(road, origin, s0, s0 + reach).pieces(with_sidewalks, everywhere))
      all.push_back(std::move(piece));
  }
  return all;
}

bool touches(const Polygon& part, const MultiPolygon& other) {
  return std::any_of(part.outer.begin(), part.outer.end(), [&](Vec2 p) { return contains(other, p); });
}

/// Whether cars turn from one arm into the other.
bool is_turn_between(const JunctionRoads& roads, std::size_t a, std::size_t b) {
  const int id_a = roads.arms[a]->id, id_b = roads.arms[b]->id;
  return std::ranges::any_of(roads.connecting, [&](const roadquery::Road* road) {
    const int from = road->predecessor.id, to = road->successor.id;
    return (from == id_a && to == id_b) || (from == id_b && to == id_a);
  });
}

/// The verge or island between two arms that leave side by side.
struct Gore {
  Polygon area;
  bool is_turned_round = false;  ///< by cars from the one arm to the other
};

std::vector<Gore> gores_of(const JunctionRoads& roads, Vec2 origin) {
  const auto end_of = [&](std::size_t i) {
    const roadquery::Road& road = *roads.arms[i];
    const roadquery::PlanPoint p = roadquery::reference_point(road, roads.at_end[i] ? road.length : 0.0);
    const double outwards = roads.at_end[i] ? -1.0 : 1.0;
    return Pose{Vec2{p.x, p.y} - origin, Vec2{std::cos(p.hdg), std::sin(p.hdg)} * outwards};
  };
  const auto add_corners = [&](std::size_t i, double reach_m, std::vector<Vec2>& corners) {
    const roadquery::Road& road = *roads.arms[i];
    const double reach = std::min(reach_m, road.length), s0 = roads.at_end[i] ? road.length - reach : 0.0;
    for (const Polygon& piece : RoadCover(road, origin, s0, s0 + reach).pieces(true, everywhere))
      corners.insert(corners.end(), piece.outer.begin(), piece.outer.end());
  };
  std::vector<Gore> gores;
  for (std::size_t i = 0; i < roads.arms.size(); ++i)
    for (std::size_t k = i + 1; k < roads.arms.size(); ++k) {
      const Pose a = end_of(i), b = end_of(k);
      if (dot(a.direction, b.direction) < side_by_side_cos || distance(a.p, b.p) > side_by_side_m) continue;
      const bool is_turned_round = is_turn_between(roads, i, k);
      std::vector<Vec2> corners;
      for (const std::size_t arm : {i, k}) add_corners(arm, is_turned_round ? arm_reach_m : side_by_side_m, corners);
      Ring hull = convex_hull(std::move(corners));
      if (hull.size() >= 3) gores.push_back({{std::move(hull), {}}, is_turned_round});
    }
  return gores;
}

MultiPolygon without(const MultiPolygon& area, const std::vector<Polygon>& taken) {
  return taken.empty() ? area : difference_of(area, buffer_of(taken, join_m, 1), grid_m);
}

/// The corners and gaps that closing adds to the connecting roads, without what belongs to other roads and without
/// pieces that lie apart from the connecting roads. A kerb goes round the end of a gore and does not fill it; where
/// cars turn round that end it leaves them the room that they need.
MultiPolygon filled_corners(const JunctionRoads& roads, const MultiPolygon& connecting, double radius_m, Vec2 origin) {
  std::vector<Polygon> open = arm_pieces(roads, origin, false);
  open.insert(open.end(), connecting.begin(), connecting.end());
  const auto closed = [&open](double by_m) {
    const int steps = static_cast<int>(std::ceil(arc_steps_of_1_m * std::sqrt(by_m)));
    return buffer_of(buffer_of(open, by_m, steps), -by_m, steps);
  };
  Box2 box = bounds_of(connecting.front().outer);
  for (const Polygon& part : connecting) {
    const Box2 b = bounds_of(part.outer);
    box = {std::min(box.min_x, b.min_x), std::min(box.min_y, b.min_y), std::max(box.max_x, b.max_x),
           std::max(box.max_y, b.max_y)};
  }
  std::vector<Polygon> taken = pieces_of(roads.others, origin, true, box.grown(radius_m + other_width_m));
  for (Polygon& piece : arm_pieces(roads, origin, true)) taken.push_back(std::move(piece));
  std::vector<Polygon> turned_round;
  const std::size_t roads_taken = taken.size();
  for (Gore& gore : gores_of(roads, origin)) {
    if (gore.is_turned_round) turned_round.push_back(gore.area);
    taken.push_back(std::move(gore.area));
  }
  // No corner is further from the connecting roads than its own radius.
  MultiPolygon corners =
      without(intersection_of(closed(radius_m), buffer_of(connecting, radius_m, near_arc_steps), grid_m), taken);
  if (!turned_round.empty()) {
    taken.resize(roads_taken);
    const MultiPolygon gores = buffer_of(turned_round, join_m, 1);
    for (Polygon& tip : without(intersection_of(closed(turned_round_m), gores, grid_m), taken))
      corners.push_back(std::move(tip));
    corners = buffer_of(corners, join_m, 1);
  }
  corners = buffer_of(buffer_of(corners, -sliver_m, tip_arc_steps), sliver_m, tip_arc_steps);
  const MultiPolygon reach = buffer_of(connecting, 2.0 * area_overlap_m, tip_arc_steps);
  std::erase_if(corners, [&](const Polygon& part) { return !touches(part, reach); });
  return corners;
}

/// What arms that leave side by side and touch further out keep between them and the area, where that is too little for
/// a verge.
MultiPolygon closed_gaps(const JunctionRoads& roads, const MultiPolygon& area, Vec2 origin) {
  if (gores_of(roads, origin).empty()) return {};
  std::vector<Polygon> paved = arm_pieces(roads, origin, true);
  paved.insert(paved.end(), area.begin(), area.end());
  MultiPolygon gaps;
  for (const Polygon& part : buffer_of(paved, join_m, 1))
    for (Ring hole : part.holes) {
      if (std::abs(signed_area_m2(hole)) > least_verge_m2) continue;
      std::reverse(hole.begin(), hole.end());
      gaps.push_back({std::move(hole), {}});
    }
  if (gaps.empty()) return {};
  const MultiPolygon reach = buffer_of(area, 2.0 * area_overlap_m, tip_arc_steps);
  std::erase_if(gaps, [&](const Polygon& gap) { return !touches(gap, reach); });
  const std::vector<Polygon> others =
      pieces_of(roads.others, origin, true, bounds_of(area.front().outer).grown(other_width_m));
  if (gaps.empty() || others.empty()) return gaps;
  return difference_of(gaps, buffer_of(others, join_m, 1), grid_m);
}

/// What is paved besides, as far as it is no other road's.
MultiPolygon paved_besides(const JunctionRoads& roads, Vec2 origin) {
  std::vector<Polygon> taken = arm_pieces(roads, origin, true);
  for (const Polygon& part : roads.paved)
    for (Polygon& piece : pieces_of(roads.others, origin, true, bounds_of(part.outer).grown(other_width_m)))
      taken.push_back(std::move(piece));
  const MultiPolygon besides = without(roads.paved, taken);
  return buffer_of(buffer_of(besides, -sliver_m, tip_arc_steps), sliver_m, tip_arc_steps);
}

struct Bridge {
  std::size_t from = 0, to = 0;
  double length_m = INFINITY;
};

Bridge shortest_bridge(const Ring& a, const Ring& b) {
  Bridge best;
  for (std::size_t i = 0; i < a.size(); ++i)
    for (std::size_t k = 0; k < b.size(); ++k)
      if (const double d = distance(a[i], b[k]); d < best.length_m) best = {i, k, d};
  return best;
}

}  // namespace

double kerb_radius_m(std::vector<std::string> highways) {
  constexpr double main_m = 12.0, collector_m = 8.0, residential_m = 5.0, access_m = 3.0;
  int rank = 0;
  if (!highways.empty()) {
    std::sort(highways.begin(), highways.end(),
              [](const std::string& a, const std::string& b) { return road_rank(a) > road_rank(b); });
    rank = road_rank(highways[std::min<std::size_t>(2, highways.size() - 1)]);
  }
  if (rank >= road_rank("primary")) return main_m;
  if (rank >= road_rank("tertiary_link")) return collector_m;
  return rank >= road_rank("living_street") ? residential_m : access_m;
}

MultiPolygon junction_area(const JunctionRoads& roads, double kerb_radius_m, Vec2 origin) {
  const std::vector<Polygon> pieces = pieces_of(roads.connecting, origin, false);
  const MultiPolygon connecting = pieces.empty() ? MultiPolygon{} : buffer_of(pieces, join_m, 1);
  if (connecting.empty()) return {};
  MultiPolygon area = filled_corners(roads, connecting, kerb_radius_m, origin);
  area.insert(area.end(), connecting.begin(), connecting.end());
  if (!roads.paved.empty())
    for (Polygon& part : paved_besides(roads, origin)) area.push_back(std::move(part));
  area = buffer_of(area, area_overlap_m, 2);
  if (const MultiPolygon gaps = closed_gaps(roads, area, origin); !gaps.empty()) {
    area.insert(area.end(), gaps.begin(), gaps.end());
    area = buffer_of(area, area_overlap_m, 2);
  }
  for (Polygon& part : area)
    std::erase_if(part.holes, [](const Ring& hole) { return std::abs(signed_area_m2(hole)) < largest_gap_m2; });
  return simplified(area, simplify_m);
}

Ring woven_ring(const MultiPolygon& polygons) {
  std::vector<Ring> rings;
  rings.reserve(polygons.size());
  for (const Polygon& polygon : polygons) {
    rings.push_back(polygon.outer);
    rings.insert(rings.end(), polygon.holes.begin(), polygon.holes.end());
  }
  if (rings.empty()) return {};
  Ring ring = rings.front();
  rings.erase(rings.begin());
  while (!rings.empty()) {
    std::size_t next = 0;
    Bridge best;
    for (std::size_t i = 0; i < rings.size(); ++i)
      if (const Bridge bridge = shortest_bridge(ring, rings[i]); bridge.length_m < best.length_m)
        best = bridge, next = i;
    Ring& other = rings[next];
    std::rotate(other.begin(), other.begin() + static_cast<std::ptrdiff_t>(best.to), other.end());
    other.push_back(other.front());
    other.push_back(ring[best.from]);
    ring.insert(ring.begin() + static_cast<std::ptrdiff_t>(best.from) + 1, other.begin(), other.end());
    rings.erase(rings.begin() + static_cast<std::ptrdiff_t>(next));
  }
  return ring;
}

}  // namespace orthodrive::network
