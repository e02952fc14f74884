// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/elevate/terrain/profile_chains.hpp"

#include <algorithm>
#include <cmath>

#include "orthodrive/math/uniform_spline.hpp"
#include "orthodrive/model/roads/design_limits.hpp"

namespace orthodrive::elevate {
namespace {

constexpr double smallest_knot_step_m = 4.0, largest_knot_step_m = 8.0;
constexpr double shortest_chain_m = 0.5;  // ways of no length still need a spline

/// Appends the nodes of a way; the first one lies where the chain ends so far.
void append_member(const RoadNetwork& roads, const ChainPath& member, ProfileChain& chain) {
  const auto& nodes = roads.paths[member.path].nodes;
  double s_m = chain.length_m;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const std::size_t node = member.reversed ? nodes.size() - 1 - i : i;
    if (i > 0) s_m += distance(nodes[member.reversed ? node + 1 : node - 1].p, nodes[node].p);
    chain.places.push_back({member.path, node, s_m, !member.reversed});
  }
  chain.length_m = s_m;
}

void place_knots(const RoadNetwork& roads, ProfileChain& chain) {
  double step_m = largest_knot_step_m;
  for (const ChainPlace& place : chain.places) {
    const double speed_kmh = design_limits(roads.paths[place.path].highway).design_speed_kmh;
    step_m = std::min(step_m, vertical_curve_length_m(speed_kmh) / 3.0);
  }
  chain.length_m = std::max(chain.length_m, shortest_chain_m);
  chain.intervals = std::max(1, static_cast<int>(std::lround(chain.length_m / std::max(step_m, smallest_knot_step_m))));
  chain.step_m = chain.length_m / chain.intervals;
}

}  // namespace

std::array<Term, 4> ProfileChain::basis(double s_m, int derivative) const {
  UniformSpline spline;
  spline.length_m = length_m, spline.intervals = intervals;
  const UniformSpline::Basis b = spline.at(s_m);
  const std::array<double, 4>& values = derivative == 0 ? b.value : derivative == 1 ? b.slope : b.bend;
  std::array<Term, 4> terms;
  for (int i = 0; i < 4; ++i) {
    const auto at = static_cast<std::size_t>(i);
    terms[at] = {coefficient(b.first + i), values[at]};
  }
  return terms;
}

ProfileChains make_profile_chains(const RoadNetwork& roads, const PathLinks& links) {
  ProfileChains result;
  for (const PathChain& paths : chain_paths(roads, links, ChainOrder::open_chains_first)) {
    ProfileChain chain;
    chain.closed = paths.closed;
    for (const ChainPath& member : paths.paths) append_member(roads, member, chain);
    place_knots(roads, chain);
    chain.first_unknown = result.unknowns;
    result.unknowns += chain.unknowns();
    result.chains.push_back(std::move(chain));
  }

  for (const RoadPath& path : roads.paths) result.of_node.emplace_back(path.nodes.size());
  for (std::size_t c = 0; c < result.chains.size(); ++c)
    for (const ChainPlace& place : result.chains[c].places)
      result.of_node[place.path][place.node] = {c, place.s_m, place.forward};
  return result;
}

}  // namespace orthodrive::elevate
