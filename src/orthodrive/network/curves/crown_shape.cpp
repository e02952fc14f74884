// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/network/curves/crown_shape.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "orthodrive/network/curves/fit_profile.hpp"
#include "roadquery/surface/road_surface.hpp"

namespace orthodrive::network {
namespace {

using roadquery::Cubic;

constexpr double crown_reach_m = 30.0;  // to the right; wider than any road. The left half has no end
constexpr double fall_unit = 1e-5;
constexpr double min_knot_distance_m = 0.01, place_unit_m = 1e-2;
constexpr double crown_share = 0.4, banking_share = 0.35, elevation_share = 0.25;  // of the tolerance of heights

/// Fall and its slope at a place where an entry may stand.
struct Station {
  double s = 0.0, fall = 0.0, rate = 0.0;
};

/// So near to each other that between two of them the chord misses the cubic by an eighth of the tolerance, and the
/// slope changes by a quarter of the largest jump.
std::vector<Station> stations(std::span<const Cubic> fall, double length_m, const CrownShapeOptions& options) {
  std::vector<Station> result;
  const auto add = [&](const Cubic& cubic, double s) {
    if (!result.empty() && s - result.back().s < min_knot_distance_m) return;
    result.push_back({s, std::round(value_at(cubic, s) / fall_unit) * fall_unit, slope_at(cubic, s)});
  };
  for (std::size_t i = 0; i < fall.size(); ++i) {
    const Cubic& cubic = fall[i];
    const double end = std::min(i + 1 < fall.size() ? fall[i + 1].s : length_m, length_m), length = end - cubic.s;
    if (length <= 0.0) continue;
    const double bend = std::max(std::abs(2.0 * cubic.c), std::abs(2.0 * cubic.c + 6.0 * cubic.d * length));
    const double step =
        bend > 0.0 ? std::min(std::sqrt(options.fall_tolerance / bend), 0.25 * options.max_rate_jump / bend) : length;
    const int count = std::max(1, static_cast<int>(std::ceil(length / step - 1e-9)));
    for (int k = 0; k < count; ++k)
      add(cubic, std::round((cubic.s + length * k / count) / place_unit_m) * place_unit_m);
  }
  if (result.empty()) return result;
  if (result.size() > 1 && length_m - result.back().s < min_knot_distance_m) result.pop_back();
  add(fall.back(), length_m);
  return result;
}

/// A straight stretch of the fall between two stations.
struct Chord {
  std::size_t from = 0, to = 0;
  double slope = 0.0;
  double cost = std::numeric_limits<double>::infinity();  ///< least of a way that ends with it
  std::size_t before = none;                              ///< the chord before it on that way

