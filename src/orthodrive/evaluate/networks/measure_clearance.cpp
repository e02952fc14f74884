// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/evaluate/networks/measure_clearance.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>
#include <vector>

#include "orthodrive/geo/vec.hpp"
#include "roadquery/surface/road_surface.hpp"

namespace orthodrive::evaluate {
namespace {
using roadquery::LinkKind;
using roadquery::Road;
using roadquery::RoadMap;
using roadquery::RoadsById;

/// A piece of a reference line.
struct LinePiece {
  std::size_t road = 0;
  Vec3 a, b;
};

std::vector<LinePiece> pieces_of(const RoadMap& map) {
  constexpr double step_m = 5.0;  // a clothoid of 15 m radius leaves its chord by 0.2 m: nothing in height
  std::vector<LinePiece> pieces;
  for (std::size_t i = 0; i < map.roads.size(); ++i) {
    const Road& road = map.roads[i];
    const auto at = [&](double s) {
      const roadquery::PlanPoint p = roadquery::reference_point(road, s);
      return Vec3{p.x, p.y, roadquery::elevation(road, s)};
    };
    const int n = std::max(1, static_cast<int>(std::ceil(road.length / step_m)));
    for (int k = 0; k < n; ++k) pieces.push_back({i, at(road.length * k / n), at(road.length * (k + 1) / n)});
  }
  return pieces;
}

/// Roads that meet at a joint or in a junction touch there; that is no bridge.
bool meet(const Road& a, const Road& b) {
  const auto leads_to = [](const Road& from, const Road& to) {
    for (const roadquery::RoadLink* link : {&from.predecessor, &from.successor}) {
      if (link->kind == LinkKind::road && link->id == to.id) return true;
      if (link->kind != LinkKind::junction) continue;
      if (to.junction == link->id) return true;
      for (const roadquery::RoadLink* other : {&to.predecessor, &to.successor})
        if (other->kind == LinkKind::junction && other->id == link->id) return true;
    }
    return false;
  };
  return leads_to(a, b) || leads_to(b, a) || (a.junction >= 0 && a.junction == b.junction);
}

struct Layers {
  int low = 0, high = 0;
};
/// A connecting road may lead from one layer to another: it lies on both.
std::vector<Layers> layers_of(const RoadMap& map, const RoadsById& by_id) {
  std::vector<Layers> layers;
  for (const Road& road : map.roads) {
    Layers& own = layers.emplace_back(Layers{road.layer, road.layer});
    if (road.junction < 0) continue;
    for (const roadquery::RoadLink* link : {&road.predecessor, &road.successor})
      if (const auto other = link->kind == LinkKind::road ? by_id.find(link->id) : std::nullopt)
        own = {std::min(own.low, map.roads[*other].layer), std::max(own.high, map.roads[*other].layer)};
  }
  return layers;
}
}  // namespace

/// Sweep over x: pieces are short, so few overlap at a time.
void measure_clearance(const RoadMap& map, const RoadsById& by_id, NetworkScores& scores) {
  constexpr double two_levels_m = 1.0;  // nearer, on one layer: a junction that the map lacks, as in evaluate_heights
  scores.min_clearance_m = std::numeric_limits<double>::quiet_NaN();
  const std::vector<Layers> layers = layers_of(map, by_id);
  std::vector<LinePiece> pieces = pieces_of(map);
  const auto min_x = [](const LinePiece& p) { return std::min(p.a.x, p.b.x); };
  const auto max_x = [](const LinePiece& p) { return std::max(p.a.x, p.b.x); };
  std::sort(pieces.begin(), pieces.end(), [&](const LinePiece& p, const LinePiece& q) {
    return std::pair(min_x(p), p.road) < std::pair(min_x(q), q.road);
  });
  for (std::size_t i = 0; i < pieces.size(); ++i)
    for (std::size_t k = i + 1; k < pieces.size() && min_x(pieces[k]) <= max_x(pieces[i]); ++k) {
      const LinePiece &p = pieces[i], &q = pieces[k];
      const Road &first = map.roads[p.road], &second = map.roads[q.road];
      const Vec2 d{p.b.x - p.a.x, p.b.y - p.a.y}, e{q.b.x - q.a.x, q.b.y - q.a.y},
          between{q.a.x - p.a.x, q.a.y - p.a.y};
      const double denominator = cross(d, e);
      if (denominator == 0.0) continue;
      const double u = cross(between, e) / denominator, v = cross(between, d) / denominator;
      if (u < 0.0 || u >= 1.0 || v < 0.0 || v >= 1.0 || meet(first, second)) continue;
      const double above = p.a.z + u * (p.b.z - p.a.z) - q.a.z - v * (q.b.z - q.a.z);
      const Layers &a = layers[p.road], &b = layers[q.road];
      if (a.low <= b.high && b.low <= a.high && std::abs(above) < two_levels_m) continue;
      const Road &upper = above >= 0.0 ? first : second, &lower = above >= 0.0 ? second : first;
      scores.crossing_places.push_back({upper.id, lower.id, upper.osm_id, lower.osm_id, upper.highway, lower.highway,
                                        upper.layer, lower.layer, upper.bridge, p.a.x + u * d.x, p.a.y + u * d.y,
                                        std::abs(above)});
    }
  std::sort(scores.crossing_places.begin(), scores.crossing_places.end(), [](const Overpass& a, const Overpass& b) {
    return std::tuple(a.clearance_m, a.upper_road, a.lower_road) <
           std::tuple(b.clearance_m, b.upper_road, b.lower_road);
  });
  scores.crossings = scores.crossing_places.size();
  if (scores.crossings > 0) scores.min_clearance_m = scores.crossing_places.front().clearance_m;
}

}  // namespace orthodrive::evaluate
