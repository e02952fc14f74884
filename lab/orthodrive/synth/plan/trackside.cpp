// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/synth/plan/trackside.hpp"

#include <algorithm>
#include <cmath>

namespace orthodrive::synth {
namespace {
constexpr double step_m = 2.0;           // hairpins have radii of 12 m
constexpr double bend_radius_m = 220.0;  // bends wider than that are driven flat out: no run-off area

Vec2 left_of(const AlignmentPoint& q) { return {-std::sin(q.heading_rad), std::cos(q.heading_rad)}; }

struct Bend {
  double s_begin_m = 0.0, s_end_m = 0.0;
  double side = 1.0;  ///< of the outer side: -1 right
};

/// Stretches of one turn, tighter than bend_radius_m, at least 15 m long; gaps of 25 m are closed.
std::vector<Bend> find_bends(const Alignment& a) {
  std::vector<Bend> bends;
  for (double s = 0.0; s < a.length_m; s += step_m) {
    const double k = design_curvature_1pm(a, s);
    if (std::abs(k) < 1.0 / bend_radius_m) continue;
    const double side = k > 0.0 ? -1.0 : 1.0;
    if (!bends.empty() && bends.back().side == side && s - bends.back().s_end_m < 25.0)
      bends.back().s_end_m = s;
    else
      bends.push_back({s, s, side});
  }
  std::erase_if(bends, [](const Bend& b) { return b.s_end_m - b.s_begin_m < 15.0; });
  return bends;
}

/// Strip on the outer side between two distances from the edge of the road, plus shares that swell and fade along it;
/// ends before the road turns tightly the other way.
struct RunOff {
  double near_m = 0.0, near_swell_m = 0.0, width_m = 0.0;
};
Ring run_off(const PlannedRoad& road, const Bend& bend, const RunOff& strip) {
  const Alignment& a = road.alignment;
  double begin = bend.s_begin_m - 20.0, end = bend.s_end_m + 60.0;
  const double limit = a.closed ? 1e9 : a.length_m;
  begin = a.closed ? begin : std::max(0.0, begin), end = std::min(end, limit);
  for (double s = bend.s_end_m; s < end; s += step_m)
    if (design_curvature_1pm(a, s) * -bend.side < -1.0 / 120.0) end = s;
  for (double s = bend.s_begin_m; s > begin; s -= step_m)
    if (design_curvature_1pm(a, s) * -bend.side < -1.0 / 120.0) begin = s;
  Ring inner, outer;
  const int count = std::max(4, static_cast<int>((end - begin) / step_m));
  for (int i = 0; i <= count; ++i) {
    const double s = begin + (end - begin) * i / count, swell = std::sin(3.14159265358979 * i / count);
    const AlignmentPoint q = evaluate(a, s);
    const double edge_m =
        0.5 * road.width_at(std::fmod(s + a.length_m, a.length_m)) + strip.near_m + strip.near_swell_m * swell;
    inner.push_back(q.p + left_of(q) * (bend.side * edge_m));
    outer.push_back(q.p + left_of(q) * (bend.side * (edge_m + strip.width_m * swell)));
  }
  inner.insert(inner.end(), outer.rbegin(), outer.rend());
  return inner;
}
}  // namespace

Ring strip_along(const Alignment& a, double begin, double end, double near_m, double far_m) {
  Ring ring, back;
  const int count = std::max(1, static_cast<int>(std::ceil((end - begin) / step_m)));
  for (int i = 0; i <= count; ++i) {
    const AlignmentPoint q = evaluate(a, begin + (end - begin) * i / count);
    ring.push_back(q.p + left_of(q) * near_m);
    back.push_back(q.p + left_of(q) * far_m);
  }
  ring.insert(ring.end(), back.rbegin(), back.rend());
  return ring;
}

void add_verges(SitePlan& plan, std::size_t road_index, double width_m) {
  const PlannedRoad& road = plan.roads[road_index];
  const Alignment& a = road.alignment;
  const double reach_m = 0.5 * road.width_at(0.0) + width_m;
  const Box2 site{0.0, 0.0, plan.size_m, plan.size_m};
  // In short pieces: a strip round a tight bend would fold over itself.
  for (double s = 0.0; s < a.length_m; s += 16.0) {
    Ring piece = convex_hull(strip_along(a, s - 1.0, std::min(s + 17.0, a.length_m + 1.0), -reach_m, reach_m));
    if (bounds_of(piece).overlaps(site)) plan.areas.push_back({{std::move(piece), {}}, Cover::meadow, false});
  }
}

void add_run_off(SitePlan& plan, std::size_t road_index, Random& random) {
  const PlannedRoad& road = plan.roads[road_index];
  const Alignment& a = road.alignment;
  for (const Bend& bend : find_bends(a)) {
    const double width_m = random.uniform(10.0, 22.0);
    const bool apron = random.uniform() < 0.4;
    if (!apron) {
      plan.areas.push_back({{run_off(road, bend, {4.0, 0.0, width_m}), {}}, Cover::gravel_trap, true});
      continue;
    }
    // The apron begins under the kerb; gravel follows where it ends.
    plan.areas.push_back({{run_off(road, bend, {-1.0, 0.0, 0.55 * width_m + 1.0}), {}}, Cover::apron, false});
    plan.areas.push_back({{run_off(road, bend, {-1.0, 0.55 * width_m + 1.0, width_m}), {}}, Cover::gravel_trap, true});
  }
}

void add_barriers(SitePlan& plan, std::size_t road_index) {
  constexpr double near_m = 27.0, thick_m = 2.0, piece_m = 8.0, free_m = 4.0;  // behind the widest run-off area
  const PlannedRoad& road = plan.roads[road_index];
  const Alignment& a = road.alignment;
  std::vector<std::pair<Polyline, double>> lines;
  lines.reserve(plan.roads.size());
  for (const PlannedRoad& r : plan.roads) lines.emplace_back(sample(r.alignment, 8.0), 0.5 * r.width_m + free_m);
  for (const Bend& bend : find_bends(a))
    for (double s = bend.s_begin_m - 10.0; s < bend.s_end_m + 40.0; s += piece_m) {
      const double from_m = 0.5 * road.width_at(std::fmod(s + a.length_m, a.length_m)) + near_m;
      Ring piece =
          convex_hull(strip_along(a, s - 0.5, s + piece_m + 0.5, bend.side * from_m, bend.side * (from_m + thick_m)));
      const bool free = std::all_of(piece.begin(), piece.end(), [&](Vec2 p) {
        return std::all_of(lines.begin(), lines.end(),
                           [&](const auto& line) { return project_onto(line.first, p).distance_m > line.second; });
      });
      if (free) plan.areas.push_back({{std::move(piece), {}}, Cover::barrier, false});
    }
}

void add_stands(SitePlan& plan, std::size_t road_index, int count, Random& random) {
  const PlannedRoad& road = plan.roads[road_index];
  std::vector<Polyline> lines;
  lines.reserve(plan.roads.size());
  for (const PlannedRoad& r : plan.roads) lines.push_back(sample(r.alignment, 8.0));
  for (int attempt = 0, built = 0; attempt < 60 && built < count; ++attempt) {
    const AlignmentPoint q = evaluate(road.alignment, random.uniform(0.0, road.alignment.length_m));
    const double side = random.below(2) ? 1.0 : -1.0, half_length_m = random.uniform(18.0, 40.0);
    const double away_m = 0.5 * road.width_m + random.uniform(24.0, 30.0);
    if (std::abs(q.curvature_1pm) > 1.0 / 400.0) continue;
    const House stand{q.p + left_of(q) * (side * away_m),
                      q.heading_rad,
                      half_length_m,
                      6.0,
                      9.0,
                      0.0,
                      RoofShape::flat,
                      {0.74f, 0.75f, 0.77f},
                      0,
                      Use::stand};
    // Places all over it: between corners 80 m apart there is room for a road.
    std::vector<Vec2> places;
    for (double along_m = -half_length_m - 2.0; along_m <= half_length_m + 2.0; along_m += 2.0)
      for (const double across_m : {-8.0, 0.0, 8.0})
        places.push_back(stand.center + Vec2{std::cos(q.heading_rad), std::sin(q.heading_rad)} * along_m +
                         left_of(q) * across_m);
    const bool in_site = std::all_of(places.begin(), places.end(), [&](Vec2 p) {
      return p.x > 5.0 && p.y > 5.0 && p.x < plan.size_m - 5.0 && p.y < plan.size_m - 5.0;
    });
    const bool free = std::all_of(places.begin(), places.end(), [&](Vec2 p) {
      return std::none_of(lines.begin(), lines.end(),
                          [&](const Polyline& line) { return project_onto(line, p).distance_m < 18.0; }) &&
             std::none_of(plan.areas.begin(), plan.areas.end(),
                          [&](const Area& area) { return area.cover != Cover::meadow && contains(area.polygon, p); }) &&
             std::none_of(plan.parkings.begin(), plan.parkings.end(),
                          [&](const Polygon& lot) { return contains(lot, p); }) &&
             std::none_of(plan.buildings.begin(), plan.buildings.end(),
                          [&](const House& h) { return distance(h.center, p) < h.half_length_m + 12.0; });
    });
    if (!in_site || !free) continue;
    plan.buildings.push_back(stand);
    ++built;
  }
}

}  // namespace orthodrive::synth