  static constexpr std::size_t none = std::numeric_limits<std::size_t>::max();
};

/// Chords that pass all stations between closely enough, by their first station; those to the next station always.
std::vector<Chord> chords_of(const std::vector<Station>& all, double tolerance) {
  std::vector<Chord> chords;
  for (std::size_t i = 0; i + 1 < all.size(); ++i) {
    double lowest = -std::numeric_limits<double>::infinity(), highest = -lowest;
    for (std::size_t j = i + 1; j < all.size() && lowest <= highest; ++j) {
      const double ds = all[j].s - all[i].s, slope = (all[j].fall - all[i].fall) / ds;
      if (j == i + 1 || (slope >= lowest && slope <= highest)) chords.push_back({i, j, slope});
      lowest = std::max(lowest, slope - tolerance / ds);
      highest = std::min(highest, slope + tolerance / ds);
    }
  }
  return chords;
}

/// The fewest stations with the first and the last between which chords keep the tolerances: a shortest path whose
/// steps are chords. Of equal ones that with the smallest kinks.
std::vector<Station> fewest(const std::vector<Station>& all, const CrownShapeOptions& options) {
  constexpr double too_sharp = 1e3, share_of_kinks = 1e-3;  // in chords: where nothing keeps the largest jump
  std::vector<Chord> chords = chords_of(all, 0.875 * options.fall_tolerance);
  const auto kink = [&](double jump, double largest) {
    const double share = std::abs(jump) / largest;
    return (share > 1.0 ? too_sharp : 0.0) + share_of_kinks * share * share;
  };
  std::vector<std::vector<std::size_t>> ending(all.size());
  const double half = 0.5 * options.max_rate_jump;
  for (std::size_t k = 0; k < chords.size(); ++k) {
    Chord& chord = chords[k];
    if (chord.from == 0) chord.cost = 1.0 + kink(chord.slope - all.front().rate, half);
    for (const std::size_t i : ending[chord.from]) {
      if (chords[i].cost + 1.0 >= chord.cost) continue;
      const double cost = chords[i].cost + 1.0 + kink(chord.slope - chords[i].slope, options.max_rate_jump);
      if (cost < chord.cost) chord.cost = cost, chord.before = i;
    }
    if (chord.to + 1 == all.size()) chord.cost += kink(chord.slope - all.back().rate, half);
    ending[chord.to].push_back(k);
  }
  std::size_t last = ending.back().front();
  for (const std::size_t i : ending.back())
    if (chords[i].cost < chords[last].cost) last = i;
  std::vector<Station> kept{all.back()};
  for (std::size_t i = last; i != Chord::none; i = chords[i].before) kept.push_back(all[chords[i].from]);
  std::reverse(kept.begin(), kept.end());
  return kept;
}

/// Largest distance of an edge from the reference line.
double widest_reach_m(const roadquery::Road& road) {
  constexpr double step_m = 5.0;
  const int steps = std::max(1, static_cast<int>(std::ceil(road.length / step_m)));
  double widest = 1.0;
  for (int i = 0; i <= steps; ++i) {
    const roadquery::Edges edges = roadquery::road_edges(road, road.length * i / steps);
    widest = std::max({widest, std::abs(edges.left_t), std::abs(edges.right_t)});
  }
  return widest;
}

RoadHalves halves_of(const roadquery::Road& road) {
  const roadquery::LaneSection& section = road.sections.front();
  if (!road.lane_offset.empty() || section.left.empty() == section.right.empty()) return RoadHalves::both;
  return section.left.empty() ? RoadHalves::right : RoadHalves::left;
}

}  // namespace

std::vector<roadquery::ShapeCubic> crown_shape(std::span<const Cubic> fall, double length_m,
                                               const CrownShapeOptions& options) {
  const std::vector<Station> all = stations(fall, length_m, options);
  if (std::all_of(all.begin(), all.end(), [](const Station& at) { return at.fall == 0.0; })) return {};
  std::vector<Station> kept = all.size() > 1 ? fewest(all, options) : all;
  if (kept.size() == 2 && kept[0].fall == kept[1].fall) kept.pop_back();
  std::vector<roadquery::ShapeCubic> shape;
  const double first = options.halves == RoadHalves::left ? -1.0 : 1.0;  // slope of the first entry by the fall
  shape.reserve(kept.size());
  for (const Station& at : kept) {
    shape.push_back({at.s, -crown_reach_m, -crown_reach_m * first * at.fall, first * at.fall, 0.0, 0.0});
    if (options.halves == RoadHalves::both) shape.push_back({at.s, 0.0, 0.0, -at.fall, 0.0, 0.0});
  }
  return shape;
}

double max_rate_jump_of(const roadquery::Road& road) {
  constexpr double default_speed_mps = 40.0, walking_pace_mps = 4.0;
  if (road.speed_limit_mps <= 0.0 || road.speed_limit_mps >= default_speed_mps)
    return CrownShapeOptions{}.max_rate_jump;
  return CrownShapeOptions{}.max_rate_jump * default_speed_mps / std::max(road.speed_limit_mps, walking_pace_mps);
}

void add_crown(roadquery::Road& road, std::span<const Cubic> fall, double tolerance_m, double max_rate_jump) {
  const double reach = widest_reach_m(road);
  road.shape = crown_shape(
      fall, road.length,
      {.fall_tolerance = crown_share * tolerance_m / reach, .max_rate_jump = max_rate_jump, .halves = halves_of(road)});
  road.superelevation = simplify_profile(road.superelevation, road.length, banking_share * tolerance_m / reach);
  road.elevation = simplify_profile(road.elevation, road.length, elevation_share * tolerance_m);
}

}  // namespace orthodrive::network
