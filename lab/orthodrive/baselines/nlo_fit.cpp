// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/baselines/nlo_fit.hpp"

#include <ceres/ceres.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace orthodrive::baselines {
namespace {

constexpr double same_place_m = 1e-3;  // nodes nearer than this are one: the direction between them says nothing

/// r_c, eq. 3.3, of the segment between two nodes: the context strips, the boundary strips.
class ClassificationCost final : public ceres::SizedCostFunction<2, 1, 1, 1, 1> {
 public:
  struct Source {
    const LabelMap& labels;
    const LabelCosts& costs;
    double strip_m, step_m;
  };
  ClassificationCost(const NloNode& a, const NloNode& b, const Source& source, double weight)
      : a_(a), b_(b), source_(source), weight_(weight) {}

  /// offset and width of the first node, then of the second
  using Parameters = std::array<double, 4>;
  struct Sums {
    StripSum context, boundary;
  };
  [[nodiscard]] static Sums sums(const NloNode& a, const NloNode& b, const Source& source, const Parameters& x) {
    Sums sums;
    for (const double side : {1.0, -1.0}) {
      const Vec2 out_a = a.normal * side, out_b = b.normal * side;
      const Vec2 border_a = a.base + a.normal * x[0] + out_a * (0.5 * x[1]);
      const Vec2 border_b = b.base + b.normal * x[2] + out_b * (0.5 * x[3]);
      const auto strip = [&](double reach) {
        return LabelStrip{border_a, border_b, border_a + out_a * reach, border_b + out_b * reach, source.strip_m};
      };
      add_strip(source.labels, source.costs.outside, strip(source.strip_m), sums.context);
      add_strip(source.labels, source.costs.inside, strip(-source.strip_m), sums.boundary);
    }
    return sums;
  }

  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    Parameters x{*parameters[0], *parameters[1], *parameters[2], *parameters[3]};
    const Sums here = sums(a_, b_, source_, x);
    residuals[0] = weight_ * here.context.mean();
    residuals[1] = weight_ * here.boundary.mean();
    for (std::size_t k = 0; jacobians && k < 4; ++k) {
      if (!jacobians[k]) continue;
      // Central differences of our own: Ceres' steps are relative to the parameter, and offsets begin at 0. Coordinates
      // of 5e6 m round to 1e-9 m: a thousandth of the step.
      const double middle = x[k];
      x[k] = middle + source_.step_m;
      const Sums after = sums(a_, b_, source_, x);
      x[k] = middle - source_.step_m;
      const Sums before = sums(a_, b_, source_, x);
      x[k] = middle;
      jacobians[k][0] = weight_ * (after.context.mean() - before.context.mean()) / (2.0 * source_.step_m);
      jacobians[k][1] = weight_ * (after.boundary.mean() - before.boundary.mean()) / (2.0 * source_.step_m);
    }
    return true;
  }

 private:
  const NloNode &a_, &b_;
  Source source_;
  double weight_;
};

template <typename T>
struct Turn {
  T cross, dot;
};
/// v1 x v2 and v1 . v2 of the two segments of three nodes with these offsets.
template <typename T>
Turn<T> turn_of(const std::array<const NloNode*, 3>& nodes, const std::array<const T*, 3>& offset) {
  std::array<T, 3> x, y;
  for (std::size_t i = 0; i < 3; ++i) {
    x[i] = nodes[i]->base.x + *offset[i] * nodes[i]->normal.x;
    y[i] = nodes[i]->base.y + *offset[i] * nodes[i]->normal.y;
  }
  const T x1 = x[1] - x[0], y1 = y[1] - y[0], x2 = x[2] - x[1], y2 = y[2] - y[1];
  return {x1 * y2 - y1 * x2, x1 * x2 + y1 * y2};
}
/// atan2 that has a derivative where both segments have no length.
template <typename T>
T angle_of(const T& cross, const T& dot) {
  using std::atan2;
  if (cross * cross + dot * dot < T(1e-18)) return T(0.0);
  return atan2(cross, dot);
}

/// r_a, eq. 3.8.
struct AngleCost {
  std::array<const NloNode*, 3> nodes;
  double weight;
  template <typename T>
  bool operator()(const T* a, const T* b, const T* c, T* residual) const {
    using std::abs;
    const Turn<T> turn = turn_of<T>(nodes, {a, b, c});
    *residual = weight * angle_of<T>(abs(turn.cross), turn.dot);
    return true;
  }
};

