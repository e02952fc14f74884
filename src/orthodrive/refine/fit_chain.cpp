// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/refine/fit_chain.hpp"

#include <ceres/ceres.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "orthodrive/math/normal_matrix.hpp"
#include "orthodrive/refine/fit_costs.hpp"

namespace orthodrive::refine {
namespace {

constexpr double limit_weight = 10.0;  // 1/m
// Within this length the offsets and widths of nodes differ from those of their way by one common error.
constexpr double way_error_length_m = 30.0;
// The error of labels has three parts. One averages out along a road, in blobs of a given length. Two do not, however
// many nodes there are: how exactly an edge can be pointed at; and what the labels take for the edge (kerb, shoulder,
// parked cars), as a share of the misclassified width beside it. An edge can be pointed at by some pixels of the labels
// at best; where the band in which road and the rest are both likely is wider, by its square. Fitted on Kvarnbyn's
// drawn carriageways and on village 99.
constexpr double label_blob_m = 4.0;
constexpr double pointing_px = 1.25, pointing_of_soft_1pm = 0.62;
constexpr double soft_reach_m = 2.0, soft_along_m = 8.0;  // what is looked at beside an edge, and along it
constexpr double edge_bias_share = 0.2;
constexpr double seen_outlier_sigmas = 2.0;
constexpr double hidden_reach_m = 10.0;      // a gap between seen stretches that is shorter than twice this is bridged
constexpr double unseen_width_share = 0.08;  // by which a hidden stretch may differ from the rest of its way

/// Of the offset of one node.
struct OffsetBounds {
  double right_m, left_m;
};

/// The search radius; inside a bend not so far that neighbours come closer than 40 % of their distance.
OffsetBounds offset_bounds(const RoadChain& chain, std::size_t i, double search_radius_m) {
  constexpr double least_stretch = 0.4;
  OffsetBounds bounds{-search_radius_m, search_radius_m};
  for (std::size_t k = i > 0 ? i - 1 : 0; k < std::min(i + 1, chain.nodes.size() - 1); ++k) {
    const ChainNode &a = chain.nodes[k], &b = chain.nodes[k + 1];
    const double turn = std::atan2(cross(a.normal, b.normal), dot(a.normal, b.normal)),
                 run_m = std::max(0.1, distance(a.base, b.base));
    if (turn > 0.0) bounds.left_m = std::min(bounds.left_m, (1.0 - least_stretch) * run_m / turn);
    if (turn < 0.0) bounds.right_m = std::max(bounds.right_m, (1.0 - least_stretch) * run_m / turn);
  }
  return bounds;
}

/// Residual blocks by the meaning of their weights: those of `scaled` are known relative to each other only, those of
/// `priors` are 1 / sigma.
struct Blocks {
  std::vector<ceres::ResidualBlockId> classes;  // also in `scaled`
  std::vector<ceres::ResidualBlockId> scaled, priors;
};

/// The common error of the traces along a chain, in x and y, at knots in even distances. The error of a receiver
/// changes slowly: within some hundred metres all positions are shifted alike. So the shape of a trace is better than
/// its place, and where the labels show the road they calibrate the traces for the hidden stretches beside.
class TraceErrors {
 public:
  TraceErrors(const RoadChain& chain, const std::vector<TraceOffset>& traces) : chain_(chain), traces_(traces) {
    if (traces.empty()) return;
    const double length_m = std::max(1e-3, chain.nodes.back().s_m);
    const auto intervals = static_cast<std::size_t>(std::ceil(length_m / knot_distance_m));
    knot_m_ = length_m / static_cast<double>(intervals);
    knots_.resize(intervals + 1);
    sigmas_m_.resize(intervals + 1);
    std::vector<double> weights(intervals + 1, 0.0);
    double largest_m = 0.0;
    for (std::size_t i = 0; i < traces.size(); ++i) {
      if (traces[i].recordings <= 0.0) continue;
      const auto [knot, f] = between_knots(i);
      for (const auto& [k, weight] : {std::pair{knot, 1.0 - f}, {knot + 1, f}})
        sigmas_m_[k] += weight * traces[i].sigma_m, weights[k] += weight;
      largest_m = std::max(largest_m, traces[i].sigma_m);
    }
    for (std::size_t k = 0; k < knots_.size(); ++k)
      sigmas_m_[k] = weights[k] > 0.0 ? sigmas_m_[k] / weights[k] : largest_m;
  }

