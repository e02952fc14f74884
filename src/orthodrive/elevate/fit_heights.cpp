#include "orthodrive/elevate/fit_heights.hpp"

#include <ceres/ceres.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "orthodrive/core/normal_matrix.hpp"

namespace orthodrive {
namespace {

constexpr double shortest_run_m = 0.1;       // nodes on top of each other must not give endless gradients
constexpr double clearance_weight = 20.0;    // 1/m: 0.1 m of missing clearance against ten nodes of ramp
constexpr double smallest_terrain_sigma_m = 0.1;  // no terrain model is better than this on a road

/// Residual weight * sum(c_i z_i) - value: every height residual is linear in the heights.
template <int N>
class LinearCost final : public ceres::CostFunction {
 public:
  LinearCost(const std::array<double, N>& coefficients, double value) : c_(coefficients), value_(value) {
    set_num_residuals(1);
    for (int i = 0; i < N; ++i) mutable_parameter_block_sizes()->push_back(1);
  }
  bool Evaluate(double const* const* z, double* residuals, double** jacobians) const override {
    residuals[0] = -value_;
    for (int i = 0; i < N; ++i) residuals[0] += c_[i] * *z[i];
    for (int i = 0; jacobians && i < N; ++i)
      if (jacobians[i]) jacobians[i][0] = c_[i];
    return true;
  }

 private:
  std::array<double, N> c_;
  double value_;
};

/// weight * what a bridge or tunnel lacks to its limit; nothing beyond it.
class StructureCost final : public ceres::SizedCostFunction<1, 1, 1> {
 public:
  explicit StructureCost(const StructureLimit& limit)
      : sign_(limit.side == StructureLimit::Side::above ? 1.0 : -1.0), fraction_(limit.fraction), limit_z_m_(limit.z_m) {}
  bool Evaluate(double const* const* z, double* residuals, double** jacobians) const override {
    const double lack = sign_ * (limit_z_m_ - (*z[0] * (1.0 - fraction_) + *z[1] * fraction_));
    residuals[0] = clearance_weight * std::max(0.0, lack);
    const double slope = lack > 0.0 ? -sign_ * clearance_weight : 0.0;
    if (jacobians && jacobians[0]) jacobians[0][0] = slope * (1.0 - fraction_);
    if (jacobians && jacobians[1]) jacobians[1][0] = slope * fraction_;
    return true;
  }

 private:
  double sign_, fraction_, limit_z_m_;
};

class HeightProblem {
 public:
  HeightProblem(const RoadNetwork& roads, const HeightUnknowns& unknowns, const std::vector<std::size_t>& paths, const ElevateOptions& options)
      : roads_(roads), unknowns_(unknowns), options_(options) {
    for (const std::size_t k : paths) members_.insert(members_.end(), unknowns.of_node[k].begin(), unknowns.of_node[k].end());
    std::sort(members_.begin(), members_.end());
    members_.erase(std::unique(members_.begin(), members_.end()), members_.end());
    for (const std::size_t i : members_) z_.push_back(unknowns.start_m[i]);
    for (double& z : z_) problem_.AddParameterBlock(&z, 1);
    std::size_t segments = 0;
    for (const std::size_t k : paths) mean_spacing_m_ += length_m(centerline(roads.paths[k])), segments += roads.paths[k].nodes.size() - 1;
    mean_spacing_m_ = std::max(shortest_run_m, mean_spacing_m_ / static_cast<double>(segments));
  }

  /// r_e = w_e (h - h_terrain) under the Cauchy loss.
  void add_terrain() {
    const bool any = std::any_of(members_.begin(), members_.end(), [&](std::size_t i) { return unknowns_.measured[i]; });
    for (std::size_t m = 0; m < members_.size(); ++m) {
      const std::size_t i = members_[m];
      if (any && !unknowns_.measured[i]) continue;
      const double height_m = any ? unknowns_.terrain_m[i] : unknowns_.start_m[i];
      terrain_.push_back(problem_.AddResidualBlock(new LinearCost<1>({options_.weight_height}, options_.weight_height * height_m),
                                                   new ceres::CauchyLoss(options_.cauchy_scale), &z_[m]));
    }
  }

  /// r_g = w_g rise / run of every segment and r_v = w_v (g_n - g_(n-1)) of every pair of segments of a path.
  void add_smoothness(std::size_t path) {
    const auto& nodes = roads_.paths[path].nodes;
    for (std::size_t n = 0; n + 1 < nodes.size(); ++n) {
      if (height(path, n) == height(path, n + 1)) continue;
      const double k = options_.weight_gradient / run_m(path, n);
      problem_.AddResidualBlock(new LinearCost<2>({-k, k}, 0.0), nullptr, height(path, n), height(path, n + 1));
      if (n > 0) add_gradient_change(height(path, n - 1), run_m(path, n - 1), height(path, n), run_m(path, n), height(path, n + 1));
    }
  }