/// r_w and r_o, eq. 3.9 and 3.10.
struct DifferenceCost {
  double weight;
  template <typename T>
  bool operator()(const T* before, const T* after, T* residual) const {
    *residual = weight * (*after - *before);
    return true;
  }
};

/// The nodes before and after every inner node that are at other places.
template <typename Visit>
void for_turns(const NloPath& path, const Visit& visit) {
  const std::size_t last = path.nodes.size() - 1;
  for (std::size_t i = path.closed ? 0 : 1; i < last; ++i) {
    if (path.nodes[i].own != i) continue;
    std::size_t before = i == 0 ? last - 1 : i - 1, after = i + 1;
    while (before > 0 && path.nodes[before].own == i) --before;  // nodes at one place follow each other
    before = path.nodes[before].own;
    while (after < last && path.nodes[after].own == i) ++after;
    after = path.nodes[after].own;
    if (before != i && after != i && before != after) visit(before, i, after);
  }
}

void set_solver(ceres::Solver::Options& solver, int iterations) {
  solver.minimizer_type = ceres::TRUST_REGION;
  solver.trust_region_strategy_type = ceres::LEVENBERG_MARQUARDT;
  solver.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  solver.sparse_linear_algebra_library_type =
      ceres::EIGEN_SPARSE;  // no BLAS, so no threads and no run to run differences
  solver.max_num_iterations = iterations;
  solver.num_threads = 1;
  solver.logging_type = ceres::SILENT;
}

/// Normals of the bisectors; where a closed path closes, of the segments on both sides.
void set_normals(NloPath& path) {
  Polyline line;
  for (const NloNode& node : path.nodes) line.push_back(node.base);
  std::vector<Vec2> direction = tangents(line);
  if (path.closed) {
    const Vec2 both = direction.front() + direction.back();
    if (length(both) > 1e-9)
      direction.front() = direction.back() = normalized(both);
    else
      direction.back() = direction.front();
  }
  for (std::size_t i = 0; i < line.size(); ++i) path.nodes[i].normal = left_normal(direction[i]);
}

using Problem = ceres::Problem;

void add_residuals(Problem& problem, const NloPath& path, const std::vector<bool>& seen,
                   const ClassificationCost::Source& source, const NloRoadsOptions& options, const NloPass& pass,
                   NloFit& fit) {
  std::vector<double>&offset = fit.offset_m, &width = fit.width_m;
  std::vector<bool> held(path.nodes.size(), true);
  for (std::size_t i = 0; i + 1 < path.nodes.size(); ++i)
    if (seen[i]) held[path.nodes[i].own] = held[path.nodes[i + 1].own] = false;
  for (std::size_t i = 0; i < path.nodes.size(); ++i) {
    if (path.nodes[i].own != i) continue;
    for (double* const value : {&offset[i], &width[i]}) {
      problem.AddParameterBlock(value, 1);
      if (held[i]) problem.SetParameterBlockConstant(value);
    }
    if (held[i]) continue;
    problem.SetParameterLowerBound(&offset[i], 0, -options.max_offset_m);
    problem.SetParameterUpperBound(&offset[i], 0, options.max_offset_m);
    problem.SetParameterLowerBound(&width[i], 0, options.min_width_factor * path.nodes[i].width_m);
    problem.SetParameterUpperBound(&width[i], 0, options.max_width_factor * path.nodes[i].width_m);
  }
  for (std::size_t i = 0; i + 1 < path.nodes.size(); ++i) {
    const std::size_t a = path.nodes[i].own, b = path.nodes[i + 1].own;
    if (a == b) continue;
    problem.AddResidualBlock(new ClassificationCost(path.nodes[a], path.nodes[b], source, pass.weight_class), nullptr,
                             &offset[a], &width[a], &offset[b], &width[b]);
    const auto add_difference = [&](std::vector<double>& of, double weight) {
      if (weight > 0.0)
        problem.AddResidualBlock(new ceres::AutoDiffCostFunction<DifferenceCost, 1, 1, 1>(new DifferenceCost{weight}),
                                 nullptr, &of[a], &of[b]);
    };
    add_difference(width, pass.weight_width);
    add_difference(offset, pass.weight_offset);
  }
  for_turns(path, [&](std::size_t a, std::size_t b, std::size_t c) {
    problem.AddResidualBlock(new ceres::AutoDiffCostFunction<AngleCost, 1, 1, 1, 1>(
                                 new AngleCost{{&path.nodes[a], &path.nodes[b], &path.nodes[c]}, pass.weight_angle}),
                             nullptr, &offset[a], &offset[b], &offset[c]);
  });
}

}  // namespace