  void add_to(ceres::Problem& problem, std::vector<double>& offset_m, double share, std::vector<double*>& parameters,
              std::vector<ceres::ResidualBlockId>& priors) {
    if (traces_.empty()) return;
    for (auto& knot : knots_) parameters.push_back(knot.data());
    priors.push_back(problem.AddResidualBlock(shift_prior_cost(1.0), nullptr, knots_.front().data()));
    for (std::size_t k = 0; k + 1 < knots_.size(); ++k)
      priors.push_back(problem.AddResidualBlock(trace_drift_cost(std::exp(-knot_m_ / drift_m)), nullptr,
                                                knots_[k].data(), knots_[k + 1].data()));
    for (std::size_t i = 0; i < (chain_.closed ? traces_.size() - 1 : traces_.size()); ++i) {
      if (traces_[i].recordings <= 0.0) continue;
      const auto [knot, f] = between_knots(i);
      priors.push_back(problem.AddResidualBlock(
          trace_cost(chain_.nodes[i].normal, traces_[i].offset_m, (1.0 - f) * sigmas_m_[knot], f * sigmas_m_[knot + 1],
                     std::hypot(driver_sigma_m, jitter_sigma_m / std::sqrt(traces_[i].recordings))),
          new ceres::ScaledLoss(new ceres::CauchyLoss(outlier_sigmas), share * share, ceres::TAKE_OWNERSHIP),
          &offset_m[i], knots_[knot].data(), knots_[knot + 1].data()));
    }
  }

 private:
  static constexpr double knot_distance_m = 300.0;
  static constexpr double drift_m = 1000.0;      // a minute or two of driving
  static constexpr double jitter_sigma_m = 0.8;  // of a trace around its slow error
  static constexpr double driver_sigma_m = 0.4;  // all cut the same bend
  static constexpr double outlier_sigmas = 2.0;

  /// Where a node lies between two knots.
  struct BetweenKnots {
    std::size_t knot;
    double fraction;
  };
  [[nodiscard]] BetweenKnots between_knots(std::size_t node) const {
    const double x = chain_.nodes[node].s_m / knot_m_;
    const std::size_t knot = std::min(static_cast<std::size_t>(x), knots_.size() - 2);
    return {knot, x - static_cast<double>(knot)};
  }

  const RoadChain& chain_;
  const std::vector<TraceOffset>& traces_;
  double knot_m_ = 0.0;
  std::vector<std::array<double, 2>> knots_;
  std::vector<double> sigmas_m_;
};

struct Sigmas {
  std::vector<double> of_parameters;
  double class_residual = 0.0;  ///< root mean square, outliers as they are
};

/// Standard deviations from the normal matrix; the variance of what is scaled comes from the residuals of the classes.
Sigmas estimate_sigmas(ceres::Problem& problem, const std::vector<double*>& parameters, const Blocks& blocks,
                       double evidence_rows, double floor_residual, double spacing_m) {
  ceres::Problem::EvaluateOptions evaluate;
  const auto class_residual = [&](bool robust) {
    if (blocks.classes.empty()) return 0.0;
    std::vector<double> residuals;
    evaluate.residual_blocks = blocks.classes;
    evaluate.apply_loss_function = robust;
    problem.Evaluate(evaluate, nullptr, &residuals, nullptr, nullptr);
    double sum = 0.0;
    for (const double r : residuals) sum += r * r;
    return std::sqrt(sum / evidence_rows);  // each segment with evidence measures two edges
  };
  Sigmas sigmas{.class_residual = class_residual(false)};
  const double variance =
      std::pow(std::max(floor_residual, class_residual(true)), 2) * std::max(1.0, label_blob_m / spacing_m);
  evaluate.residual_blocks = blocks.scaled;
  evaluate.residual_blocks.insert(evaluate.residual_blocks.end(), blocks.priors.begin(), blocks.priors.end());
  evaluate.parameter_blocks = parameters;
  ceres::CRSMatrix jacobian;
  problem.Evaluate(evaluate, nullptr, nullptr, nullptr, &jacobian);
  std::size_t scaled_rows = 0;
  for (const ceres::ResidualBlockId block : blocks.scaled)
    scaled_rows += static_cast<std::size_t>(problem.GetCostFunctionForResidualBlock(block)->num_residuals());
  const auto scaled_values = static_cast<std::size_t>(jacobian.rows[scaled_rows]);
  for (std::size_t k = 0; k < scaled_values; ++k) jacobian.values[k] /= std::sqrt(variance);
  sigmas.of_parameters = inverse_normal_diagonal(
      {jacobian.num_cols, std::move(jacobian.rows), std::move(jacobian.cols), std::move(jacobian.values)});
  for (double& s : sigmas.of_parameters) s = std::sqrt(s);
  return sigmas;
}

/// The least-squares problem of one chain, built step by step. Residual blocks are added in a fixed order, because sums
/// over them run in it.
class ChainProblem {
 public:
  ChainProblem(const RoadChain& chain, const CrossProfiles& profiles, const ChainShape& start,
               const ChainCoupling& coupling, const RefineRoadsOptions& options)
      : chain_(chain),
        profiles_(profiles),
        coupling_(coupling),
        options_(options),
        weights_(options.weights),
        count_(chain.nodes.size()),
        last_(count_ - 1),
        node_share_(std::sqrt(std::min(1.0, options.spacing_m / way_error_length_m))),
        fit_{.shape = start},
        way_width_(chain.pieces.size()),
        way_shift_(chain.pieces.size()),
        trace_errors_(chain, coupling.traces),
        strips_(profiles, options.strip_m) {}

