// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/synth/ground/terrain.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "orthodrive/core/noise.hpp"
#include "orthodrive/core/parallel.hpp"
#include "orthodrive/core/random.hpp"
#include "orthodrive/math/normal_matrix.hpp"
#include "orthodrive/model/roads/highway_class.hpp"

namespace orthodrive::synth {
namespace {
constexpr double knot_spacing_m = 4.0;
constexpr std::size_t most_iterated_unknowns = 20000;  // beyond, conjugate gradients take too many steps

Hills make_hills(double size_m, double relief, Random& random) {
  Hills hills;
  hills.base_m = random.uniform(280.0, 620.0);
  for (int i = 0; i < 18; ++i) {
    const double wavelength_m = 230.0 * std::pow(1000.0 / 230.0, random.uniform()),
                 angle = random.uniform(0.0, 2.0 * std::numbers::pi);
    const double k = 2.0 * std::numbers::pi / wavelength_m;
    hills.waves.push_back({k * std::cos(angle), k * std::sin(angle), random.uniform(0.0, 2.0 * std::numbers::pi),
                           std::pow(wavelength_m, 1.3) * random.uniform(0.5, 1.0)});
  }
  double low = 1e9, high = -1e9;
  for (int i = 0; i <= 20; ++i)
    for (int j = 0; j <= 20; ++j) {
      const double z = hills.height_m({size_m * i / 20.0, size_m * j / 20.0});
      low = std::min(low, z), high = std::max(high, z);
    }
  const double relief_m = random.uniform(28.0, 60.0) * std::min(1.0, size_m / 1000.0) * relief;
  for (Hills::Wave& wave : hills.waves) wave.amplitude_m *= relief_m / (high - low);
  return hills;
}

/// One row of a linear least squares problem: up to three unknowns.
struct Row {
  std::array<std::size_t, 3> index{};
  std::array<double, 3> factor{};
  double value = 0.0;
};

/// Conjugate gradients on the normal equations (CGLS; Bjorck, Numerical Methods for Least Squares Problems, 7.4).
std::vector<double> solve_least_squares(const std::vector<Row>& rows, std::vector<double> x) {
  const auto times = [&](const std::vector<double>& v) {
    std::vector<double> y(rows.size());
    for (std::size_t i = 0; i < rows.size(); ++i)
      for (std::size_t j = 0; j < 3; ++j) y[i] += rows[i].factor[j] * v[rows[i].index[j]];
    return y;
  };
  const auto transposed_times = [&](const std::vector<double>& y) {
    std::vector<double> v(x.size());
    for (std::size_t i = 0; i < rows.size(); ++i)
      for (std::size_t j = 0; j < 3; ++j) v[rows[i].index[j]] += rows[i].factor[j] * y[i];
    return v;
  };
  const auto square = [](const std::vector<double>& v) {
    double sum = 0.0;
    for (const double value : v) sum += value * value;
    return sum;
  };
  std::vector<double> residual = times(x);
  for (std::size_t i = 0; i < rows.size(); ++i) residual[i] = rows[i].value - residual[i];
  std::vector<double> gradient = transposed_times(residual), direction = gradient;
  double norm = square(gradient);
  const double goal = 1e-18 * norm;
  for (int iteration = 0; iteration < 5000 && norm > goal; ++iteration) {
    const std::vector<double> change = times(direction);
    const double step = norm / square(change);
    for (std::size_t i = 0; i < x.size(); ++i) x[i] += step * direction[i];
    for (std::size_t i = 0; i < rows.size(); ++i) residual[i] -= step * change[i];
    gradient = transposed_times(residual);
    const double next = square(gradient);
    for (std::size_t i = 0; i < x.size(); ++i) direction[i] = gradient[i] + direction[i] * (next / norm);
    norm = next;
  }
  return x;
}

/// The same by the sparse Cholesky factor, which is about as sparse as the roads are chains. Unknowns without a row, of
/// knots that share another's, stay as they are.
std::vector<double> solve_least_squares_directly(const std::vector<Row>& rows, std::vector<double> x) {
  constexpr int unused = -1;
  std::vector<int> column(x.size(), unused);
  for (const Row& row : rows)
    for (std::size_t j = 0; j < 3; ++j)
      if (row.factor[j] != 0.0) column[row.index[j]] = 0;
  SparseJacobian jacobian{0, {0}, {}, {}};
  for (int& c : column)
    if (c != unused) c = jacobian.columns++;
  std::vector<double> right;
  for (const Row& row : rows) {
    for (std::size_t j = 0; j < 3; ++j)
      if (row.factor[j] != 0.0)
        jacobian.column.push_back(column[row.index[j]]), jacobian.value.push_back(row.factor[j]);
    jacobian.row_start.push_back(static_cast<int>(jacobian.column.size()));
    right.push_back(row.value);
  }
  const std::vector<double> solution = solve_normal(jacobian, right);
  for (std::size_t i = 0; i < x.size(); ++i)
    if (column[i] != unused) x[i] = solution[static_cast<std::size_t>(column[i])];
  return x;
}

/// Knots of all roads; those of one junction share an unknown.
struct KnotSystem {
  std::vector<std::vector<double>> s_m;           // by road
  std::vector<std::vector<std::size_t>> unknown;  // by road
  std::size_t unknowns = 0;
};

KnotSystem make_knots(const SitePlan& plan) {
  KnotSystem knots;
  std::vector<std::vector<double>> breaks(plan.roads.size());
  for (std::size_t r = 0; r < plan.roads.size(); ++r) breaks[r] = {0.0, plan.roads[r].alignment.length_m};
  for (const PlannedJunction& junction : plan.junctions)
    for (const PlannedJunction::Arm& arm : junction.arms) breaks[arm.road].push_back(arm.s_m);
  for (const PlannedBridge& bridge : plan.bridges) {
    for (const PlannedBridge::Below& below : bridge.under) {
      breaks[bridge.over].push_back(below.s_over_m);
      breaks[below.road].push_back(below.s_m);
    }
  }
  for (std::size_t r = 0; r < plan.roads.size(); ++r) {
    std::sort(breaks[r].begin(), breaks[r].end());
    std::vector<double> s{0.0};
    for (std::size_t i = 1; i < breaks[r].size(); ++i) {
      const double from = breaks[r][i - 1], to = breaks[r][i];
      if (to - from < 1e-6) continue;
      const int count = std::max(1, static_cast<int>(std::lround((to - from) / knot_spacing_m)));
      for (int k = 1; k <= count; ++k) s.push_back(k == count ? to : from + (to - from) * k / count);
    }
    std::vector<std::size_t> unknown(s.size());
    for (std::size_t& u : unknown) u = knots.unknowns++;
    if (plan.roads[r].alignment.closed) unknown.back() = unknown.front();
    knots.s_m.push_back(std::move(s));
    knots.unknown.push_back(std::move(unknown));
  }
  const auto knot_at = [&](std::size_t road, double s) -> std::size_t& {
    const auto& all = knots.s_m[road];
    const auto it =
        std::min_element(all.begin(), all.end(), [&](double a, double b) { return std::abs(a - s) < std::abs(b - s); });
    return knots.unknown[road][static_cast<std::size_t>(it - all.begin())];
  };
  for (const PlannedJunction& junction : plan.junctions) {
    const std::size_t shared = knot_at(junction.arms[0].road, junction.arms[0].s_m);
    for (const PlannedJunction::Arm& arm : junction.arms) knot_at(arm.road, arm.s_m) = shared;
  }
  return knots;
}

/// How far a road irons out the terrain: a wavelength of 2 pi times this is halved.
double stiffness_m(const SitePlan& plan, std::size_t road) {
  const bool smooth = surface_priority(plan, road) >= 10 || is_raceway(plan.roads[road].highway);
  return (plan.roads[road].highway == "motorway" ? 80.0
          : smooth                               ? 50.0
                                                 : 32.0) *
         std::clamp(plan.size_m / 600.0, 0.8, 1.0);
}

/// A smoothing spline through the terrain: sum ds (z - g)^2 + l^4 sum ds z''^2. Sets the unknowns to the ground.
void add_terrain_rows(const SitePlan& plan, const Hills& hills, const KnotSystem& knots, std::vector<Row>& rows,
                      std::vector<double>& start) {
  for (std::size_t r = 0; r < plan.roads.size(); ++r) {
    const auto& s = knots.s_m[r];
    const auto& u = knots.unknown[r];
    const Alignment& alignment = plan.roads[r].alignment;
    const double l = stiffness_m(plan, r);
    const std::size_t n = s.size();
    for (std::size_t i = 0; i + (alignment.closed ? 1 : 0) < n; ++i) {
      const double h0 = i > 0 ? s[i] - s[i - 1] : s[n - 1] - s[n - 2], h1 = i + 1 < n ? s[i + 1] - s[i] : 0.0;
      const bool inner = i > 0 && i + 1 < n;
      const double weight = std::sqrt(0.5 * (inner || alignment.closed ? h0 + h1 : knot_spacing_m));
      const double ground = hills.height_m(evaluate(alignment, s[i]).p);
      start[u[i]] = ground;
      rows.push_back({{u[i], u[i], u[i]}, {weight, 0.0, 0.0}, weight * ground});
      if (!inner && !alignment.closed) continue;
      const std::size_t before = i > 0 ? u[i - 1] : u[n - 2];
      const double bend = weight * l * l * 2.0 / (h0 + h1);
      rows.push_back({{before, u[i], u[i + 1]}, {bend / h0, -bend * (1.0 / h0 + 1.0 / h1), bend / h1}, 0.0});
    }
  }
}

/// Bridges are lifted over what is below them.
void add_bridge_rows(const SitePlan& plan, const KnotSystem& knots, std::vector<Row>& rows) {
  const auto unknown_at = [&](std::size_t road, double s) {
    const auto& all = knots.s_m[road];
    return knots
        .unknown[road][static_cast<std::size_t>(std::lower_bound(all.begin(), all.end(), s - 1e-6) - all.begin())];
  };
  constexpr double stiff = 300.0;  // against weights near 2 of the terrain: holds the rise to millimetres
  for (const PlannedBridge& bridge : plan.bridges)
    for (const PlannedBridge::Below& below : bridge.under) {
      const std::size_t over = unknown_at(bridge.over, below.s_over_m), under = unknown_at(below.road, below.s_m);
      rows.push_back({{over, under, under}, {stiff, -stiff, 0.0}, stiff * bridge_rise_m});
    }
}

/// Tied stretches take their height from the road beside them.
void add_tie_rows(const SitePlan& plan, const KnotSystem& knots, std::vector<Row>& rows) {
  for (const PlannedTie& tie : plan.ties) {
    const PlannedRoad &road = plan.roads[tie.road], &main = plan.roads[tie.main];
    const double weight = tie.on_surface ? 100.0 : 5.0;
    const Polyline main_line = sample(main.alignment, search_step_m);
    for (std::size_t i = 0; i < knots.s_m[tie.road].size(); ++i) {
      const double s = knots.s_m[tie.road][i];
      // One knot beyond both ends: the spline between the last tied knot and a free one may not leave the surface.
      if (s < tie.s_begin_m - knot_spacing_m || s > tie.s_end_m + knot_spacing_m) continue;
      const Vec2 p = evaluate(road.alignment, s).p;
      const double s_main = std::clamp(nearest_s(main.alignment, main_line, p), 0.0, main.alignment.length_m);
      const auto& all = knots.s_m[tie.main];
      const std::size_t k = std::min(
          static_cast<std::size_t>(std::upper_bound(all.begin(), all.end(), s_main) - all.begin()), all.size() - 1);
      const double part = (s_main - all[k - 1]) / (all[k] - all[k - 1]);
      const AlignmentPoint q = evaluate(main.alignment, s_main);
      const double offset_m = cross({std::cos(q.heading_rad), std::sin(q.heading_rad)}, p - q.p);
      const double rise_m =
          tie.on_surface ? offset_m * std::tan(banking_rad(main, design_curvature_1pm(main.alignment, s_main))) : 0.0;
      rows.push_back({{knots.unknown[tie.road][i], knots.unknown[tie.main][k - 1], knots.unknown[tie.main][k]},
                      {weight, -weight * (1.0 - part), -weight * part},
                      weight * rise_m});
    }
  }
}

/// The heights of all roads at once: they share those of their junctions.
std::vector<Profile> solve_profiles(const SitePlan& plan, const Hills& hills) {
  const KnotSystem knots = make_knots(plan);
  std::vector<Row> rows;
  std::vector<double> start(knots.unknowns, 0.0);
  add_terrain_rows(plan, hills, knots, rows, start);
  add_bridge_rows(plan, knots, rows);
  add_tie_rows(plan, knots, rows);
  const std::vector<double> z = knots.unknowns > most_iterated_unknowns
                                    ? solve_least_squares_directly(rows, std::move(start))
                                    : solve_least_squares(rows, std::move(start));
  std::vector<Profile> profiles;
  for (std::size_t r = 0; r < plan.roads.size(); ++r) {
    std::vector<double> heights;
    heights.reserve(knots.unknown[r].size());
    for (const std::size_t u : knots.unknown[r]) heights.push_back(z[u]);
    const auto through = plan.roads[r].alignment.closed ? periodic_spline : natural_spline;
    profiles.push_back(Profile{through(knots.s_m[r], std::move(heights))});
  }
  return profiles;
}

/// Of all roads but one.
double steepest(const std::vector<Profile>& profiles, std::optional<std::size_t> but = {}) {
  double steepest = 0.0;
  for (std::size_t r = 0; r < profiles.size(); ++r)
    for (double s = 0.0; r != but && s <= profiles[r].spline.knots.back(); s += 2.0)
      steepest = std::max(steepest, std::abs(profiles[r].gradient(s)));
  return steepest;
}

/// The surveyed ground as it is within 250 m of the survey. From 900 m on its slope goes over into level land, at most
/// 110 m higher or lower, with the hills.
HeightField with_hills_around(HeightField field, const std::vector<Vec3>& surveyed, const Hills& hills) {
  constexpr double none_m = 250.0, whole_m = 900.0, rise_m = 110.0;
  double mean_m = 0.0;
  for (const Vec3& q : surveyed) mean_m += q.z / static_cast<double>(surveyed.size());
  for (int row = 0; row < field.frame.height; ++row)
    for (int col = 0; col < field.frame.width; ++col) {
      const Vec2 p = field.frame.center_of(col, row);
      double nearest_m = whole_m;
      for (const Vec3& q : surveyed) nearest_m = std::min(nearest_m, distance(p, {q.x, q.y}));
      const double share =
          smoothstep(static_cast<float>(none_m), static_cast<float>(whole_m), static_cast<float>(nearest_m));
      double& z = field.height_m[static_cast<std::size_t>(row) * static_cast<std::size_t>(field.frame.width) +
                                 static_cast<std::size_t>(col)];
      const double far = mean_m + rise_m * std::tanh((z - mean_m) / rise_m) + hills.height_m(p) - hills.base_m;
      z += share * (far - z);
    }
  return field;
}

}  // namespace

double Hills::height_m(Vec2 p) const {
  if (surveyed) return surveyed->at(p);
  double z = base_m;
  for (const Wave& w : waves) z += w.amplitude_m * std::cos(w.kx_1pm * p.x + w.ky_1pm * p.y + w.phase_rad);
  return z;
}

Terrain make_terrain(const SitePlan& plan, std::uint64_t seed) {
  Random random(derive_seed(seed, 2));
  Terrain terrain{make_hills(plan.size_m, plan.relief, random), {}};
  if (!plan.heights.empty()) {
    constexpr double margin_m = 100.0;  // the terrain models reach beyond the site
    const HeightField field = fit_heights(plan.heights, Box2{0.0, 0.0, plan.size_m, plan.size_m}.grown(margin_m));
    const bool has_country = plan.surroundings == Surroundings::region;
    for (int attempt = 0; attempt < (has_country ? 12 : 1); ++attempt) {
      Hills around{terrain.hills.base_m, terrain.hills.waves, {}};
      terrain.hills.surveyed = has_country ? with_hills_around(field, plan.heights, around) : field;
      terrain.profiles = solve_profiles(plan, terrain.hills);
      if (steepest(terrain.profiles, plan.circuit) <= max_gradient) break;
      for (Hills::Wave& wave : terrain.hills.waves) wave.amplitude_m *= 0.85;
    }
    return terrain;
  }
  for (int attempt = 0; attempt < 12; ++attempt) {
    terrain.profiles = solve_profiles(plan, terrain.hills);
    if (steepest(terrain.profiles) <= max_gradient) break;
    for (Hills::Wave& wave : terrain.hills.waves) wave.amplitude_m *= 0.85;
  }
  return terrain;
}

double banking_rad(const PlannedRoad& road, double curvature_1pm) {
  // The outer side is raised, by up to 5 % on roads built for speed. tanh keeps it smooth where it saturates.
  const double most = road.highway == "service" || road.roundabout ? 0.0 : road.highway == "residential" ? 0.02 : 0.05;
  return -std::atan(most * std::tanh(curvature_1pm * 60.0));
}

std::vector<RoadSample> sample_roads(const SitePlan& plan, const Terrain& terrain, double step_m) {
  return sample_roads(plan, terrain, whole_roads(plan), step_m);
}

std::vector<RoadSample> sample_roads(const SitePlan& plan, const Terrain& terrain,
                                     const std::vector<Stretch>& stretches, double step_m) {
  std::vector<RoadSample> samples;
  for (const Stretch& stretch : stretches) {
    const std::size_t r = stretch.road;
    const PlannedRoad& road = plan.roads[r];
    const int count = std::max(1, static_cast<int>(std::ceil(road.alignment.length_m / step_m)));
    const double per_m = count / road.alignment.length_m;
    constexpr int more = 2;  // the look of a segment depends on its neighbours
    const int first = std::max(0, static_cast<int>(std::floor(stretch.s_begin_m * per_m)) - more),
              final = std::min(count, static_cast<int>(std::ceil(stretch.s_end_m * per_m)) + more);
    for (int i = first; i <= final; ++i) {
      const double s = road.alignment.length_m * i / count;
      const AlignmentPoint q = evaluate(road.alignment, s);
      samples.push_back({q.p, static_cast<float>(s), static_cast<float>(terrain.profiles[r].z(s)),
                         static_cast<float>(banking_rad(road, design_curvature_1pm(road.alignment, s))),
                         static_cast<float>(0.5 * road.width_at(s)), static_cast<std::uint16_t>(r),
                         on_bridge(plan, r, s), i == final});
    }
  }
  return samples;
}

namespace {
/// A range of rows; bands are made independently of each other.
struct TerrainBand {
  int first = 0, end = 0;
  [[nodiscard]] std::size_t cell(const GridFrame& frame, int col, int row) const {
    return static_cast<std::size_t>(row - first) * static_cast<std::size_t>(frame.width) +
           static_cast<std::size_t>(col);
  }
};

/// The nearest place of one road's reference line, as seen from a pixel.
struct Near {
  double distance_m = max_clearance_m, offset_m = 0.0, z_m = 0.0, banking = 0.0, half_width_m = 0.0;
};

/// A range of all samples: those of one road follow each other.
struct SamplesOfRoad {
  const std::vector<RoadSample>& of_all;
  std::size_t road = 0, begin = 0, end = 0;
};

/// The most important road last: its bed is exact.
std::vector<SamplesOfRoad> by_priority(const SitePlan& plan, const std::vector<RoadSample>& samples) {
  std::vector<SamplesOfRoad> roads;
  for (std::size_t i = 0; i < samples.size(); ++i)
    if (roads.empty() || roads.back().road != samples[i].road)
      roads.push_back({samples, samples[i].road, i, i + 1});
    else
      roads.back().end = i + 1;
  std::vector<std::size_t> order(roads.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return surface_priority(plan, roads[a].road) < surface_priority(plan, roads[b].road);
  });
  std::vector<SamplesOfRoad> sorted;
  sorted.reserve(order.size());
  for (const std::size_t i : order) sorted.push_back(roads[i]);
  return sorted;
}

/// The hills on a grid. cos(a + b) by the cosines and sines of its columns and rows: ten times as fast.
class HillGrid {
 public:
  HillGrid(const Hills& hills, const GridFrame& frame) : hills_(hills), frame_(frame) {
    for (const Hills::Wave& w : hills.waves)
      for (int col = 0; col < frame.width; ++col) {
        const double a = w.kx_1pm * frame.center_of(col, 0).x;
        cosine_.push_back(std::cos(a)), sine_.push_back(std::sin(a));
      }
  }
  void fill(int row, float* heights) const {
    const auto width = static_cast<std::size_t>(frame_.width);
    if (hills_.surveyed) {
      for (int col = 0; col < frame_.width; ++col)
        heights[col] = static_cast<float>(hills_.height_m(frame_.center_of(col, row)));
      return;
    }
    std::vector<double> z(width, hills_.base_m);
    const double y = frame_.center_of(0, row).y;
    for (std::size_t w = 0; w < hills_.waves.size(); ++w) {
      const Hills::Wave& wave = hills_.waves[w];
      const double b = wave.ky_1pm * y + wave.phase_rad;
      const double c = wave.amplitude_m * std::cos(b), s = wave.amplitude_m * std::sin(b);
      for (std::size_t col = 0; col < width; ++col) z[col] += c * cosine_[w * width + col] - s * sine_[w * width + col];
    }
    for (std::size_t col = 0; col < width; ++col) heights[col] = static_cast<float>(z[col]);
  }