  /// The same gradient change where a way goes on in the next one.
  void add_link(PathEnd a, PathEnd b) {
    const auto inner = [&](PathEnd end) { return end.at_back ? roads_.paths[end.path].nodes.size() - 2 : std::size_t{1}; };
    const auto outer = [&](PathEnd end) { return end.at_back ? roads_.paths[end.path].nodes.size() - 1 : std::size_t{0}; };
    const auto run = [&](PathEnd end) { return run_m(end.path, std::min(inner(end), outer(end))); };
    add_gradient_change(height(a.path, inner(a)), run(a), height(a.path, outer(a)), run(b), height(b.path, inner(b)));
  }

  void add_limit(const StructureLimit& limit) {
    problem_.AddResidualBlock(new StructureCost(limit), nullptr, height_of(limit.before), height_of(limit.after));
  }

  [[nodiscard]] HeightFit solve() {
    ceres::Solver::Options solver;
    solver.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
    solver.sparse_linear_algebra_library_type = ceres::EIGEN_SPARSE;  // no BLAS, so no threads and no run to run differences
    solver.initial_trust_region_radius = 1e8;  // all residuals are linear: full Gauss-Newton steps from the start
    solver.max_num_iterations = options_.max_iterations;
    solver.function_tolerance = 1e-8;
    solver.num_threads = 1;
    solver.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    ceres::Solve(solver, &problem_, &summary);
    HeightFit fit{.unknowns = members_, .z_m = z_};
    fit.solve = {summary.termination_type == ceres::CONVERGENCE, static_cast<int>(summary.iterations.size()) - 1,
                 summary.initial_cost, summary.final_cost};
    estimate_sigmas(fit);
    return fit;
  }

 private:
  double* height_of(std::size_t unknown) {
    return &z_[static_cast<std::size_t>(std::lower_bound(members_.begin(), members_.end(), unknown) - members_.begin())];
  }
  double* height(std::size_t path, std::size_t node) { return height_of(unknowns_.of_node[path][node]); }
  [[nodiscard]] double run_m(std::size_t path, std::size_t segment) const {
    const auto& nodes = roads_.paths[path].nodes;
    return std::max(shortest_run_m, distance(nodes[segment].p, nodes[segment + 1].p));
  }
  void add_gradient_change(double* a, double run_ab_m, double* b, double run_bc_m, double* c) {
    if (a == b || b == c || a == c) return;  // a closed way of two nodes
    const double w = options_.weight_gradient_change, ab = w / run_ab_m, bc = w / run_bc_m;
    problem_.AddResidualBlock(new LinearCost<3>({ab, -ab - bc, bc}, 0.0), nullptr, a, b, c);
  }

  /// From the normal matrix, scaled by the variance of the terrain residuals. Heights of one terrain pixel err together,
  /// so a pixel with many nodes is one observation.
  void estimate_sigmas(HeightFit& fit) {
    ceres::Problem::EvaluateOptions terrain_only;
    terrain_only.residual_blocks = terrain_;
    terrain_only.apply_loss_function = true;
    std::vector<double> residuals;
    problem_.Evaluate(terrain_only, nullptr, &residuals, nullptr, nullptr);
    double sum = 0.0;
    for (const double r : residuals) sum += r * r;
    const double floor = options_.weight_height * smallest_terrain_sigma_m;
    const double variance = std::max(floor * floor, sum / static_cast<double>(residuals.size())) *
                            std::max(1.0, unknowns_.coarsest_gsd_m / mean_spacing_m_);
    ceres::Problem::EvaluateOptions all;
    for (double& z : z_) all.parameter_blocks.push_back(&z);
    ceres::CRSMatrix jacobian;
    problem_.Evaluate(all, nullptr, nullptr, nullptr, &jacobian);
    fit.sigma_z_m = inverse_normal_diagonal({jacobian.num_cols, std::move(jacobian.rows), std::move(jacobian.cols), std::move(jacobian.values)});
    for (double& s : fit.sigma_z_m) s = std::sqrt(s * variance);
  }

  const RoadNetwork& roads_;
  const HeightUnknowns& unknowns_;
  const ElevateOptions& options_;
  std::vector<std::size_t> members_;  // unknowns of the component, ascending
  std::vector<double> z_;
  double mean_spacing_m_ = 0.0;
  ceres::Problem problem_;
  std::vector<ceres::ResidualBlockId> terrain_;
};

}  // namespace

HeightFit fit_heights(const RoadNetwork& roads, const HeightUnknowns& unknowns, const std::vector<std::size_t>& paths,
                      const PathLinks& links, const std::vector<StructureLimit>& limits, const ElevateOptions& options) {
  HeightProblem problem(roads, unknowns, paths, options);
  problem.add_terrain();
  for (const std::size_t path : paths) {
    problem.add_smoothness(path);
    for (const bool at_back : {false, true}) {
      const PathEnd end{path, at_back};
      const auto link = links.find(end);
      if (link != links.end() && end < link->second) problem.add_link(end, link->second);  // each pair once
    }
  }
  for (const StructureLimit& limit : limits) problem.add_limit(limit);
  return problem.solve();
}

}  // namespace orthodrive