  /// Offset and width of every node, within their bounds.
  void add_unknowns() {
    for (std::size_t i = 0; i < count_ - (chain_.closed ? 1 : 0); ++i) {
      const double w0 = chain_.nodes[i].input_width_m, low = options_.min_width_factor * w0,
                   high = max_width_factor(chain_.nodes[i], options_) * w0;
      const auto [right_m, left_m] = offset_bounds(chain_, i, options_.search_radius_m);
      offset_[i] = std::clamp(offset_[i], right_m, left_m);
      width_[i] = std::clamp(width_[i], low, high);
      problem_.AddParameterBlock(&offset_[i], 1);
      problem_.AddParameterBlock(&width_[i], 1);
      problem_.SetParameterLowerBound(&offset_[i], 0, right_m);
      problem_.SetParameterUpperBound(&offset_[i], 0, left_m);
      problem_.SetParameterLowerBound(&width_[i], 0, low);
      problem_.SetParameterUpperBound(&width_[i], 0, high);
      parameters_.insert(parameters_.end(), {&offset_[i], &width_[i]});
    }
  }

  /// A whole way is shifted, and its nodes scatter around that shift; likewise a way has a width, and its nodes differ
  /// from it a little. So a hidden stretch takes the shift and the width of the visible rest of its way.
  void add_way_priors() {
    for (std::size_t k = 0; k < chain_.pieces.size(); ++k) {
      const ChainPiece& piece = chain_.pieces[k];
      const ChainNode& node = chain_.nodes[piece.first];
      for (std::size_t i = piece.first; i <= piece.last; ++i)
        way_width_[k] += width_[own(i)] / static_cast<double>(piece.last - piece.first + 1);
      add_prior(prior_cost(node.input_width_m, weights_.input_width * node.width_sigma_m), &way_width_[k]);
      double map_variance_m2 = 0.0;  // the uncertainty of the map's shift is left to the way
      for (std::size_t i = piece.first; i <= piece.last; ++i)
        map_variance_m2 += std::pow(expected_at(i).sigma_m, 2) / static_cast<double>(piece.last - piece.first + 1);
      add_prior(shift_prior_cost(1.0 / std::sqrt(std::pow(weights_.way_shift_m, 2) + map_variance_m2)),
                way_shift_[k].data());
      for (std::size_t i = k == 0 ? piece.first : piece.first + 1; i <= piece.last; ++i) {  // shared: of the first way
        if (own(i) != i) continue;
        // Only who is seen elsewhere was put in a wrong place, and only who is seen may be of another width than the
        // rest of its way: smoothness alone must not cut a hidden bend.
        const auto loss = [&, hidden = is_hidden(i)] {
          return new ceres::ScaledLoss(hidden ? nullptr : new ceres::CauchyLoss(weights_.misplaced_sigmas),
                                       node_share_ * node_share_, ceres::TAKE_OWNERSHIP);
        };
        add_robust_prior(difference_cost(1.0 / (weights_.node_width_share * node.input_width_m)), loss(),
                         &way_width_[k], &width_[i]);
        add_robust_prior(node_shift_cost(chain_.nodes[i].normal, expected_at(i).offset_m, 1.0 / weights_.node_shift_m),
                         loss(), way_shift_[k].data(), &offset_[i]);
      }
    }
    for (double& w : way_width_) parameters_.push_back(&w);
    for (auto& shift : way_shift_) parameters_.push_back(shift.data());
  }

