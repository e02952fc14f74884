// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/pipeline/stages/road_relief.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "orthodrive/core/random.hpp"
#include "orthodrive/geo/segment.hpp"
#include "roadquery/surface/road_surface.hpp"

namespace orthodrive {
namespace {

using roadquery::Road;

/// Of a point, on a line with arc lengths s_m.
struct Foot {
  double s_m = 0.0, left_m = 0.0, distance_m = std::numeric_limits<double>::infinity();
  Vec2 along;
};

Foot foot_on(const Polyline& line, const std::vector<double>& s_m, Vec2 p) {
  Foot best;
  for (std::size_t i = 0; i + 1 < line.size(); ++i) {
    const Vec2 d = line[i + 1] - line[i];
    const double n2 = dot(d, d);
    if (n2 == 0.0) continue;
    const double u = share_along(line[i], line[i + 1], p);
    const Vec2 off = p - (line[i] + d * u);
    if (length(off) >= best.distance_m) continue;
    best = {s_m[i] + u * (s_m[i + 1] - s_m[i]), cross(d, off) / std::sqrt(n2), length(off), normalized(d)};
  }
  return best;
}

Vec2 left_at(const Road& road, double s) {
  const roadquery::PlanPoint q = roadquery::reference_point(road, s);
  return {-std::sin(q.hdg), std::cos(q.hdg)};
}
Vec2 point_at(const Road& road, double s) {
  const roadquery::PlanPoint q = roadquery::reference_point(road, s);
  return {q.x, q.y};
}

}  // namespace

RoadRelief::RoadRelief(const RoadNetwork& roads, const std::vector<RoughnessStretch>& roughness,
                       double shortest_wave_m) {
  RoughnessFieldOptions options;
  options.shortest_wave_m = std::max(options.shortest_wave_m, shortest_wave_m);
  for (const RoadPath& path : roads.paths) {
    std::vector<RoughnessStretch> own;
    for (const RoughnessStretch& stretch : roughness)
      if (stretch.osm_id == path.osm_id && stretch.part == path.part) own.push_back(stretch);
    if (own.empty()) continue;
    std::vector<double> s_m;
    s_m.reserve(path.nodes.size());
    for (const RoadNode& node : path.nodes) s_m.push_back(node.s_m);
    const std::uint64_t seed =
        derive_seed(static_cast<std::uint64_t>(path.osm_id), static_cast<std::uint64_t>(path.part));
    ways_.push_back(std::make_shared<const Way>(
        Way{path.osm_id, centerline(path), std::move(s_m), RoughnessField(std::move(own), seed, options)}));
  }
}

/// Of the parts of the road's way the one that it lies on.
std::shared_ptr<const RoadRelief::Way> RoadRelief::way_of(const Road& road) const {
  const Vec2 middle = point_at(road, 0.5 * road.length);
  std::shared_ptr<const Way> best;
  double nearest_m = std::numeric_limits<double>::infinity();
  for (const auto& way : ways_) {
    if (std::to_string(way->osm_id) != road.osm_id) continue;
    const double distance_m = foot_on(way->line, way->s_m, middle).distance_m;
    if (distance_m < nearest_m) nearest_m = distance_m, best = way;
  }
  return best;
}

/// Places of the road's line on the way's are looked up once, a metre apart; across both are straight.
RoadRelief::Height RoadRelief::along(const std::shared_ptr<const Way>& way, const Road& road) {
  constexpr double step_m = 1.0;
  struct ReliefStation {
    double s_m, t_m;
    Vec2 per_t;  ///< how s and t of the way change with t of the road
  };
  const auto count = static_cast<std::size_t>(std::max(1.0, std::ceil(road.length / step_m)));
  std::vector<ReliefStation> places;
  for (std::size_t i = 0; i <= count; ++i) {
    const double s = road.length * static_cast<double>(i) / static_cast<double>(count);
    const Foot foot = foot_on(way->line, way->s_m, point_at(road, s));
    const Vec2 left = left_at(road, s);
    places.push_back({foot.s_m, foot.left_m, {dot(left, foot.along), cross(foot.along, left)}});
  }
  return [way, places = std::move(places), length_m = road.length](double s, double t) {
    const double x = std::clamp(s / length_m, 0.0, 1.0) * static_cast<double>(places.size() - 1);
    const std::size_t i = std::min(static_cast<std::size_t>(x), places.size() - 2);
    const ReliefStation &a = places[i], &b = places[i + 1];
    const double u = x - static_cast<double>(i);
    const auto mix = [u](double from, double to) { return from + u * (to - from); };
    return way->field.height_m(mix(a.s_m + a.per_t.x * t, b.s_m + b.per_t.x * t),
                               mix(a.t_m + a.per_t.y * t, b.t_m + b.per_t.y * t));
  };
}

RoadRelief::Height RoadRelief::of(const roadquery::RoadMap& map, const Road& road) const {
  if (!road.osm_id.empty()) {
    const auto way = way_of(road);
    return way ? along(way, road) : Height{};
  }
  const auto beside = [&](const roadquery::RoadLink& link) -> std::shared_ptr<const Way> {
    if (link.kind != roadquery::LinkKind::road) return nullptr;
    const auto found =
        std::lower_bound(map.roads.begin(), map.roads.end(), link.id, [](const Road& r, int id) { return r.id < id; });
    return found != map.roads.end() && found->id == link.id ? way_of(*found) : nullptr;
  };
  const auto from = beside(road.predecessor), to = beside(road.successor);
  if (!from && !to) return {};
  const Height first = from ? along(from, road) : Height{}, last = to ? along(to, road) : Height{};
  return [first, last, length_m = road.length](double s, double t) {
    const double u = std::clamp(s / length_m, 0.0, 1.0), share = u * u * (3.0 - 2.0 * u);
    return (first ? (1.0 - share) * first(s, t) : 0.0) + (last ? share * last(s, t) : 0.0);
  };
}

}  // namespace orthodrive