 private:
  const Hills& hills_;
  const GridFrame& frame_;
  std::vector<double> cosine_, sine_;  // wave by wave
};

/// Bridges do not count: they leave the ground as it is. False where the road does not come near the band.
bool find_nearest(const SamplesOfRoad& samples, const GridFrame& frame, const TerrainBand& band,
                  std::vector<Near>& near) {
  bool touched = false;
  for (std::size_t i = samples.begin; i + 1 < samples.end; ++i) {
    const RoadSample &a = samples.of_all[i], &b = samples.of_all[i + 1];
    if (a.last || a.bridge || b.bridge) continue;
    const Vec2 pa = frame.pixel_from_world(a.p), pb = frame.pixel_from_world(b.p);
    const double reach = max_clearance_m / frame.gsd_m;
    const int row0 = std::max(band.first, static_cast<int>(std::min(pa.y, pb.y) - reach));
    const int row1 = std::min(band.end, static_cast<int>(std::max(pa.y, pb.y) + reach) + 1);
    const int col0 = std::max(0, static_cast<int>(std::min(pa.x, pb.x) - reach));
    const int col1 = std::min(frame.width, static_cast<int>(std::max(pa.x, pb.x) + reach) + 1);
    if (row0 >= row1 || col0 >= col1) continue;
    if (!touched) std::fill(near.begin(), near.end(), Near{}), touched = true;
    const Vec2 d = b.p - a.p;
    const double n2 = dot(d, d), n = std::sqrt(n2);
    for (int row = row0; row < row1; ++row)
      for (int col = col0; col < col1; ++col) {
        const Vec2 p = frame.center_of(col, row);
        const double t = std::clamp(dot(p - a.p, d) / n2, 0.0, 1.0);
        const Vec2 foot = a.p + d * t, apart = p - foot;
        Near& best = near[band.cell(frame, col, row)];
        // Most segments of a road are farther than the best so far: its square says so before the root, up to rounding.
        if (dot(apart, apart) > best.distance_m * best.distance_m * (1.0 + 1e-9)) continue;
        const double distance_m = distance(p, foot);
        if (distance_m < best.distance_m)
          best = {distance_m, cross(d, p - a.p) / n, a.z_m + t * (b.z_m - a.z_m),
                  a.banking + t * (b.banking - a.banking), a.half_width_m + t * (b.half_width_m - a.half_width_m)};
      }
  }
  return touched;
}

/// Cuts and fills the bed of one road into the ground: a metre of shoulder, then an embankment of about 1 in 2.5.
/// `bed_of_others`: 1 on the bed of a road made before, 0 from 3 m beside it.
void lay_bed(const std::vector<Near>& near, const TerrainBand& band, std::vector<float>& bed_of_others,
             BareEarth& earth) {
  std::size_t cell = 0;
  for (int row = band.first; row < band.end; ++row)
    for (int col = 0; col < earth.height_m.width; ++col, ++cell) {
      const Near& q = near[cell];
      if (q.distance_m >= max_clearance_m) continue;
      float& z = earth.height_m.at(col, row);
      float& clearance = earth.clearance_m.at(col, row);
      clearance = std::min(clearance, static_cast<float>(q.distance_m - q.half_width_m));
      const double shoulder_m = q.half_width_m + 1.0, slope_m = 3.0 + 2.5 * std::abs(q.z_m - z);
      const double lateral = std::clamp(q.offset_m, -shoulder_m, shoulder_m);
      const double bed = q.z_m + std::tan(q.banking) * lateral;
      float weight = 1.0f - smoothstep(0.0f, 1.0f, static_cast<float>((q.distance_m - shoulder_m) / slope_m));
      // An embankment does not run across the bed of a road far above or below: that is where abutments stand.
      if (q.distance_m > shoulder_m)
        weight *= 1.0f - bed_of_others[cell] * smoothstep(0.5f, 2.0f, static_cast<float>(std::abs(q.z_m - z)));
      z += weight * static_cast<float>(bed - z);
      bed_of_others[cell] =
          std::max(bed_of_others[cell], 1.0f - smoothstep(0.0f, 3.0f, static_cast<float>(q.distance_m - shoulder_m)));
    }
}
}  // namespace