  /// Where the network sees the road, GPS traces, junctions to pass through, borders to parallel roads.
  void add_coupling() {
    for (std::size_t i = 0; i < coupling_.seen.size(); ++i) {
      const SeenPlace& seen = coupling_.seen[i];
      if (own(i) != i || seen.sigma_m <= 0.0) continue;
      // Its errors change slowly along a road: nodes within a way's error length count as one.
      const auto add = [&](double value, double sigma, double* unknown) {
        blocks_.priors.push_back(
            problem_.AddResidualBlock(prior_cost(value, sigma),
                                      new ceres::ScaledLoss(new ceres::CauchyLoss(seen_outlier_sigmas),
                                                            node_share_ * node_share_, ceres::TAKE_OWNERSHIP),
                                      unknown));
      };
      add(seen.offset_m, seen.sigma_m, &offset_[i]);
      add(seen.width_m, seen.sigma_width_m, &width_[i]);
    }
    trace_errors_.add_to(problem_, offset_, node_share_, parameters_, blocks_.priors);
    for (const auto& [node, offset_m, sigma_m] : coupling_.meetings)
      add_prior(prior_cost(offset_m, sigma_m), &offset_[own(node)]);
    for (const auto& [node, side, edge_m] : coupling_.limits)
      add_prior(limit_cost(side, edge_m, limit_weight), &offset_[own(node)], &width_[own(node)]);
  }

  /// For every segment what the labels show, and that width and offset change little along it.
  void add_segments() {
    for (std::size_t i = 0; i < last_; ++i) {
      const std::size_t a = own(i), b = own(i + 1);
      if (a == b) continue;
      double evidence = 0.0;
      for (std::size_t r = 0; r < rows_per_segment; ++r)
        evidence += profiles_.evidence[i * rows_per_segment + r].mean();
      if (evidence > 0.0) {
        blocks_.classes.push_back(problem_.AddResidualBlock(
            classification_cost(strips_, profiles_, i, weights_.evidence), new ceres::CauchyLoss(weights_.loss_scale),
            &offset_[a], &width_[a], &offset_[b], &width_[b]));
        evidence_rows_ += evidence;
      }
      add_scaled(difference_cost(weights_.width), &width_[a], &width_[b]);
      add_scaled(difference_cost(weights_.offset), &offset_[a], &offset_[b]);
    }
  }

  /// Angles and their changes at inner nodes, all the way round where the chain is closed.
  void add_smoothness() {
    for (std::size_t i = 0; i < windows(3); ++i) {
      const auto [nodes, offsets] = window<3>(i);
      add_scaled(angle_cost(nodes, weights_.angle), offsets[0], offsets[1], offsets[2]);
    }
    for (std::size_t i = 0; i < windows(4); ++i) {
      const auto [nodes, offsets] = window<4>(i);
      add_scaled(curvature_change_cost(nodes, weights_.curvature), offsets[0], offsets[1], offsets[2], offsets[3]);
    }
  }

