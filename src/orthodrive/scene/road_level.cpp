#include "orthodrive/scene/road_level.hpp"

#include <algorithm>
#include <cmath>

#include "orthodrive/core/parallel.hpp"
#include "orthodrive/geo/polygon.hpp"
#include "orthodrive/scene/overlay.hpp"
#include "roadquery/road_surface.hpp"

namespace orthodrive::scene {
namespace {

constexpr double min_piece_area_m2 = 1e-5;
// Holes of the union that are smaller or thinner than this are gaps between edges that should have met.
constexpr double min_hole_area_m2 = 1.0, min_hole_width_m = 0.15;
// Points this far outside still lie on a road: chords of curved edges and the plan grid.
constexpr double border_tolerance_m = 0.03;
constexpr double end_bulge_m = 2.0 * plan_grid_m;  // survives the plan grid, less than border_tolerance_m
constexpr double border_weight_m = 1e-6;  // makes the weight of a road positive on its own border

Vec2 plan(const Vec3& p) { return {p.x, p.y}; }

/// The convex hull of the four corners between two sections: unlike the quadrilateral, it is simple where the inner
/// edge of a tight bend runs backwards.
Ring piece_ring(const CrossSection& a, const CrossSection& b) {
  return convex_hull({snap_to_grid(plan(a.left)), snap_to_grid(plan(a.right)), snap_to_grid(plan(b.left)),
                      snap_to_grid(plan(b.right))});
}

/// A point on the reference line just beyond an end: a crown's ridge reaches an open end only if there is a corner.
void bulge(Ring& ring, const roadquery::Road& road, const CrossSection& end, double outwards) {
  const auto at = roadquery::reference_point(road, end.s_m);
  const Vec2 p = Vec2{at.x, at.y} + Vec2{std::cos(at.hdg), std::sin(at.hdg)} * (outwards * end_bulge_m);
  ring.push_back(snap_to_grid(p));
  ring = convex_hull(std::move(ring));
}

MultiPolygon strip_union(const roadquery::Road& road, const std::vector<CrossSection>& strip) {
  std::vector<Polygon> pieces;
  for (std::size_t i = 1; i < strip.size(); ++i) {
    Ring ring = piece_ring(strip[i - 1], strip[i]);
    if (i == 1 && !road.shape.empty()) bulge(ring, road, strip.front(), -1.0);
    if (i + 1 == strip.size() && !road.shape.empty()) bulge(ring, road, strip.back(), 1.0);
    if (ring.size() >= 3 && signed_area_m2(ring) > min_piece_area_m2) pieces.push_back({std::move(ring), {}});
  }
  return pieces.empty() ? MultiPolygon{} : union_of(pieces);
}

bool is_sliver(const Ring& ring) {
  double perimeter_m = 0.0;
  for (std::size_t i = 0; i < ring.size(); ++i) perimeter_m += distance(ring[i], ring[(i + 1) % ring.size()]);
  const double area = std::abs(signed_area_m2(ring));
  return area < min_hole_area_m2 || area < 0.5 * perimeter_m * min_hole_width_m;
}

/// Where p lies on one piece of a road.
struct OnRoad {
  double s_m = 0.0, t_m = 0.0;
  double inside_m = -1e9;
};

OnRoad project(const roadquery::Road& road, const CrossSection& a, const CrossSection& b, Vec2 p) {
  const Vec2 chord = plan(b.reference) - plan(a.reference);
  const double u = std::clamp(dot(p - plan(a.reference), chord) / std::max(dot(chord, chord), 1e-12), 0.0, 1.0);
  double s = a.s_m + u * (b.s_m - a.s_m), along_m = 0.0, across_m = 0.0;
  for (int iteration = 0; iteration < 10; ++iteration) {  // Newton on (p - r(s)) . r'(s) = 0; two or three do
    const auto r = roadquery::reference_point(road, s);
    const Vec2 tangent{std::cos(r.hdg), std::sin(r.hdg)}, d = p - Vec2{r.x, r.y};
    along_m = dot(d, tangent), across_m = cross(tangent, d);
    const double next = std::clamp(s + along_m / std::max(1.0 - r.curvature * across_m, 0.1), a.s_m, b.s_m);
    if (std::abs(next - s) < 1e-9) break;
    s = next;
  }
  const auto edges = roadquery::road_edges(road, s);
  OnRoad on{s, roadquery::t_at(road, s, across_m)};
  on.inside_m = std::min({edges.left_t - on.t_m, on.t_m - edges.right_t, s, road.length - s});
  if (std::abs(along_m) > plan_grid_m) on.inside_m = std::min(on.inside_m, -std::abs(along_m));  // off the piece's ends
  on.t_m = std::clamp(on.t_m, edges.right_t, edges.left_t);
  return on;
}

}  // namespace

RoadLevel::RoadLevel(std::vector<const roadquery::Road*> roads, const Polygon& area, const RoadLevelOptions& options)
    : roads_(std::move(roads)), strips_(roads_.size()) {
  std::vector<MultiPolygon> unions(roads_.size());
  parallel_for(roads_.size(), options.threads, [&](std::size_t i) {
    strips_[i] = cross_sections(*roads_[i], options.strip);
    unions[i] = strip_union(*roads_[i], strips_[i]);
  });
  std::vector<Box2> boxes;
  for (std::size_t i = 0; i < roads_.size(); ++i) {
    for (std::size_t k = 1; k < strips_[i].size(); ++k) {
      pieces_.push_back({static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(k - 1)});
      const CrossSection &a = strips_[i][k - 1], &b = strips_[i][k];
      boxes.push_back(bounds_of({plan(a.left), plan(a.right), plan(b.left), plan(b.right)}).grown(sample_reach_m));
    }
  }
  piece_index_ = CellIndex(boxes, 10.0);

  std::vector<Polygon> all;
  for (const MultiPolygon& part : unions) all.insert(all.end(), part.begin(), part.end());
  MultiPolygon joined = all.empty() ? MultiPolygon{} : union_of(all);
  for (Polygon& polygon : joined) std::erase_if(polygon.holes, is_sliver);
  polygons_ = joined.empty() ? MultiPolygon{} : intersection_of(joined, {area});
  outline_ = Outline(
      polygons_, options.reach_m,
      [&](Vec2 p) {
        const auto on = sample(p);
        return on ? on->z_m : 0.0;
      },
      options.threads);
}

std::optional<SurfaceSample> RoadLevel::sample(Vec2 p) const {
  double sum_weight = 0.0, sum_z = 0.0;
  Vec3 sum_normal{0.0, 0.0, 0.0};
  const auto add = [&](std::uint32_t road, const OnRoad& on, double weight) {
    const auto at = roadquery::surface_point(*roads_[road], on.s_m, on.t_m);
    sum_weight += weight, sum_z += weight * at.z;
    sum_normal = sum_normal + Vec3{at.normal[0], at.normal[1], at.normal[2]} * weight;
  };
  std::uint32_t nearest_road = 0, last_road = 0;
  OnRoad nearest, last;
  const auto flush = [&] {  // neighbouring pieces of a road meet p at the same place: count it once
    if (last.inside_m >= -border_tolerance_m) add(last_road, last, std::max(last.inside_m, 0.0) + border_weight_m);
    last = {};
  };
  for (const std::uint32_t i : piece_index_.at(p)) {
    const auto [road, section] = pieces_[i];
    const OnRoad on = project(*roads_[road], strips_[road][section], strips_[road][section + 1], p);
    if (on.inside_m < -sample_reach_m) continue;
    if (on.inside_m > nearest.inside_m) nearest = on, nearest_road = road;
    if (road != last_road || std::abs(on.s_m - last.s_m) > 1.0) flush();
    if (on.inside_m > last.inside_m) last = on, last_road = road;
  }
  flush();
  if (nearest.inside_m < -sample_reach_m) return std::nullopt;
  if (sum_weight == 0.0) add(nearest_road, nearest, 1.0);
  const double n = std::sqrt(sum_normal.x * sum_normal.x + sum_normal.y * sum_normal.y + sum_normal.z * sum_normal.z);
  return SurfaceSample{sum_z / sum_weight, sum_normal * (1.0 / n), nearest.inside_m};
}

}  // namespace orthodrive::scene