NloPath resample_for_nlo(const RoadPath& path, double spacing_m) {
  NloPath result;
  const auto add = [&](Vec2 p, std::int64_t osm_node, double width_m) {
    NloNode node{.base = p, .osm_node = osm_node, .width_m = width_m, .own = result.nodes.size()};
    if (!result.nodes.empty()) {
      const std::size_t before = result.nodes.back().own;
      if (distance(result.nodes[before].base, p) < same_place_m)
        node.own = before, node.base = result.nodes[before].base;
    }
    result.nodes.push_back(node);
  };
  const std::vector<RoadNode>& nodes = path.nodes;
  add(nodes.front().p, nodes.front().osm_node, nodes.front().width_m);
  for (std::size_t i = 0; i + 1 < nodes.size(); ++i) {
    const Vec2 a = nodes[i].p, b = nodes[i + 1].p;
    const int steps = std::max(1, static_cast<int>(std::lround(distance(a, b) / spacing_m)));
    for (int k = 1; k < steps; ++k) {
      const double f = static_cast<double>(k) / steps;
      add(a + (b - a) * f, 0, nodes[i].width_m + (nodes[i + 1].width_m - nodes[i].width_m) * f);
    }
    add(b, nodes[i + 1].osm_node, nodes[i + 1].width_m);
  }
  result.closed = result.nodes.back().own != 0 && distance(nodes.front().p, nodes.back().p) < same_place_m &&
                  nodes.front().osm_node == nodes.back().osm_node;
  if (result.closed) {  // all nodes at the end that are at one place
    const std::size_t end = result.nodes.back().own;
    for (NloNode& node : result.nodes)
      if (node.own == end) node.own = 0, node.base = result.nodes.front().base;
  }
  set_normals(result);
  return result;
}

NloFit fit_nlo(const NloPath& path, const LabelMap& labels, const NloRoadsOptions& options) {
  const std::size_t count = path.nodes.size();
  NloFit fit{.offset_m = std::vector<double>(count, 0.0)};
  for (const NloNode& node : path.nodes) fit.width_m.push_back(path.nodes[node.own].width_m);
  const LabelCosts costs = label_costs(labels.classes, options.unlabelled_cost);
  const ClassificationCost::Source source{labels, costs, options.strip_m, options.difference_step_m};

  std::vector<bool> seen(count, false);  // whether the strips of the segment from node i show a label
  for (std::size_t i = 0; i + 1 < count; ++i) {
    const std::size_t a = path.nodes[i].own, b = path.nodes[i + 1].own;
    if (a == b) continue;
    const auto sums =
        ClassificationCost::sums(path.nodes[a], path.nodes[b], source, {0.0, fit.width_m[a], 0.0, fit.width_m[b]});
    seen[i] = sums.context.labelled || sums.boundary.labelled;
  }
  fit.outside_labels = std::none_of(seen.begin(), seen.end(), [](bool s) { return s; });
  if (fit.outside_labels) return fit;

  for (std::size_t k = 0; k < options.passes.size(); ++k) {
    if (k + 1 == options.passes.size() &&
        k > 0) {  // what the last weights say about the input, to compare with its end
      NloFit input = fit;
      std::fill(input.offset_m.begin(), input.offset_m.end(), 0.0);
      for (std::size_t i = 0; i < count; ++i) input.width_m[i] = path.nodes[path.nodes[i].own].width_m;
      Problem problem;
      add_residuals(problem, path, seen, source, options, options.passes[k], input);
      problem.Evaluate({}, &fit.solve.cost_before, nullptr, nullptr, nullptr);
    }
    Problem problem;
    add_residuals(problem, path, seen, source, options, options.passes[k], fit);
    ceres::Solver::Options solver;
    set_solver(solver, options.passes[k].max_iterations);
    ceres::Solver::Summary summary;
    ceres::Solve(solver, &problem, &summary);
    fit.failed = fit.failed || summary.termination_type == ceres::FAILURE;
    fit.solve.converged = summary.termination_type == ceres::CONVERGENCE;
    fit.solve.iterations += std::max(0, static_cast<int>(summary.iterations.size()) - 1);
    if (options.passes.size() == 1) fit.solve.cost_before = summary.initial_cost;
    fit.solve.cost_after = summary.final_cost;
  }
  for (std::size_t i = 0; i < count; ++i)
    fit.offset_m[i] = fit.offset_m[path.nodes[i].own], fit.width_m[i] = fit.width_m[path.nodes[i].own];
  return fit;
}