  void solve() {
    ceres::Solver::Options solver;
    solver.minimizer_type = ceres::TRUST_REGION;
    solver.trust_region_strategy_type = ceres::LEVENBERG_MARQUARDT;
    solver.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
    solver.sparse_linear_algebra_library_type =
        ceres::EIGEN_SPARSE;  // no BLAS, so no threads and no run to run differences
    solver.max_num_iterations = options_.max_iterations;
    solver.function_tolerance = 1e-7;
    solver.num_threads = 1;
    solver.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    ceres::Solve(solver, &problem_, &summary);
    fit_.solve = {summary.termination_type == ceres::CONVERGENCE, static_cast<int>(summary.iterations.size()) - 1,
                  summary.initial_cost, summary.final_cost};
  }

  /// Standard deviations: of the solution, of pointing at an edge, of what the labels take for the edge.
  void add_sigmas() {
    const double pixel_m = 2.0 * profiles_.step_m;
    // Even perfect labels leave an edge uncertain by the quantisation of their pixels.
    const double floor_residual = weights_.evidence / options_.strip_m * pixel_m / std::sqrt(12.0);
    blocks_.scaled.insert(blocks_.scaled.end(), blocks_.classes.begin(), blocks_.classes.end());
    const Sigmas sigmas =
        estimate_sigmas(problem_, parameters_, blocks_, evidence_rows_, floor_residual, options_.spacing_m);
    const std::vector<double> soft_m = edge_softness_m();
    const double edge_bias_m = edge_bias_share * options_.strip_m * sigmas.class_residual / weights_.evidence;
    fit_.sigma_offset_m.resize(count_), fit_.sigma_width_m.resize(count_);
    for (std::size_t i = 0; i < count_; ++i) {
      const double pointing_m = std::max(pointing_px * pixel_m, pointing_of_soft_1pm * soft_m[i] * soft_m[i]);
      const double edge_m = std::hypot(pointing_m, edge_bias_m);
      fit_.sigma_offset_m[i] = std::hypot(sigmas.of_parameters[2 * own(i)], pointing_m / std::sqrt(2.0));
      const double unseen_m = is_seen(i) ? 0.0 : unseen_width_share * width_[own(i)];
      fit_.sigma_width_m[i] = std::hypot(sigmas.of_parameters[2 * own(i) + 1], std::sqrt(2.0) * edge_m, unseen_m);
    }
  }

  [[nodiscard]] bool is_seen(std::size_t node) const {
    return profiles_.evidence[std::min(node, last_ - 1) * rows_per_segment].both() > 0.0;
  }
  /// Neither edge is seen here, nor within some metres.
  [[nodiscard]] bool is_hidden(std::size_t node) const {
    const auto far = [&](std::size_t i) {
      return std::abs(chain_.nodes[i].s_m - chain_.nodes[node].s_m) > hidden_reach_m;
    };
    const auto seen = [&](std::size_t i) { return profiles_.evidence[i * rows_per_segment].mean() > 0.0; };
    for (std::size_t i = node; i > 0 && !far(i - 1); --i)
      if (seen(i - 1)) return false;
    for (std::size_t i = node; i < last_ && !far(i); ++i)
      if (seen(i)) return false;
    return true;
  }
  /// Of each node: the width of the band at its edges in which road and the rest are both likely, the integral of
  /// 4 p (1 - p) across it, mean of both edges over some metres; 0 where nothing is seen.
  [[nodiscard]] std::vector<double> edge_softness_m() const {
    std::vector<double> of_segment(last_, -1.0);
    for (std::size_t i = 0; i < last_; ++i) {
      double sum = 0.0;
      int edges = 0;
      for (std::size_t row = i * rows_per_segment; row < (i + 1) * rows_per_segment; ++row) {
        const EdgeEvidence& evidence = profiles_.evidence[row];
        for (const auto& [side, counts] : {std::pair{0.5, evidence.left}, {-0.5, evidence.right}})
          if (counts > 0.0) sum += band_m(row, offset_[own(i)] + side * width_[own(i)]), ++edges;
      }
      if (edges > 0) of_segment[i] = sum / edges;
    }
    const auto reach = static_cast<std::size_t>(soft_along_m / options_.spacing_m);
    std::vector<double> soft_m(count_, 0.0);
    for (std::size_t i = 0; i < count_; ++i) {
      double sum = 0.0;
      int seen = 0;
      for (std::size_t k = i > reach ? i - reach : 0; k < std::min(last_, i + reach); ++k)
        if (of_segment[k] >= 0.0) sum += of_segment[k], ++seen;
      if (seen > 0) soft_m[i] = sum / seen;
    }
    return soft_m;
  }

