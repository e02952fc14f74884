// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/elevate/logs/solve_corrections.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

#include "orthodrive/elevate/logs/correction_prior.hpp"
#include "orthodrive/elevate/logs/sensor_model.hpp"

namespace orthodrive::elevate {
namespace {

constexpr double robust_scale = 3.0;  // residuals beyond 3 standard deviations lose their weight (Cauchy)
constexpr int most_passes = 12;
constexpr double settled_m = 5e-4;  // and rad: coefficients are heights and banking

/// The fixed rows and those of the measurements around x.
WeightedRows all_rows(const FusionProblem& problem, const WeightedRows& fixed, const std::vector<double>& x) {
  WeightedRows rows = fixed;
  const bool robust = std::any_of(x.begin(), x.end(), [](double v) { return v != 0.0; });  // not in the first pass
  for (const DrivenSample& sample : problem.samples)
    for (Measurement& m : measurements_of(problem, sample, x)) {
      const double r = m.residual(x) / (robust_scale * m.sigma);
      const double weight = robust ? 1.0 / std::sqrt(1.0 + r * r) : 1.0;
      rows.add(std::move(m.entries), m.value, weight / m.sigma_of_mean);
    }
  return rows;
}

DriveResiduals residuals_of(const FusionProblem& problem, const std::vector<double>& x) {
  DriveResiduals sums;
  std::map<double*, double> counts;
  for (const DrivenSample& sample : problem.samples)
    for (const Measurement& m : measurements_of(problem, sample, x))
      sums.*m.kind += std::pow(m.residual(x), 2), counts[&(sums.*m.kind)] += 1.0;
  for (const auto& [sum, count] : counts) *sum = std::sqrt(*sum / count);
  sums.places = problem.samples.size();
  return sums;
}

/// A node that is corrected.
struct CorrectedNode {
  std::size_t path = 0, node = 0, chain = 0;
  bool driven = false;
  UniformSpline::Basis basis;
};

std::vector<CorrectedNode> corrected_nodes(const FusionProblem& problem) {
  std::vector<CorrectedNode> nodes;
  for (std::size_t path = 0; path < problem.roads.paths.size(); ++path) {
    const std::size_t c = problem.chains.chain_of[path];
    if (!problem.columns.is_member(c)) continue;
    for (std::size_t n = 0; n < problem.roads.paths[path].nodes.size(); ++n) {
      const double s = problem.chains.along_m(path, problem.roads.paths[path].nodes[n].s_m);
      nodes.push_back({path, n, c, problem.driven.near(c, s), problem.columns.spline(c).at(s)});
    }
  }
  return nodes;
}

constexpr std::array calibrated{FusionColumns::mount_pitch, FusionColumns::pitch_gain, FusionColumns::mount_roll,
                                FusionColumns::roll_gain};

/// Standard deviations: height, gradient and banking of every node, then the calibrated parameters of every source.
std::vector<double> sigmas_of(const FusionProblem& problem, const std::vector<CorrectedNode>& nodes,
                              const SparseJacobian& jacobian) {
  SparseJacobian functions{.columns = problem.columns.count(), .row_start = {0}};
  const auto add_function = [&](int first, const std::array<double, 4>& factors) {
    for (int k = 0; k < 4; ++k)
      functions.column.push_back(first + k), functions.value.push_back(factors[static_cast<std::size_t>(k)]);
    functions.row_start.push_back(static_cast<int>(functions.column.size()));
  };
  for (const CorrectedNode& node : nodes) {
    const int z = problem.columns.z(node.chain), banking = problem.columns.banking(node.chain);
    add_function(z + node.basis.first, node.basis.value);
    add_function(z + node.basis.first, node.basis.slope);
    add_function(banking + node.basis.first, node.basis.value);
  }
  for (std::size_t k = 0; k < problem.log.sources.size(); ++k)
    for (const FusionColumns::Parameter p : calibrated) {
      functions.column.push_back(problem.columns.source(k, p)), functions.value.push_back(1.0);
      functions.row_start.push_back(static_cast<int>(functions.column.size()));
    }
  std::vector<double> sigmas = normal_variances(jacobian, functions);
  for (double& s : sigmas) s = std::sqrt(std::max(0.0, s));
  return sigmas;
}

}  // namespace

Corrections solve_corrections(const FusionProblem& problem) {
  Corrections c{.x = std::vector<double>(static_cast<std::size_t>(problem.columns.count()), 0.0),
                .solve = {.converged = false}};
  WeightedRows fixed;
  fixed.jacobian.columns = problem.columns.count();
  add_correction_prior(problem, fixed);
  add_chain_ties(problem, fixed);
  add_sensor_priors(problem, fixed);
  for (int pass = 0; pass < most_passes && !c.solve.converged; ++pass) {
    const WeightedRows rows = all_rows(problem, fixed, c.x);
    if (pass == 0) c.solve.cost_before = rows.half_square_sum(c.x);
    std::vector<double> x = solve_normal(rows.jacobian, rows.right);
    double change = 0.0;
    for (int i = 0; i < problem.columns.first_source(); ++i)
      change = std::max(change, std::abs(x[static_cast<std::size_t>(i)] - c.x[static_cast<std::size_t>(i)]));
    c.x = std::move(x);
    c.solve.iterations = pass + 1, c.solve.cost_after = rows.half_square_sum(c.x);
    c.solve.converged = change < settled_m;
  }
  c.rows = all_rows(problem, fixed, c.x);
  c.residuals = residuals_of(problem, c.x);
  return c;
}

void write_corrections(const FusionProblem& problem, const Corrections& corrections, FuseDriveLogsResult& result) {
  const std::vector<CorrectedNode> nodes = corrected_nodes(problem);
  const std::vector<double> sigma = sigmas_of(problem, nodes, corrections.rows.jacobian);
  const std::vector<double>& x = corrections.x;
  const auto improve = [](double& given, double now) { given = given > 0.0 ? std::min(given, now) : now; };
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const auto& [path, n, chain, driven, basis] = nodes[i];
    RoadNode& node = result.roads.paths[path].nodes[n];
    const double sign = problem.chains.sign(path);
    const int z = problem.columns.z(chain) + basis.first, banking = problem.columns.banking(chain) + basis.first;
    node.z_m += combine(x, z, basis.value);
    node.gradient += sign * combine(x, z, basis.slope);
    node.banking += sign * combine(x, banking, basis.value);
    improve(node.sigma_z_m, sigma[3 * i]);
    improve(node.sigma_banking, sigma[3 * i + 2]);
    if (!driven) continue;
    node.banking_source = BankingSource::log;
    result.driven.push_back({path, n, sigma[3 * i + 1]});
  }
  for (std::size_t k = 0; k < problem.log.sources.size(); ++k) {
    const std::size_t f = 3 * nodes.size() + calibrated.size() * k;  // sigmas stand in the order of `calibrated`
    const auto value = [&](FusionColumns::Parameter p) {
      return x[static_cast<std::size_t>(problem.columns.source(k, p))];
    };
    result.calibration.push_back({.source = problem.log.sources[k],
                                  .mount_pitch_rad = value(FusionColumns::mount_pitch),
                                  .sigma_mount_pitch_rad = sigma[f],
                                  .mount_roll_rad = value(FusionColumns::mount_roll),
                                  .sigma_mount_roll_rad = sigma[f + 2],
                                  .pitch_rad_per_mps2 = value(FusionColumns::pitch_gain),
                                  .sigma_pitch_rad_per_mps2 = sigma[f + 1],
                                  .roll_rad_per_mps2 = value(FusionColumns::roll_gain),
                                  .sigma_roll_rad_per_mps2 = sigma[f + 3]});
  }
  result.residuals = corrections.residuals;
}

}  // namespace orthodrive::elevate