BareEarth make_bare_earth(const SitePlan& plan, const Terrain& terrain, const GridFrame& frame, int threads) {
  return make_bare_earth(plan, terrain, whole_roads(plan), frame, threads);
}

BareEarth make_bare_earth(const SitePlan& plan, const Terrain& terrain, const std::vector<Stretch>& stretches,
                          const GridFrame& frame, int threads) {
  BareEarth earth{Raster<float>(frame.width, frame.height),
                  Raster<float>(frame.width, frame.height, 1, static_cast<float>(max_clearance_m))};
  const std::vector<RoadSample> samples = sample_roads(plan, terrain, stretches, 2.0);
  const std::vector<SamplesOfRoad> roads = by_priority(plan, samples);
  const HillGrid hills(terrain.hills, frame);

  constexpr int band_rows = 32;
  const auto bands = static_cast<std::size_t>((frame.height + band_rows - 1) / band_rows);
  parallel_for(bands, threads, [&](std::size_t number) {
    const int first = static_cast<int>(number) * band_rows;
    const TerrainBand band{first, std::min(frame.height, first + band_rows)};
    for (int row = band.first; row < band.end; ++row) hills.fill(row, &earth.height_m.at(0, row));
    std::vector<Near> near(band.cell(frame, 0, band.end));
    std::vector<float> bed_of_others(near.size(), 0.0f);
    for (const SamplesOfRoad& road : roads)
      if (find_nearest(road, frame, band, near)) lay_bed(near, band, bed_of_others, earth);
  });
  return earth;
}

}  // namespace orthodrive::synth