  [[nodiscard]] ChainFit take() {
    if (chain_.closed) offset_[last_] = offset_[0], width_[last_] = width_[0];
    return std::move(fit_);
  }

 private:
  template <typename... Unknowns>
  void add_prior(ceres::CostFunction* cost, Unknowns*... unknowns) {
    add_robust_prior(cost, nullptr, unknowns...);
  }
  template <typename... Unknowns>
  void add_robust_prior(ceres::CostFunction* cost, ceres::LossFunction* loss, Unknowns*... unknowns) {
    blocks_.priors.push_back(problem_.AddResidualBlock(cost, loss, unknowns...));
  }
  template <typename... Unknowns>
  void add_scaled(ceres::CostFunction* cost, Unknowns*... unknowns) {
    blocks_.scaled.push_back(problem_.AddResidualBlock(cost, nullptr, unknowns...));
  }
  /// Across one edge at t.
  [[nodiscard]] double band_m(std::size_t row, double t_m) const {
    const auto outside = profiles_.positive_row(row), inside = profiles_.negative_row(row);
    const auto cell_at = [&](double t) {
      return static_cast<std::size_t>(
          std::clamp((t + profiles_.half_m) / profiles_.step_m, 0.0, static_cast<double>(profiles_.cells)));
    };
    double sum = 0.0;
    for (std::size_t k = cell_at(t_m - soft_reach_m); k < cell_at(t_m + soft_reach_m); ++k)
      sum += 4.0 * static_cast<double>(outside[k]) * static_cast<double>(inside[k]);
    return sum * profiles_.step_m;
  }
  /// A closed chain's last node is its first.
  [[nodiscard]] std::size_t own(std::size_t i) const { return chain_.closed && i == last_ ? 0 : i; }
  [[nodiscard]] ExpectedOffset expected_at(std::size_t i) const {
    return coupling_.expected.empty() ? ExpectedOffset{} : coupling_.expected[i];
  }
  /// N nodes in a row and their offsets.
  template <std::size_t N>
  struct Window {
    std::array<const ChainNode*, N> nodes;
    std::array<double*, N> offsets;
  };
  template <std::size_t N>
  [[nodiscard]] Window<N> window(std::size_t first) {
    Window<N> window;
    for (std::size_t k = 0; k < N; ++k) {
      const std::size_t i = (first + k) % nodes_around();
      window.nodes[k] = &chain_.nodes[i], window.offsets[k] = &offset_[i];
    }
    return window;
  }
  [[nodiscard]] std::size_t nodes_around() const { return chain_.closed ? last_ : count_; }
  [[nodiscard]] std::size_t windows(std::size_t n) const {
    return nodes_around() < n ? 0 : chain_.closed ? nodes_around() : nodes_around() - n + 1;
  }

  const RoadChain& chain_;
  const CrossProfiles& profiles_;
  const ChainCoupling& coupling_;
  const RefineRoadsOptions& options_;
  const RefineWeights& weights_;
  std::size_t count_, last_;
  double node_share_;  // errors of near nodes are not independent: the share of each in a way's error length
  ChainFit fit_;
  std::vector<double>&offset_ = fit_.shape.offset_m, &width_ = fit_.shape.width_m;
  std::vector<double> way_width_;
  std::vector<std::array<double, 2>> way_shift_;
  TraceErrors trace_errors_;
  StripCosts strips_;
  ceres::Problem problem_;
  std::vector<double*> parameters_;
  Blocks blocks_;
  double evidence_rows_ = 0.0;
};

}  // namespace

ChainFit fit_chain(const RoadChain& chain, const CrossProfiles& profiles, const ChainShape& start,
                   const ChainCoupling& coupling, const RefineRoadsOptions& options) {
  ChainProblem problem(chain, profiles, start, coupling, options);
  problem.add_unknowns();
  problem.add_way_priors();
  problem.add_coupling();
  problem.add_segments();
  problem.add_smoothness();
  problem.solve();
  problem.add_sigmas();
  return problem.take();
}

}  // namespace orthodrive::refine
