// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/baselines/mrf_model.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <optional>

#include "orthodrive/geo/polygon.hpp"
#include "orthodrive/geo/spatial_index.hpp"

namespace orthodrive {
namespace {

constexpr double touch_m = 1e-6;      // rectangles may touch
constexpr double min_beside_m = 0.1;  // sites that run beside each other for less do not count as parallel
constexpr double same_road_m = 60.0;  // sites of one road nearer along it cannot be two roads side by side

using Quad = std::array<Vec2, 4>;

Quad rectangle(const MrfProblem& problem, const MrfSite& site, const MrfState& state) {
  const double half = 0.5 * problem.width_m(state), h = problem.offset_m(state);
  const Vec2 right = site.normal * (h - half), left = site.normal * (h + half);
  return {site.a + right, site.b + right, site.b + left, site.a + left};
}

/// The rectangle that all states of the site lie in.
Quad reach(const MrfProblem& problem, const MrfSite& site) {
  const double half = (site.max_width + problem.max_offset) * problem.step_m;
  return {site.a - site.normal * half, site.b - site.normal * half, site.b + site.normal * half,
          site.a + site.normal * half};
}

/// Lateral extent of a convex polygon inside the slab 0 <= s <= length of the site; also how far it reaches along.
struct Extent {
  double low = 0.0, high = 0.0, along_m = 0.0;
};
std::optional<Extent> clip_to_slab(const MrfSite& site, const Quad& corners) {
  std::optional<Extent> extent;
  double first = 0.0, last = 0.0;
  const auto take = [&](double s, double t) {
    if (!extent) extent = Extent{t, t, 0.0}, first = last = s;
    extent->low = std::min(extent->low, t), extent->high = std::max(extent->high, t);
    first = std::min(first, s), last = std::max(last, s);
  };
  // The corners of the clipped polygon: those inside, and where edges meet the two ends of the slab.
  for (std::size_t i = 0; i < 4; ++i) {
    const Vec2 p = corners[i] - site.a, q = corners[(i + 1) % 4] - site.a;
    const double s = dot(p, site.along), t = dot(p, site.normal), u = dot(q, site.along), v = dot(q, site.normal);
    if (s >= 0.0 && s <= site.length_m) take(s, t);
    for (const double end : {0.0, site.length_m})
      if ((s < end) != (u < end)) take(end, t + (v - t) * (end - s) / (u - s));
  }
  if (!extent) return {};
  extent->along_m = last - first;
  return extent;
}

/// `own` is a rectangle in the frame of the site, so that its overlap with a convex polygon is one of lateral
/// intervals.
bool overlap(const MrfSite& site, const Quad& own, const Quad& other) {
  const auto theirs = clip_to_slab(site, other);
  if (!theirs || theirs->along_m <= touch_m) return false;
  const double right = dot(own[0] - site.a, site.normal), left = dot(own[3] - site.a, site.normal);
  return theirs->low < left - touch_m && theirs->high > right + touch_m;
}

}  // namespace

double unary_cost(const MrfProblem& problem, const MrfSite& site, const MrfState& state) {
  const MrfWeights& w = problem.weights;
  const double h = problem.offset_m(state), d = 2.0 * problem.step_m * (state.width - site.input_width);
  double cost = w.prior_offset * h * h + w.prior_width * d * d;
  if (site.share > 0.0) {
    const CrossSums& sums = site.sums;
    const auto knot = [&](int level) { return static_cast<std::size_t>(level + sums.half_knots); };
    const std::size_t right = knot(state.offset - state.width), left = knot(state.offset + state.width);
    const std::size_t beside_right = knot(state.offset - state.width - problem.context);
    const std::size_t beside_left = knot(state.offset + state.width + problem.context);
    cost += site.share * (w.road * (sums.non_road_m[left] - sums.non_road_m[right]) +
                          w.context * (sums.road_beside_m[right] - sums.road_beside_m[beside_right] +
                                       sums.road_beside_m[beside_left] - sums.road_beside_m[left]) +
                          w.edge * (sums.edge_m[right] + sums.edge_m[left]));
  }
  return cost;
}

double pair_cost(const MrfProblem& problem, const MrfState& s, const MrfState& t) {
  const double h = problem.step_m * (s.offset - t.offset), w = 2.0 * problem.step_m * (s.width - t.width);
  return problem.weights.smooth_offset * h * h + problem.weights.smooth_width * w * w;
}

bool overlap(const MrfProblem& problem, std::size_t i, const MrfState& s, std::size_t j, const MrfState& t) {
  if (j < i) return overlap(problem, j, t, i, s);
  return overlap(problem.sites[i], rectangle(problem, problem.sites[i], s), rectangle(problem, problem.sites[j], t));
}

std::vector<std::vector<std::size_t>> find_conflicts(const MrfProblem& problem, const ConflictOptions& options) {
  const double min_cosine = std::cos(options.max_angle_deg * std::numbers::pi / 180.0);
  std::vector<std::size_t> chain_of(problem.sites.size());
  std::vector<double> s_m(problem.sites.size());
  for (std::size_t c = 0; c < problem.chains.size(); ++c)
    for (std::size_t i = problem.chains[c].first; i < problem.chains[c].last; ++i) {
      chain_of[i] = c;
      s_m[i] = i == problem.chains[c].first ? 0.0 : s_m[i - 1] + problem.sites[i - 1].length_m;
    }
  const auto near_on_one_road = [&](std::size_t i, std::size_t j) {
    if (chain_of[i] != chain_of[j]) return false;
    const MrfChain& chain = problem.chains[chain_of[i]];
    double apart = std::abs(s_m[i] - s_m[j]);
    if (chain.closed) apart = std::min(apart, s_m[chain.last - 1] + problem.sites[chain.last - 1].length_m - apart);
    return apart < same_road_m;
  };
  const auto in_conflict = [&](std::size_t i, std::size_t j) {
    const MrfSite &a = problem.sites[i], &b = problem.sites[j];
    if (a.layer != b.layer || std::abs(dot(a.along, b.along)) < min_cosine || near_on_one_road(i, j)) return false;
    if (a.a == b.a || a.a == b.b || a.b == b.a || a.b == b.b) return false;  // they meet
    const auto beside = clip_to_slab(a, {b.a, b.b, b.b, b.a});
    if (!beside || beside->along_m < min_beside_m) return false;
    if (!overlap(a, reach(problem, a), reach(problem, b))) return false;
    const MrfState narrow_a{0, a.min_width}, narrow_b{0, b.min_width};
    return !overlap(problem, i, narrow_a, j, narrow_b);
  };

  std::vector<std::vector<std::size_t>> conflicts(problem.sites.size());
  if (options.max_angle_deg < 0.0) return conflicts;
  std::vector<std::size_t> sites;  // those with a length
  std::vector<Box2> boxes;         // what they can cover
  for (std::size_t i = 0; i < problem.sites.size(); ++i) {
    if (!(problem.sites[i].length_m > 0.0)) continue;
    const Quad quad = reach(problem, problem.sites[i]);
    sites.push_back(i);
    boxes.push_back(bounds_of({quad.begin(), quad.end()}));
  }
  const SpatialIndex index(boxes);
  for (std::size_t m = 0; m < sites.size(); ++m)
    for (const std::uint32_t n : index.touching(boxes[m])) {
      const std::size_t i = sites[m], j = sites[n];
      if (j <= i || !in_conflict(i, j)) continue;
      conflicts[i].push_back(j), conflicts[j].push_back(i);
    }
  for (auto& of_site : conflicts) std::sort(of_site.begin(), of_site.end());
  return conflicts;
}

std::vector<MrfState> initial_states(const MrfProblem& problem) {
  std::vector<MrfState> states;
  states.reserve(problem.sites.size());
  for (const MrfSite& site : problem.sites) states.push_back({0, site.input_width});
  // Narrow roads at OSM's line do not overlap (find_conflicts), and a road made narrower makes no new overlap.
  const std::vector<MrfState> input = states;
  for (std::size_t i = 0; i < states.size(); ++i)
    for (const std::size_t j : problem.conflicts[i])
      if (overlap(problem, i, input[i], j, input[j]))
        states[i].width = problem.sites[i].min_width, states[j].width = problem.sites[j].min_width;
  return states;
}

double chain_cost(const MrfProblem& problem, const MrfChain& chain, std::span<const MrfState> states) {
  double cost = 0.0;
  for (std::size_t i = chain.first; i < chain.last; ++i) {
    cost += unary_cost(problem, problem.sites[i], states[i]);
    if (i > chain.first)
      cost += pair_cost(problem, states[i - 1], states[i]);
    else if (chain.closed && chain.last - chain.first > 1)
      cost += pair_cost(problem, states[chain.last - 1], states[i]);
  }
  return cost;
}

double mrf_energy(const MrfProblem& problem, std::span<const MrfState> states) {
  double energy = 0.0;
  for (const MrfChain& chain : problem.chains) energy += chain_cost(problem, chain, states);
  for (std::size_t i = 0; i < states.size(); ++i)
    for (const std::size_t j : problem.conflicts[i])
      if (overlap(problem, i, states[i], j, states[j])) return std::numeric_limits<double>::infinity();
  return energy;
}

}  // namespace orthodrive
