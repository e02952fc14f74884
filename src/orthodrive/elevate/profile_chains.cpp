#include "orthodrive/elevate/profile_chains.hpp"

#include <algorithm>
#include <cmath>

#include "orthodrive/model/design_limits.hpp"

namespace orthodrive::elevate {
namespace {

constexpr double smallest_knot_step_m = 4.0, largest_knot_step_m = 8.0;
constexpr double shortest_chain_m = 0.5;  // ways of no length still need a spline

/// Appends the nodes of a way that is entered at `entry`; the first one lies where the chain ends so far.
void append(const RoadNetwork& roads, PathEnd entry, ProfileChain& chain) {
  const auto& nodes = roads.paths[entry.path].nodes;
  double s_m = chain.length_m;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const std::size_t node = entry.at_back ? nodes.size() - 1 - i : i;
    if (i > 0) s_m += distance(nodes[entry.at_back ? node + 1 : node - 1].p, nodes[node].p);
    chain.places.push_back({entry.path, node, s_m, !entry.at_back});
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
  const int k = std::clamp(static_cast<int>(std::floor(s_m / step_m)), 0, intervals - 1);
  const double u = std::clamp(s_m / step_m - k, 0.0, 1.0), v = 1.0 - u, h = step_m;
  std::array<double, 4> b{};
  if (derivative == 0)
    b = {v * v * v / 6.0, (3.0 * u * u * u - 6.0 * u * u + 4.0) / 6.0, (3.0 * v * v * v - 6.0 * v * v + 4.0) / 6.0,
         u * u * u / 6.0};
  else if (derivative == 1)
    b = {-0.5 * v * v / h, (1.5 * u * u - 2.0 * u) / h, (2.0 * v - 1.5 * v * v) / h, 0.5 * u * u / h};
  else
    b = {v / (h * h), (3.0 * u - 2.0) / (h * h), (3.0 * v - 2.0) / (h * h), u / (h * h)};
  std::array<Term, 4> terms;
  for (int i = 0; i < 4; ++i) terms[static_cast<std::size_t>(i)] = {coefficient(k + i), b[static_cast<std::size_t>(i)]};
  return terms;
}

ProfileChains make_profile_chains(const RoadNetwork& roads, const PathLinks& links) {
  ProfileChains result;
  std::vector<bool> used(roads.paths.size(), false);
  const auto follow = [&](PathEnd entry) {
    ProfileChain chain;
    const PathEnd first = entry;
    while (true) {
      used[entry.path] = true;
      append(roads, entry, chain);
      const auto next = links.find({entry.path, !entry.at_back});
      if (next == links.end()) break;
      if (used[next->second.path]) {
        chain.closed = next->second == first;
        break;
      }
      entry = next->second;
    }
    place_knots(roads, chain);
    chain.first_unknown = result.unknowns;
    result.unknowns += chain.unknowns();
    result.chains.push_back(std::move(chain));
  };
  for (std::size_t p = 0; p < roads.paths.size(); ++p)  // open chains from their ends, so that what remains is closed
    for (const bool at_back : {false, true})
      if (!used[p] && !links.contains({p, at_back})) follow({p, at_back});
  for (std::size_t p = 0; p < roads.paths.size(); ++p)
    if (!used[p]) follow({p, false});

  for (const RoadPath& path : roads.paths) result.of_node.emplace_back(path.nodes.size());
  for (std::size_t c = 0; c < result.chains.size(); ++c)
    for (const ChainPlace& place : result.chains[c].places)
      result.of_node[place.path][place.node] = {c, place.s_m, place.forward};
  return result;
}

}  // namespace orthodrive::elevate
