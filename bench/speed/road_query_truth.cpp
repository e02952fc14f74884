// SPDX-License-Identifier: Apache-2.0
// Does the query name the right road? Points from known (road, s, t) of a map, asked with their height and without or
// with a cursor.
//
//   bench_road_query_truth MAP.xodr [POINTS [SEED]]
//
// Prints one line a count and ends with 1 when a point came back wrong. What counts as right:
//   - with a cursor at (road, s): that road, s and t within 1 mm;
//   - without: the same, or another road of the same junction, or another road that lies there, too: the exact surface
//     at the hit's own (s, t) is within 1 mm in plan of the point and of its level (1.5 m).
// Points within 1 mm of an end or edge of their road are drawn again: rounding may put them outside. So are points
// where the road is folded (1 - curvature x left < 0.05: beyond or at the centre of a bend, (s, t) is not one to one
// there). Where a road lies over itself the other (s, t) counts when the exact surface there is the point. Every
// hundredth height is compared with the blend of the exact surfaces, found without the baked tables; 0.1 mm is allowed.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <random>
#include <string>
#include <unordered_map>

#include "roadquery/query/road_query.hpp"
#include "roadquery/surface/blend.hpp"

namespace {

using namespace roadquery;

constexpr double right_m = 1e-3, height_error_m = 1e-4;

struct Draw {
  std::size_t road = 0;
  double s = 0.0, t = 0.0;
  SurfacePoint at;
};

class Points {
 public:
  Points(const RoadMap& map, unsigned seed) : map_(map), random_(seed) {
    for (const Road& road : map.roads)
      lengths_.push_back((lengths_.empty() ? 0.0 : lengths_.back()) + (road.sections.empty() ? 0.0 : road.length));
  }
  Draw next() {
    for (;;) {
      Draw d;
      const double at = uniform() * lengths_.back();
      d.road = static_cast<std::size_t>(std::upper_bound(lengths_.begin(), lengths_.end(), at) - lengths_.begin());
      if (d.road >= map_.roads.size()) continue;
      const Road& road = map_.roads[d.road];
      d.s = right_m + uniform() * (road.length - 2.0 * right_m);
      const Edges edges = road_edges(road, d.s);
      if (!(road.length > 2.0 * right_m && edges.left_t - edges.right_t > 2.0 * right_m)) continue;
      d.t = edges.right_t + right_m + uniform() * (edges.left_t - edges.right_t - 2.0 * right_m);
      const PlanPoint line = reference_point(road, d.s);
      d.at = surface_point(road, d.s, d.t, line);
      const double left = (d.at.y - line.y) * std::cos(line.hdg) - (d.at.x - line.x) * std::sin(line.hdg);
      if (1.0 - line.curvature * left >= 0.05) return d;
      ++folded;
    }
  }
  std::size_t folded = 0;

 private:
  double uniform() { return static_cast<double>(random_()) / 18446744073709551616.0; }
  const RoadMap& map_;
  std::mt19937_64 random_;
  std::vector<double> lengths_;
};

/// Exact surfaces over a place: Newton's method on the exact line, from samples of it in a coarse grid.
class ExactSurfaces {
 public:
  explicit ExactSurfaces(const RoadMap& map) : map_(map) {
    for (std::uint32_t r = 0; r < map.roads.size(); ++r) {
      const Road& road = map.roads[r];
      if (road.sections.empty()) continue;
      for (double s = 0.0; s <= road.length; s += 1.0) {
        const PlanPoint p = reference_point(road, s);
        const Edges edges = road_edges(road, s);
        reach_m_ = std::max({reach_m_, std::abs(edges.left_t), std::abs(edges.right_t)});
        samples_[key(p.x, p.y)].push_back({r, static_cast<float>(s)});
      }
    }
  }
  struct Surface {
    std::uint32_t road = 0;
    double s = 0.0, inside_m = 0.0, z = 0.0;
  };
  [[nodiscard]] std::vector<Surface> at(double x, double y) const {
    std::vector<Sample> near;
    const int cells = 1 + static_cast<int>((reach_m_ + 1.0) / cell_m);
    for (int i = -cells; i <= cells; ++i) {
      for (int k = -cells; k <= cells; ++k) {
        const auto found = samples_.find(key(x + i * cell_m, y + k * cell_m));
        if (found != samples_.end()) near.insert(near.end(), found->second.begin(), found->second.end());
      }
    }
    std::sort(near.begin(), near.end(),
              [](const Sample& a, const Sample& b) { return a.road != b.road ? a.road < b.road : a.s < b.s; });
    std::vector<Surface> result;
    for (const Sample& sample : near) add(sample, x, y, result);
    return result;
  }

 private:
  static constexpr double cell_m = 8.0;
  struct Sample {
    std::uint32_t road = 0;
    float s = 0.0F;
  };
  static std::int64_t key(double x, double y) {
    return (static_cast<std::int64_t>(std::floor(x / cell_m)) << 32) ^
           (static_cast<std::int64_t>(std::floor(y / cell_m)) & 0xffffffff);
  }
  void add(const Sample& sample, double x, double y, std::vector<Surface>& result) const {
    const Road& road = map_.roads[sample.road];
    const PlanPoint p = reference_point(road, sample.s);
    const double distance = std::hypot(x - p.x, y - p.y);
    if (distance > reach_m_ + 1.0) return;
    const RoadPosition over = position_over(road, x, y, sample.s);
    if (std::abs(over.beyond_m) > 1e-9) return;
    const double s = over.s, t = over.t;
    const Edges edges = road_edges(road, s);
    const double inside = std::min({edges.left_t - t, t - edges.right_t, s, road.length - s});
    if (inside < 0.0) return;
    for (const Surface& other : result)
      if (other.road == sample.road && std::abs(other.s - s) < 0.25) return;
    result.push_back({sample.road, s, inside, surface_height(road, s, t)});
  }