namespace {
// Sec. 3.4: w_g, w_v, w_e, and the scale of the loss of the last.
constexpr double weight_curvature = 1.2, weight_change = 12.0, weight_stay = 0.2, stay_scale_m = 0.5;

/// weight times the curvature at the middle one of three nodes, 1/m: the angle by the mean length of its segments.
struct CurvatureCost {
  std::array<const NloNode*, 3> nodes;
  double per_m;
  template <typename T>
  [[nodiscard]] T curvature(const T* a, const T* b, const T* c) const {
    const Turn<T> turn = turn_of<T>(nodes, {a, b, c});
    return angle_of<T>(turn.cross, turn.dot) * per_m;
  }
  template <typename T>
  bool operator()(const T* a, const T* b, const T* c, T* residual) const {
    *residual = weight_curvature * curvature(a, b, c);
    return true;
  }
};
struct CurvatureChangeCost {
  CurvatureCost first, second;
  template <typename T>
  bool operator()(const T* a, const T* b, const T* c, const T* d, T* residual) const {
    *residual = weight_change * (second.curvature(b, c, d) - first.curvature(a, b, c));
    return true;
  }
};
struct StayCost {
  double value_m;
  template <typename T>
  bool operator()(const T* offset, T* residual) const {
    *residual = weight_stay * (*offset - value_m);
    return true;
  }
};
}  // namespace

void filter_curvature(const NloPath& path, std::vector<double>& offset_m) {
  struct Bend {
    std::size_t a, b, c;
    CurvatureCost cost;
  };
  std::vector<Bend> bends;
  for_turns(path, [&](std::size_t a, std::size_t b, std::size_t c) {
    const double mean_m =
        0.5 * (distance(path.nodes[a].base, path.nodes[b].base) + distance(path.nodes[b].base, path.nodes[c].base));
    bends.push_back({a, b, c, {{&path.nodes[a], &path.nodes[b], &path.nodes[c]}, 1.0 / mean_m}});
  });
  if (bends.empty()) return;
  ceres::Problem problem;
  double* const o = offset_m.data();
  for (std::size_t i = 0; i < path.nodes.size(); ++i)
    if (path.nodes[i].own == i)
      problem.AddResidualBlock(new ceres::AutoDiffCostFunction<StayCost, 1, 1>(new StayCost{o[i]}),
                               new ceres::CauchyLoss(stay_scale_m), &o[i]);
  for (std::size_t k = 0; k < bends.size(); ++k) {
    const Bend& bend = bends[k];
    problem.AddResidualBlock(new ceres::AutoDiffCostFunction<CurvatureCost, 1, 1, 1, 1>(new CurvatureCost(bend.cost)),
                             nullptr, &o[bend.a], &o[bend.b], &o[bend.c]);
    if (k == 0) continue;
    const Bend& before = bends[k - 1];
    if (before.b != bend.a || before.c != bend.b || before.a == bend.c) continue;
    problem.AddResidualBlock(new ceres::AutoDiffCostFunction<CurvatureChangeCost, 1, 1, 1, 1, 1>(
                                 new CurvatureChangeCost{before.cost, bend.cost}),
                             nullptr, &o[before.a], &o[before.b], &o[bend.b], &o[bend.c]);
  }
  // The ends stay: other paths may begin there.
  if (!path.closed)
    for (const std::size_t end : {std::size_t{0}, path.nodes.back().own}) problem.SetParameterBlockConstant(&o[end]);
  ceres::Solver::Options solver;
  set_solver(solver, 50);
  ceres::Solver::Summary summary;
  ceres::Solve(solver, &problem, &summary);
  for (std::size_t i = 0; i < path.nodes.size(); ++i) o[i] = o[path.nodes[i].own];
}

}  // namespace orthodrive::baselines
