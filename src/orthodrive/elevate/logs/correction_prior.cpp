// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/elevate/logs/correction_prior.hpp"

#include <algorithm>
#include <cmath>

#include "orthodrive/elevate/logs/given_profile.hpp"

namespace orthodrive::elevate {
namespace {

constexpr double tie_height_m = 2e-5, tie_slope = 5e-4;  // how exactly roads agree where they meet
constexpr double closing_slope = 1e-5, closing_bend_1pm = 1e-6;
constexpr double at_end_m = 1.0;  // nearer to its end a chain ends at a meeting

/// One of the two corrections of a chain.
struct CorrectedField {
  std::size_t chain = 0;
  int column = 0;
  double length_m = 0.0;
  double GivenProfile::*sigma = nullptr;
};

void add_process(const FusionProblem& problem, const CorrectedField& field, WeightedRows& rows) {
  const UniformSpline& s = problem.columns.spline(field.chain);
  const double k = std::sqrt(5.0) / field.length_m, k2 = k * k;
  const double weight = std::sqrt(0.5 * s.step_m() / (16.0 / 3.0 * k2 * k2 * k));
  const auto sigma = [&](double x) {
    return given_profile_at(problem.roads, problem.chains, field.chain, x, problem.options).*field.sigma;
  };
  const auto first = s.at(0.0);
  Entries value, slope, bend;  // in the steady state u' is independent, u'' has the mean -k^2 u / 3 given u
  append(value, field.column + first.first, first.value), append(slope, field.column + first.first, first.slope);
  append(bend, field.column + first.first, first.bend), append(bend, field.column + first.first, first.value, k2 / 3.0);
  rows.add(value, 0.0, 1.0 / sigma(0.0));
  rows.add(slope, 0.0, std::sqrt(3.0) / (k * sigma(0.0)));
  rows.add(bend, 0.0, 3.0 / (std::sqrt(8.0) * k2 * sigma(0.0)));
  for (int i = 0; i < s.intervals; ++i)
    for (const double u : {0.5 - 0.5 / std::sqrt(3.0), 0.5 + 0.5 / std::sqrt(3.0)}) {  // two Gauss points
      const double x = (i + u) * s.step_m();
      const auto basis = s.at(x);
      std::array<double, 4> factors;
      for (std::size_t j = 0; j < 4; ++j)
        factors[j] = basis.jerk[j] + 3.0 * k * basis.bend[j] + 3.0 * k2 * basis.slope[j] + k2 * k * basis.value[j];
      Entries entries;
      append(entries, field.column + basis.first, factors);
      rows.add(entries, 0.0, weight / sigma(x));
    }
}

/// In the direction of the chain.
Vec2 direction_at(const FusionProblem& problem, const Meeting& m) {
  const auto& nodes = problem.roads.paths[m.path].nodes;
  const std::size_t a = m.node > 0 ? m.node - 1 : 0, b = std::min(m.node + 1, nodes.size() - 1);
  return normalized(nodes[b].p - nodes[a].p) * problem.chains.sign(m.path);
}

void tie(const FusionProblem& problem, const Meeting& main, const Meeting& other, WeightedRows& rows) {
  const FusionColumns& columns = problem.columns;
  const auto a = columns.spline(main.chain).at(main.along_m), b = columns.spline(other.chain).at(other.along_m);
  if (main.chain == other.chain && std::abs(main.along_m - other.along_m) < 1e-6) return;
  Entries height;
  append(height, columns.z(main.chain) + a.first, a.value);
  append(height, columns.z(other.chain) + b.first, b.value, -1.0);
  rows.add(height, 0.0, 1.0 / tie_height_m);
  if (problem.driven.near(other.chain, other.along_m) || main.chain == other.chain) return;
  const Vec2 d_main = direction_at(problem, main), d_other = direction_at(problem, other);
  Entries slope;
  append(slope, columns.z(other.chain) + b.first, b.slope);
  append(slope, columns.z(main.chain) + a.first, a.slope, -dot(d_main, d_other));
  append(slope, columns.banking(main.chain) + a.first, a.value, -cross(d_main, d_other));
  rows.add(slope, 0.0, 1.0 / tie_slope);
  Entries across;
  append(across, columns.banking(other.chain) + b.first, b.value);
  append(across, columns.z(main.chain) + a.first, a.slope, cross(d_main, d_other));
  append(across, columns.banking(main.chain) + a.first, a.value, -dot(d_main, d_other));
  rows.add(across, 0.0, 1.0 / tie_slope);
}

/// Height and banking at the end of a closed chain are those at its begin, with their first two derivatives.
void close_chain(const FusionProblem& problem, std::size_t c, WeightedRows& rows) {
  const UniformSpline& spline = problem.columns.spline(c);
  const auto a = spline.at(0.0), b = spline.at(spline.length_m);
  for (const int column : {problem.columns.z(c), problem.columns.banking(c)}) {
    const struct {
      std::array<double, 4> UniformSpline::Basis::*of;
      double sigma;
    } orders[] = {{&UniformSpline::Basis::value, tie_height_m},
                  {&UniformSpline::Basis::slope, closing_slope},
                  {&UniformSpline::Basis::bend, closing_bend_1pm}};
    for (const auto& order : orders) {
      Entries entries;
      append(entries, column + a.first, a.*order.of), append(entries, column + b.first, b.*order.of, -1.0);
      rows.add(entries, 0.0, 1.0 / order.sigma);
    }
  }
}

}  // namespace

void add_correction_prior(const FusionProblem& problem, WeightedRows& rows) {
  for (const std::size_t c : problem.members) {
    add_process(problem, {c, problem.columns.z(c), problem.options.terrain_error_length_m, &GivenProfile::sigma_z_m},
                rows);
    add_process(problem,
                {c, problem.columns.banking(c), problem.options.banking_length_m, &GivenProfile::sigma_banking_rad},
                rows);
  }
}

void add_chain_ties(const FusionProblem& problem, WeightedRows& rows) {
  for (const auto& [id, places] : problem.meetings) {
    std::vector<Meeting> here;
    for (const Meeting& m : places)
      if (problem.columns.is_member(m.chain)) here.push_back(m);
    if (here.size() < 2) continue;
    // The others follow the road that passes through here, and of several such roads one that was driven.
    const auto rank = [&](const Meeting& m) {
      const bool passes = m.along_m > at_end_m && m.along_m < problem.chains.chains[m.chain].length_m - at_end_m;
      return std::pair(passes, problem.driven.near(m.chain, m.along_m));
    };
    std::stable_sort(here.begin(), here.end(), [&](const Meeting& a, const Meeting& b) { return rank(a) > rank(b); });
    for (std::size_t i = 1; i < here.size(); ++i) tie(problem, here.front(), here[i], rows);
  }
  for (const std::size_t c : problem.members)
    if (problem.chains.chains[c].closed) close_chain(problem, c, rows);
}

}  // namespace orthodrive::elevate
