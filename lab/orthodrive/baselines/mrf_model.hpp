// SPDX-License-Identifier: Apache-2.0
#pragma once
// The Markov random field of Mattyus et al. (2015; thesis sec. 3.2): a site is a straight piece of road, its state an
// offset along its normal and a width. docs/baselines.md has the energy as formulas.

#include <cstddef>
#include <span>
#include <vector>

#include "orthodrive/baselines/mrf_evidence.hpp"
#include "orthodrive/geo/vec.hpp"

namespace orthodrive {

/// Weights of the energy's terms. A site's terms are for a piece of segment_m; shorter pieces count less. Found by
/// random and coordinate search on two synthetic villages and rounded (docs/baselines.md).
struct MrfWeights {
  double road = 1.0;            ///< 1/m: width of non-road inside the road
  double context = 1.0;         ///< 1/m: width of road in the context strips
  double edge = 0.25;           ///< 1/m: distance of the borders to an edge
  double smooth_offset = 0.6;   ///< 1/m2, between neighbours on one road
  double smooth_width = 4.0;    ///< 1/m2
  double prior_offset = 0.005;  ///< 1/m2: pull to the OSM line; decides only where nothing else does
  double prior_width = 0.02;    ///< 1/m2: pull to the input's width
};

/// Levels: offset * step_m to the left, width * 2 * step_m, so that borders lie on multiples of step_m.
struct MrfState {
  int offset = 0, width = 1;
  friend bool operator==(const MrfState&, const MrfState&) = default;
};

struct MrfSite {
  Vec2 a, b;           ///< on the OSM line
  Vec2 along, normal;  ///< unit
  double length_m = 0.0;
  double share = 1.0;  ///< of the unary terms: length over segment_m, 0 where nothing is seen
  int layer = 0;
  int input_width = 1;  ///< levels
  int min_width = 1, max_width = 1;
  CrossSums sums;
};

/// Sites first .. last - 1 in order along a road; closed: the last neighbours the first.
struct MrfChain {
  std::size_t first = 0, last = 0;
  bool closed = false;
  int rank = 0;  ///< higher ranked roads are placed first
};

struct MrfProblem {
  double step_m = 0.25;
  int max_offset = 0;  ///< levels to each side
  int context = 8;     ///< width of a context strip, levels
  MrfWeights weights;
  std::vector<MrfSite> sites;
  std::vector<MrfChain> chains;
  std::vector<std::vector<std::size_t>> conflicts;  ///< of each site: the sites it must not overlap, ascending

  [[nodiscard]] double offset_m(const MrfState& s) const { return s.offset * step_m; }
  [[nodiscard]] double width_m(const MrfState& s) const { return 2.0 * s.width * step_m; }
};

/// Cost of a state by itself: O(1), from the running sums.
[[nodiscard]] double unary_cost(const MrfProblem& problem, const MrfSite& site, const MrfState& state);
[[nodiscard]] double pair_cost(const MrfProblem& problem, const MrfState& s, const MrfState& t);
/// Whether the rectangles of sites i and j have an area in common. The same for (j, t, i, s), to the last bit.
[[nodiscard]] bool overlap(const MrfProblem& problem, std::size_t i, const MrfState& s, std::size_t j,
                           const MrfState& t);

struct ConflictOptions {
  double max_angle_deg = 20.0;  ///< roads that cross at more may overlap; negative: all may
};
/// Pairs of sites that must not overlap: of one layer, within the angle, near enough that some states do, and not
/// already in one place on the map (roads that meet). Neighbours on a road are no such pair.
[[nodiscard]] std::vector<std::vector<std::size_t>> find_conflicts(const MrfProblem& problem,
                                                                   const ConflictOptions& options);

/// OSM's line and width; where such roads overlap, their smallest widths. Free of conflicts.
[[nodiscard]] std::vector<MrfState> initial_states(const MrfProblem& problem);
/// Unary and pair costs of one road; overlaps are not looked at.
[[nodiscard]] double chain_cost(const MrfProblem& problem, const MrfChain& chain, std::span<const MrfState> states);
/// Sum of all terms; infinite when two sites in conflict overlap.
[[nodiscard]] double mrf_energy(const MrfProblem& problem, std::span<const MrfState> states);

}  // namespace orthodrive