  const RoadMap& map_;
  std::unordered_map<std::int64_t, std::vector<Sample>> samples_;
  double reach_m_ = 0.0;
};

/// The blend of the exact surfaces at the level nearest to z_hint.
double exact_height(const std::vector<ExactSurfaces::Surface>& surfaces, double z_hint) {
  const auto nearest = std::min_element(surfaces.begin(), surfaces.end(), [&](const auto& a, const auto& b) {
    return std::abs(a.z - z_hint) < std::abs(b.z - z_hint);
  });
  if (nearest == surfaces.end()) return std::nan("");
  Blend blend;
  for (const auto& surface : surfaces)
    if (is_same_level(surface.z, nearest->z)) blend.add(surface.inside_m, surface.z);
  return blend.z();
}

struct Counts {
  std::size_t points = 0, same = 0, of_junction = 0, overlapping = 0, itself = 0, wrong = 0, missed = 0;
  std::size_t heights = 0, wrong_heights = 0;
  double worst_height_m = 0.0;
};

bool is_exact(const RoadMap& map, const Hit& hit, const SurfacePoint& at) {
  const SurfacePoint p = surface_point(map.roads[static_cast<std::size_t>(hit.road)], hit.s, hit.t);
  return std::hypot(p.x - at.x, p.y - at.y) < right_m && is_same_level(p.z, at.z);
}

void judge(const RoadMap& map, const Draw& d, const std::optional<Hit>& hit, bool with_cursor, Counts& counts) {
  ++counts.points;
  if (!hit) {
    ++counts.missed;
    if (counts.missed <= 5)
      std::printf("missed: road %d s %.4f t %.4f at %.3f %.3f %.3f\n", map.roads[d.road].id, d.s, d.t, d.at.x, d.at.y,
                  d.at.z);
    return;
  }
  const Road &want = map.roads[d.road], &got = map.roads[static_cast<std::size_t>(hit->road)];
  const bool is_same = hit->road == static_cast<int>(d.road);
  if (is_same && std::abs(hit->s - d.s) < right_m && std::abs(hit->t - d.t) < right_m)
    ++counts.same;
  else if (is_same && is_exact(map, *hit, d.at))
    ++counts.itself;
  else if (!with_cursor && !is_same && is_exact(map, *hit, d.at))
    ++(want.junction >= 0 && want.junction == got.junction ? counts.of_junction : counts.overlapping);
  else if (++counts.wrong <= 5)
    std::printf("wrong: road %d s %.4f t %.4f z %.3f came back as road %d s %.4f t %.4f z %.3f\n", want.id, d.s, d.t,
                d.at.z, got.id, hit->s, hit->t, hit->z);
}

void print(const char* what, const Counts& c) {
  std::printf("%s points %zu same %zu of_junction %zu overlapping %zu itself %zu wrong %zu missed %zu", what, c.points,
              c.same, c.of_junction, c.overlapping, c.itself, c.wrong, c.missed);
  std::printf(" heights %zu wrong_heights %zu worst_height_mm %.6f\n", c.heights, c.wrong_heights,
              1e3 * c.worst_height_m);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) {
    std::fprintf(stderr, "usage: bench_road_query_truth MAP.xodr [POINTS [SEED]]\n");
    return 2;
  }
  const std::size_t count = argc > 2 ? std::strtoull(argv[2], nullptr, 10) : 1'000'000;
  try {
    const RoadQuery query(read_opendrive(argv[1]));
    const RoadMap& map = query.map();
    const ExactSurfaces exact(map);
    Points points(map, argc > 3 ? static_cast<unsigned>(std::strtoul(argv[3], nullptr, 10)) : 1);
    Counts fresh, following;
    for (std::size_t i = 0; i < count; ++i) {
      const Draw d = points.next();
      Cursor none, there{static_cast<int>(d.road), d.s};
      const auto hit = query.find(d.at.x, d.at.y, d.at.z, none);
      judge(map, d, hit, false, fresh);
      const auto followed = query.find(d.at.x, d.at.y, d.at.z, there);
      judge(map, d, followed, true, following);
      if (i % 100 != 0 || !hit || !followed || hit->in_junction) continue;
      const double z = exact_height(exact.at(d.at.x, d.at.y), d.at.z);
      for (Counts* c : {&fresh, &following}) {
        const double error = std::abs((c == &fresh ? *hit : *followed).z - z);
        ++c->heights, c->worst_height_m = std::max(c->worst_height_m, error);
        if (error > height_error_m && ++c->wrong_heights <= 5)
          std::printf("height: road %d s %.4f t %.4f z %.6f, exact blend %.6f\n", map.roads[d.road].id, d.s, d.t,
                      (c == &fresh ? *hit : *followed).z, z);
      }
    }
    print("without_cursor", fresh);
    print("with_cursor", following);
    std::printf("folded_not_drawn %zu\n", points.folded);
    const bool right = fresh.wrong + fresh.missed + following.wrong + following.missed + fresh.wrong_heights +
                           following.wrong_heights ==
                       0;
    return right ? 0 : 1;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 2;
  }
}
