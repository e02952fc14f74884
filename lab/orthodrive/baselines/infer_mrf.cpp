// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/baselines/infer_mrf.hpp"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <numeric>
#include <optional>
#include <utility>

#include "orthodrive/core/disjoint_sets.hpp"
#include "orthodrive/core/parallel.hpp"

namespace orthodrive::baselines {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

/// Sites that are solved together, in order along the road, and the states of those before and behind them that stay.
struct Block {
  std::vector<std::size_t> sites;
  std::optional<MrfState> before, behind;
};

/// Costs of all states of a site, offset by offset.
struct Table {
  int max_offset = 0, min_width = 1, widths = 0;
  std::vector<double> cost;

  Table(const MrfProblem& problem, const MrfSite& site)
      : max_offset(problem.max_offset),
        min_width(site.min_width),
        widths(site.max_width - site.min_width + 1),
        cost(static_cast<std::size_t>(2 * max_offset + 1) * static_cast<std::size_t>(widths)) {}
  [[nodiscard]] int offsets() const { return 2 * max_offset + 1; }
  [[nodiscard]] std::size_t index(int o, int w) const { return static_cast<std::size_t>(o * widths + w); }
  [[nodiscard]] MrfState state(int o, int w) const { return {o - max_offset, w + min_width}; }
};

/// Unary terms; infinite where the site would overlap one in conflict with it that is not in the block.
Table own_costs(const MrfProblem& problem, std::size_t i, const std::vector<MrfState>& states) {
  const MrfSite& site = problem.sites[i];
  Table table(problem, site);
  for (int o = 0; o < table.offsets(); ++o)
    for (int w = 0; w < table.widths; ++w) {
      const MrfState state = table.state(o, w);
      const auto& others = problem.conflicts[i];
      const bool blocked = std::any_of(others.begin(), others.end(),
                                       [&](std::size_t j) { return overlap(problem, i, state, j, states[j]); });
      table.cost[table.index(o, w)] = blocked ? infinity : unary_cost(problem, site, state);
    }
  return table;
}

/// The way back through one step: which level of the site before is best. The pair cost is a sum over offset and width,
/// so the minimum over both is one over widths and then one over offsets.
struct Step {
  std::vector<std::uint16_t> best_width;   // of the site before, by its offset and our width
  std::vector<std::uint16_t> best_offset;  // of the site before, by our offset and width
};

Step add_step(const MrfProblem& problem, const Table& before, Table& own) {
  const double per_width = problem.weights.smooth_width * 4.0 * problem.step_m * problem.step_m;
  const double per_offset = problem.weights.smooth_offset * problem.step_m * problem.step_m;
  const int offsets = own.offsets(), widths = own.widths;
  const auto cells = static_cast<std::size_t>(offsets) * static_cast<std::size_t>(widths);
  Step step{std::vector<std::uint16_t>(cells), std::vector<std::uint16_t>(cells)};
  std::vector<double> by_width(cells, infinity);
  for (int o = 0; o < offsets; ++o)
    for (int w = 0; w < widths; ++w) {
      double& best = by_width[own.index(o, w)];
      for (int v = 0; v < before.widths; ++v) {
        const double d = own.min_width + w - before.min_width - v,
                     cost = before.cost[before.index(o, v)] + per_width * d * d;
        if (cost < best) best = cost, step.best_width[own.index(o, w)] = static_cast<std::uint16_t>(v);
      }
    }
  std::vector<double> best(static_cast<std::size_t>(widths));
  for (int o = 0; o < offsets; ++o) {
    std::fill(best.begin(), best.end(), infinity);
    std::uint16_t* const chosen = &step.best_offset[own.index(o, 0)];
    for (int p = 0; p < offsets; ++p) {
      const double penalty = per_offset * (o - p) * (o - p);
      const double* const from = &by_width[own.index(p, 0)];
      for (int w = 0; w < widths; ++w)
        if (from[w] + penalty < best[static_cast<std::size_t>(w)])
          best[static_cast<std::size_t>(w)] = from[w] + penalty, chosen[w] = static_cast<std::uint16_t>(p);
    }
    for (int w = 0; w < widths; ++w) own.cost[own.index(o, w)] += best[static_cast<std::size_t>(w)];
  }
  return step;
}

void add_fixed(const MrfProblem& problem, const MrfState& fixed, Table& table) {
  for (int o = 0; o < table.offsets(); ++o)
    for (int w = 0; w < table.widths; ++w)
      table.cost[table.index(o, w)] += pair_cost(problem, fixed, table.state(o, w));
}

/// Viterbi: the states of least energy given all that is not in the block. The first of equals, so it is always the
/// same.
std::vector<MrfState> solve_block(const MrfProblem& problem, const Block& block, const std::vector<MrfState>& states) {
  std::vector<Step> steps;
  std::vector<Table> tables;  // only shapes are needed on the way back, so the costs of all but the last are let go
  for (std::size_t k = 0; k < block.sites.size(); ++k) {
    Table table = own_costs(problem, block.sites[k], states);
    if (k == 0 && block.before) add_fixed(problem, *block.before, table);
    if (k + 1 == block.sites.size() && block.behind) add_fixed(problem, *block.behind, table);
    if (k > 0) {
      steps.push_back(add_step(problem, tables.back(), table));
      std::vector<double>().swap(tables.back().cost);
    }
    tables.push_back(std::move(table));
  }
  std::vector<MrfState> best(block.sites.size());
  const auto& last = tables.back().cost;
  const auto at = static_cast<int>(std::min_element(last.begin(), last.end()) - last.begin());
  int o = at / tables.back().widths, w = at % tables.back().widths;
  for (std::size_t k = block.sites.size(); k-- > 0;) {
    best[k] = tables[k].state(o, w);
    if (k == 0) break;
    const int p = steps[k - 1].best_offset[tables[k].index(o, w)];
    w = steps[k - 1].best_width[tables[k].index(p, w)];
    o = p;
  }
  return best;
}

double chain_energy(const MrfProblem& problem, const MrfChain& chain, const std::vector<MrfState>& states) {
  for (std::size_t i = chain.first; i < chain.last; ++i)
    for (const std::size_t j : problem.conflicts[i])
      if (overlap(problem, i, states[i], j, states[j])) return infinity;
  return chain_cost(problem, chain, states);
}

/// Cuts sites into runs in which no two are in conflict.
std::vector<std::vector<std::size_t>> cut_at_conflicts(const MrfProblem& problem,
                                                       const std::vector<std::size_t>& sites) {
  std::vector<std::vector<std::size_t>> runs(1);
  for (const std::size_t i : sites) {
    const auto& others = problem.conflicts[i];
    if (std::any_of(runs.back().begin(), runs.back().end(),
                    [&](std::size_t j) { return std::binary_search(others.begin(), others.end(), j); }))
      runs.emplace_back();
    runs.back().push_back(i);
  }
  return runs;
}

/// The runs of a chain for one sweep. Closed: one site stays, another one every other sweep. Cut from the back every
/// other sweep.
std::vector<std::vector<std::size_t>> runs_of(const MrfProblem& problem, const MrfChain& chain, int sweep) {
  const std::size_t count = chain.last - chain.first, held = chain.closed && count > 1 ? 1 : 0;
  const std::size_t start = held == 0 ? 0 : (sweep % 2 == 0 ? 1 : count / 2 + 1);
  std::vector<std::size_t> sites;
  for (std::size_t k = 0; k + held < count; ++k) sites.push_back(chain.first + (start + k) % count);
  if (sweep % 2 == 0) return cut_at_conflicts(problem, sites);
  std::reverse(sites.begin(), sites.end());
  auto runs = cut_at_conflicts(problem, sites);
  for (auto& run : runs) std::reverse(run.begin(), run.end());
  return runs;
}

/// Takes new states of a block if they are better.
void try_states(const MrfProblem& problem, const MrfChain& chain, const Block& block,
                const std::vector<MrfState>& found, std::vector<MrfState>& states) {
  const double before = chain_energy(problem, chain, states);
  std::vector<MrfState> kept;
  kept.reserve(found.size());
  for (std::size_t k = 0; k < found.size(); ++k) kept.push_back(std::exchange(states[block.sites[k]], found[k]));
  if (chain_energy(problem, chain, states) < before) return;
  for (std::size_t k = 0; k < found.size(); ++k) states[block.sites[k]] = kept[k];
}

/// One pass over a chain; writes only the states of the chain.
void sweep_chain(const MrfProblem& problem, const MrfChain& chain, int sweep, std::vector<MrfState>& states) {
  const std::size_t count = chain.last - chain.first;
  if (chain.closed && sweep == 0) {
    // A closed road would start from its held site's OSM position: offer the best of the road cut open instead.
    std::vector<std::size_t> all(count);
    std::iota(all.begin(), all.end(), chain.first);
    for (const auto& run : cut_at_conflicts(problem, all)) {
      const Block block{.sites = run};
      try_states(problem, chain, block, solve_block(problem, block, states), states);
    }
  }
  for (auto& run : runs_of(problem, chain, sweep)) {
    Block block{.sites = std::move(run)};
    const auto neighbour = [&](std::size_t site, bool ahead) -> std::optional<MrfState> {
      const std::size_t k = site - chain.first;
      if (!chain.closed && (ahead ? k + 1 == count : k == 0)) return {};
      if (count == 1) return {};
      return states[chain.first + (ahead ? k + 1 : k + count - 1) % count];
    };
    block.before = neighbour(block.sites.front(), false);
    block.behind = neighbour(block.sites.back(), true);
    try_states(problem, chain, block, solve_block(problem, block, states), states);
  }
}

/// Chains that conflicts tie together, each group with its highest ranked chain first.
std::vector<std::vector<std::size_t>> group_chains(const MrfProblem& problem) {
  std::vector<std::size_t> chain_of(problem.sites.size());
  DisjointSets tied(problem.chains.size());
  for (std::size_t c = 0; c < problem.chains.size(); ++c)
    for (std::size_t i = problem.chains[c].first; i < problem.chains[c].last; ++i) chain_of[i] = c;
  for (std::size_t i = 0; i < problem.sites.size(); ++i)
    for (const std::size_t j : problem.conflicts[i]) tied.join(chain_of[i], chain_of[j]);
  std::vector<std::vector<std::size_t>> groups(problem.chains.size());
  for (std::size_t c = 0; c < problem.chains.size(); ++c) groups[tied.find(c)].push_back(c);
  std::erase_if(groups, [](const auto& g) { return g.empty(); });
  for (auto& g : groups)
    std::stable_sort(g.begin(), g.end(),
                     [&](std::size_t a, std::size_t b) { return problem.chains[a].rank > problem.chains[b].rank; });
  return groups;
}

struct GroupResult {
  std::vector<double> energies;
  bool converged = false;
};

GroupResult solve_group(const MrfProblem& problem, const std::vector<std::size_t>& group,
                        const InferMrfOptions& options, std::vector<MrfState>& states) {
  const auto energy = [&] {
    double sum = 0.0;
    for (const std::size_t c : group) sum += chain_energy(problem, problem.chains[c], states);
    return sum;
  };
  // A road by itself that is solved in one block is at its optimum after one sweep.
  const MrfChain& first = problem.chains[group.front()];
  const bool exact = group.size() == 1 && !first.closed && runs_of(problem, first, 0).size() == 1;
  GroupResult result{.energies = {energy()}};
  int idle = 0;  // sweeps without a gain; two, because blocks differ from one to the next
  for (int sweep = 0; sweep < options.max_sweeps && !result.converged; ++sweep) {
    for (const std::size_t c : group) sweep_chain(problem, problem.chains[c], sweep, states);
    result.energies.push_back(energy());
    idle = result.energies.back() < result.energies[result.energies.size() - 2] ? 0 : idle + 1;
    result.converged = exact || idle == 2;
  }
  return result;
}

}  // namespace

InferMrfResult infer_mrf(const MrfProblem& problem, const InferMrfOptions& options, Monitor* monitor) {
  InferMrfResult result{.states = initial_states(problem)};
  const auto groups = group_chains(problem);
  std::vector<GroupResult> of_group(groups.size());
  parallel_for(
      groups.size(), options.threads,
      [&](std::size_t g) {
        of_group[g] = solve_group(problem, groups[g], options, result.states);
      },  // groups share no site
      [&](std::size_t done) {
        if (monitor) monitor->progress(static_cast<double>(done) / static_cast<double>(groups.size()), "place roads");
      });
  for (const GroupResult& group : of_group) {
    result.sweeps = std::max(result.sweeps, static_cast<int>(group.energies.size()) - 1);
    result.converged = result.converged && group.converged;
  }
  result.energies.assign(static_cast<std::size_t>(result.sweeps) + 1, 0.0);
  for (const GroupResult& group : of_group)
    for (std::size_t k = 0; k < result.energies.size(); ++k)
      result.energies[k] += group.energies[std::min(k, group.energies.size() - 1)];
  return result;
}

}  // namespace orthodrive::baselines
