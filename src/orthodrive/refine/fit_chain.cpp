#include "orthodrive/refine/fit_chain.hpp"

#include <ceres/ceres.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "orthodrive/core/normal_matrix.hpp"

namespace orthodrive {
namespace {

constexpr double limit_weight = 10.0;  // 1/m
// What near nodes differ from their way by is alike over this length.
constexpr double way_error_length_m = 30.0;
// The error of labels has a part that averages out along a road, in blobs of this length, and two parts that no number of
// nodes averages out: how well an edge can be pointed at, in pixels of the labels, and what the labels take for the edge
// (kerb, shoulder, parked cars), as a share of the width of what is misclassified beside it. The three make the stated
// standard deviations fit the errors on synthetic sites (0.2 m/px) and on the hand-drawn carriageways (0.5 m/px) together.
constexpr double label_blob_m = 4.0;
constexpr double pointing_px = 1.25;
constexpr double edge_bias_share = 0.2;
constexpr double unseen_width_share = 0.08;  // by which a hidden stretch may differ from the rest of its way

/// r_c, eq. 3.3: left and right context strip, left and right boundary strip of a segment.
class ClassificationCost final : public ceres::SizedCostFunction<4, 1, 1, 1, 1> {
 public:
  ClassificationCost(const StripCosts& strips, const CrossProfiles& profiles, std::size_t segment, double weight)
      : strips_(strips), segment_(segment) {
    for (std::size_t r = 0; r < rows_per_segment; ++r)
      weight_[r] = weight * profiles.evidence[segment * rows_per_segment + r] / static_cast<double>(rows_per_segment);
  }

  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    using enum StripCosts::Strip;
    constexpr std::array strips{context_left, context_right, boundary_left, boundary_right};
    const double offset_a = *parameters[0], width_a = *parameters[1], offset_b = *parameters[2],
                 width_b = *parameters[3];
    std::fill_n(residuals, 4, 0.0);
    for (int p = 0; jacobians && p < 4; ++p)
      if (jacobians[p]) std::fill_n(jacobians[p], 4, 0.0);
    for (std::size_t r = 0; r < rows_per_segment; ++r) {
      if (weight_[r] == 0.0) continue;
      const double f = (static_cast<double>(r) + 0.5) / rows_per_segment;
      const double offset = offset_a + (offset_b - offset_a) * f, half = 0.5 * (width_a + (width_b - width_a) * f);
      for (int i = 0; i < 4; ++i) {
        const double side = strips[i] == context_left || strips[i] == boundary_left ? 1.0 : -1.0;
        const auto value = strips_.at(strips[i], segment_ * rows_per_segment + r, offset + side * half);
        residuals[i] += weight_[r] * value.cost;
        if (!jacobians) continue;
        const double d = weight_[r] * value.derivative;
        const std::array<double, 4> by{d * (1.0 - f), 0.5 * side * d * (1.0 - f), d * f, 0.5 * side * d * f};
        for (int p = 0; p < 4; ++p)
          if (jacobians[p]) jacobians[p][i] += by[p];
      }
    }
    return true;
  }

 private:
  const StripCosts& strips_;
  std::size_t segment_;
  std::array<double, rows_per_segment> weight_{};
};

/// Angle between the segments a-b and b-c, signed, and its derivatives by the offsets of the three nodes.
struct Turn {
  double angle_rad = 0.0;
  std::array<double, 3> by_offset{};
};

Turn turn_at(std::span<const Vec2, 3> p, std::span<const Vec2, 3> normal) {
  const Vec2 v1 = p[1] - p[0], v2 = p[2] - p[1];
  // d heading(v) = (v x dv) / |v|^2. Nodes nearly on top of each other must not blow it up.
  const auto turn = [](Vec2 v, Vec2 dv) { return cross(v, dv) / std::max(dot(v, v), 1e-2); };
  return {std::atan2(cross(v1, v2), dot(v1, v2)),
          {turn(v1, normal[0]), -turn(v2, normal[1]) - turn(v1, normal[1]), turn(v2, normal[2])}};
}

/// r_a, eq. 3.8: the angle between two segments by the offsets of their three nodes. Signed, which makes it
/// differentiable at zero; its square is the reference's.
class AngleCost final : public ceres::SizedCostFunction<1, 1, 1, 1> {
 public:
  AngleCost(const std::array<const ChainNode*, 3>& nodes, double weight) : weight_(weight) {
    for (int i = 0; i < 3; ++i) base_[i] = nodes[i]->base, normal_[i] = nodes[i]->normal;
  }
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    std::array<Vec2, 3> p;
    for (int i = 0; i < 3; ++i) p[i] = base_[i] + normal_[i] * *parameters[i];
    const Turn turn = turn_at(p, normal_);
    residuals[0] = weight_ * turn.angle_rad;
    for (int i = 0; jacobians && i < 3; ++i)
      if (jacobians[i]) jacobians[i][0] = weight_ * turn.by_offset[i];
    return true;
  }

 private:
  std::array<Vec2, 3> base_, normal_;
  double weight_;
};

/// r_k: how much the angle changes from one node to the next. Roads are built of arcs and clothoids: their curvature is
/// constant or changes evenly.
class CurvatureChangeCost final : public ceres::SizedCostFunction<1, 1, 1, 1, 1> {
 public:
  CurvatureChangeCost(const std::array<const ChainNode*, 4>& nodes, double weight) : weight_(weight) {
    for (int i = 0; i < 4; ++i) base_[i] = nodes[i]->base, normal_[i] = nodes[i]->normal;
  }
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    std::array<Vec2, 4> p;
    for (int i = 0; i < 4; ++i) p[i] = base_[i] + normal_[i] * *parameters[i];
    const std::span<const Vec2, 4> points(p), normals(normal_);
    const Turn before = turn_at(points.first<3>(), normals.first<3>()),
               after = turn_at(points.last<3>(), normals.last<3>());
    residuals[0] = weight_ * (after.angle_rad - before.angle_rad);
    for (int i = 0; jacobians && i < 4; ++i)
      if (jacobians[i])
        jacobians[i][0] = weight_ * ((i > 0 ? after.by_offset[i - 1] : 0.0) - (i < 3 ? before.by_offset[i] : 0.0));
    return true;
  }

 private:
  std::array<Vec2, 4> base_, normal_;
  double weight_;
};

/// An edge beyond its limit.
class LimitCost final : public ceres::SizedCostFunction<1, 1, 1> {
 public:
  LimitCost(double side, double edge_m, double weight) : side_(side), edge_m_(edge_m), weight_(weight) {}
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    const double beyond_m = side_ * (*parameters[0] - edge_m_) + 0.5 * *parameters[1];
    residuals[0] = weight_ * std::max(0.0, beyond_m);
    if (jacobians && jacobians[0]) jacobians[0][0] = beyond_m > 0.0 ? weight_ * side_ : 0.0;
    if (jacobians && jacobians[1]) jacobians[1][0] = beyond_m > 0.0 ? 0.5 * weight_ : 0.0;
    return true;
  }

 private:
  double side_, edge_m_, weight_;
};

/// r_w and r_o, eq. 3.9 and 3.10.
class DifferenceCost final : public ceres::SizedCostFunction<1, 1, 1> {
 public:
  explicit DifferenceCost(double weight) : weight_(weight) {}
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    residuals[0] = weight_ * (*parameters[1] - *parameters[0]);
    if (jacobians && jacobians[0]) jacobians[0][0] = -weight_;
    if (jacobians && jacobians[1]) jacobians[1][0] = weight_;
    return true;
  }

 private:
  double weight_;
};

/// weight * (offset - expected offset - normal . shift)
class ShiftCost final : public ceres::SizedCostFunction<1, 2, 1> {
 public:
  ShiftCost(Vec2 normal, double expected_m, double weight)
      : normal_(normal), expected_m_(expected_m), weight_(weight) {}
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    residuals[0] = weight_ * (*parameters[1] - expected_m_ - dot(normal_, Vec2{parameters[0][0], parameters[0][1]}));
    if (jacobians && jacobians[0]) jacobians[0][0] = -weight_ * normal_.x, jacobians[0][1] = -weight_ * normal_.y;
    if (jacobians && jacobians[1]) jacobians[1][0] = weight_;
    return true;
  }

 private:
  Vec2 normal_;
  double expected_m_, weight_;
};

/// The shift of a way, in x and y, beyond that of the map around it.
class WayShiftCost final : public ceres::SizedCostFunction<2, 2> {
 public:
  explicit WayShiftCost(double weight) : weight_(weight) {}
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    for (int k = 0; k < 2; ++k) residuals[k] = weight_ * parameters[0][k];
    if (jacobians && jacobians[0]) jacobians[0][0] = jacobians[0][3] = weight_, jacobians[0][1] = jacobians[0][2] = 0.0;
    return true;
  }

 private:
  double weight_;
};

/// (offset - told offset - normal . common error) / sigma of what a trace does by itself. The common error lies between
/// those at the knots before and after, which are in units of their sigmas.
class TraceCost final : public ceres::SizedCostFunction<1, 1, 2, 2> {
 public:
  TraceCost(Vec2 normal, double told_m, double before_m, double after_m, double sigma_m)
      : before_(normal * (before_m / sigma_m)),
        after_(normal * (after_m / sigma_m)),
        told_m_(told_m),
        weight_(1.0 / sigma_m) {}
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    residuals[0] = weight_ * (*parameters[0] - told_m_) - dot(before_, Vec2{parameters[1][0], parameters[1][1]}) -
                   dot(after_, Vec2{parameters[2][0], parameters[2][1]});
    if (jacobians && jacobians[0]) jacobians[0][0] = weight_;
    if (jacobians && jacobians[1]) jacobians[1][0] = -before_.x, jacobians[1][1] = -before_.y;
    if (jacobians && jacobians[2]) jacobians[2][0] = -after_.x, jacobians[2][1] = -after_.y;
    return true;
  }

 private:
  Vec2 before_, after_;
  double told_m_, weight_;
};

/// The error at one knot by that of the knot before: a Gauss-Markov process of unit variance.
class TraceDriftCost final : public ceres::SizedCostFunction<2, 2, 2> {
 public:
  explicit TraceDriftCost(double correlation)
      : correlation_(correlation), weight_(1.0 / std::sqrt(1.0 - correlation * correlation)) {}
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    for (int k = 0; k < 2; ++k) residuals[k] = weight_ * (parameters[1][k] - correlation_ * parameters[0][k]);
    for (int p = 0; jacobians && p < 2; ++p)
      if (jacobians[p]) {
        jacobians[p][0] = jacobians[p][3] = p == 0 ? -weight_ * correlation_ : weight_;
        jacobians[p][1] = jacobians[p][2] = 0.0;
      }
    return true;
  }

 private:
  double correlation_, weight_;
};

class PriorCost final : public ceres::SizedCostFunction<1, 1> {
 public:
  PriorCost(double value, double sigma) : value_(value), weight_(1.0 / sigma) {}
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    residuals[0] = weight_ * (*parameters[0] - value_);
    if (jacobians && jacobians[0]) jacobians[0][0] = weight_;
    return true;
  }

 private:
  double value_, weight_;
};

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

/// Residual blocks by what their weight is: `scaled` ones are only known against each other, `priors` have the weight 1
/// / sigma.
struct Blocks {
  std::vector<ceres::ResidualBlockId> classes;  // also in `scaled`
  std::vector<ceres::ResidualBlockId> scaled, priors;
};

/// The common error of the traces along a chain, in x and y, at even distances. A receiver errs slowly: within some
/// hundred metres all is shifted alike, so that the shape of a trace is better than its place, and a stretch where the
/// road is seen tells the error where it is hidden.
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
      const auto [knot, f] = place(i);
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
    priors.push_back(problem.AddResidualBlock(new WayShiftCost(1.0), nullptr, knots_.front().data()));
    for (std::size_t k = 0; k + 1 < knots_.size(); ++k)
      priors.push_back(problem.AddResidualBlock(new TraceDriftCost(std::exp(-knot_m_ / drift_m)), nullptr,
                                                knots_[k].data(), knots_[k + 1].data()));
    for (std::size_t i = 0; i < (chain_.closed ? traces_.size() - 1 : traces_.size()); ++i) {
      if (traces_[i].recordings <= 0.0) continue;
      const auto [knot, f] = place(i);
      priors.push_back(problem.AddResidualBlock(
          new TraceCost(chain_.nodes[i].normal, traces_[i].offset_m, (1.0 - f) * sigmas_m_[knot],
                        f * sigmas_m_[knot + 1],
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

  struct Place {
    std::size_t knot;
    double fraction;
  };
  [[nodiscard]] Place place(std::size_t node) const {
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

}  // namespace

ChainFit fit_chain(const RoadChain& chain, const CrossProfiles& profiles, const ChainShape& start,
                   const ChainCoupling& coupling, const RefineRoadsOptions& options) {
  ChainFit fit{.shape = start};
  const RefineWeights& weights = options.weights;
  const std::size_t count = chain.nodes.size(), last = count - 1;
  std::vector<double>&offset = fit.shape.offset_m, &width = fit.shape.width_m;
  const auto own = [&](std::size_t i) {
    return chain.closed && i == last ? 0 : i;
  };  // a closed chain's last node is its first
  const StripCosts strips(profiles, options.strip_m);

  ceres::Problem problem;
  std::vector<double*> parameters;
  for (std::size_t i = 0; i < count - (chain.closed ? 1 : 0); ++i) {
    const double w0 = chain.nodes[i].input_width_m, low = options.min_width_factor * w0,
                 high = options.max_width_factor * w0;
    const auto [right_m, left_m] = offset_bounds(chain, i, options.search_radius_m);
    offset[i] = std::clamp(offset[i], right_m, left_m);
    width[i] = std::clamp(width[i], low, high);
    problem.AddParameterBlock(&offset[i], 1);
    problem.AddParameterBlock(&width[i], 1);
    problem.SetParameterLowerBound(&offset[i], 0, right_m);
    problem.SetParameterUpperBound(&offset[i], 0, left_m);
    problem.SetParameterLowerBound(&width[i], 0, low);
    problem.SetParameterUpperBound(&width[i], 0, high);
    parameters.insert(parameters.end(), {&offset[i], &width[i]});
  }
  // A whole way is shifted, and its nodes err around that. Likewise a way has a width, and its nodes differ from that a
  // little. So a hidden stretch takes the shift and the width of what is seen of its way. Errors of near nodes are not
  // independent: each counts for its share of the length of a blob.
  const double share = std::sqrt(std::min(1.0, options.spacing_m / way_error_length_m));
  Blocks blocks;
  const auto expected_at = [&](std::size_t i) {
    return coupling.expected.empty() ? ExpectedOffset{} : coupling.expected[i];
  };
  std::vector<double> way_width(chain.pieces.size());
  std::vector<std::array<double, 2>> way_shift(chain.pieces.size());
  for (std::size_t k = 0; k < chain.pieces.size(); ++k) {
    const ChainPiece& piece = chain.pieces[k];
    const ChainNode& node = chain.nodes[piece.first];
    for (std::size_t i = piece.first; i <= piece.last; ++i)
      way_width[k] += width[own(i)] / static_cast<double>(piece.last - piece.first + 1);
    blocks.priors.push_back(problem.AddResidualBlock(
        new PriorCost(node.input_width_m, weights.input_width * node.width_sigma_m), nullptr, &way_width[k]));
    double map_variance_m2 = 0.0;  // what is not known of the map's shift is left to the way
    for (std::size_t i = piece.first; i <= piece.last; ++i)
      map_variance_m2 += std::pow(expected_at(i).sigma_m, 2) / static_cast<double>(piece.last - piece.first + 1);
    blocks.priors.push_back(
        problem.AddResidualBlock(new WayShiftCost(1.0 / std::sqrt(std::pow(weights.way_shift_m, 2) + map_variance_m2)),
                                 nullptr, way_shift[k].data()));
    for (std::size_t i = k == 0 ? piece.first : piece.first + 1; i <= piece.last;
         ++i) {  // a node between ways is of the first
      if (own(i) != i) continue;
      blocks.priors.push_back(
          problem.AddResidualBlock(new DifferenceCost(share / (weights.node_width_share * node.input_width_m)), nullptr,
                                   &way_width[k], &width[i]));
      blocks.priors.push_back(problem.AddResidualBlock(
          new ShiftCost(chain.nodes[i].normal, expected_at(i).offset_m, share / weights.node_shift_m), nullptr,
          way_shift[k].data(), &offset[i]));
    }
  }
  for (double& w : way_width) parameters.push_back(&w);
  for (auto& shift : way_shift) parameters.push_back(shift.data());
  TraceErrors trace_errors(chain, coupling.traces);
  trace_errors.add_to(problem, offset, share, parameters, blocks.priors);
  for (const auto& [node, offset_m, sigma_m] : coupling.meetings)
    blocks.priors.push_back(problem.AddResidualBlock(new PriorCost(offset_m, sigma_m), nullptr, &offset[own(node)]));
  for (const auto& [node, side, edge_m] : coupling.limits)
    blocks.priors.push_back(problem.AddResidualBlock(new LimitCost(side, edge_m, limit_weight), nullptr,
                                                     &offset[own(node)], &width[own(node)]));
  double evidence_rows = 0.0;
  for (std::size_t i = 0; i < last; ++i) {
    const std::size_t a = own(i), b = own(i + 1);
    if (a == b) continue;
    double evidence = 0.0;
    for (std::size_t r = 0; r < rows_per_segment; ++r) evidence += profiles.evidence[i * rows_per_segment + r];
    if (evidence > 0.0) {
      blocks.classes.push_back(problem.AddResidualBlock(new ClassificationCost(strips, profiles, i, weights.evidence),
                                                        new ceres::CauchyLoss(weights.loss_scale), &offset[a],
                                                        &width[a], &offset[b], &width[b]));
      evidence_rows += evidence;
    }
    blocks.scaled.push_back(problem.AddResidualBlock(new DifferenceCost(weights.width), nullptr, &width[a], &width[b]));
    blocks.scaled.push_back(
        problem.AddResidualBlock(new DifferenceCost(weights.offset), nullptr, &offset[a], &offset[b]));
  }
  // Angles at inner nodes, all the way round where the chain is closed.
  const std::size_t around = chain.closed ? last : count;
  const auto node_at = [&](std::size_t i) { return i % around; };
  const auto pointers = [&]<std::size_t N>(std::array<const ChainNode*, N>& nodes, std::array<double*, N>& offsets,
                                           std::size_t first) {
    for (std::size_t k = 0; k < N; ++k)
      nodes[k] = &chain.nodes[node_at(first + k)], offsets[k] = &offset[node_at(first + k)];
  };
  const auto starts = [&](std::size_t n) { return around < n ? 0 : chain.closed ? around : around - n + 1; };
  for (std::size_t i = 0; i < starts(3); ++i) {
    std::array<const ChainNode*, 3> nodes;
    std::array<double*, 3> offsets;
    pointers(nodes, offsets, i);
    blocks.scaled.push_back(
        problem.AddResidualBlock(new AngleCost(nodes, weights.angle), nullptr, offsets[0], offsets[1], offsets[2]));
  }
  for (std::size_t i = 0; i < starts(4); ++i) {
    std::array<const ChainNode*, 4> nodes;
    std::array<double*, 4> offsets;
    pointers(nodes, offsets, i);
    blocks.scaled.push_back(problem.AddResidualBlock(new CurvatureChangeCost(nodes, weights.curvature), nullptr,
                                                     offsets[0], offsets[1], offsets[2], offsets[3]));
  }

  ceres::Solver::Options solver;
  solver.minimizer_type = ceres::TRUST_REGION;
  solver.trust_region_strategy_type = ceres::LEVENBERG_MARQUARDT;
  solver.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  solver.sparse_linear_algebra_library_type =
      ceres::EIGEN_SPARSE;  // no BLAS, so no threads and no run to run differences
  solver.max_num_iterations = options.max_iterations;
  solver.function_tolerance = 1e-7;
  solver.num_threads = 1;
  solver.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(solver, &problem, &summary);
  fit.solve = {summary.termination_type == ceres::CONVERGENCE, static_cast<int>(summary.iterations.size()) - 1,
               summary.initial_cost, summary.final_cost};

  // Even perfect labels leave an edge uncertain by the quantisation of their pixels.
  const double pixel_m = 2.0 * profiles.step_m;
  const double floor_residual = weights.evidence / options.strip_m * pixel_m / std::sqrt(12.0);
  blocks.scaled.insert(blocks.scaled.end(), blocks.classes.begin(), blocks.classes.end());
  const Sigmas sigmas = estimate_sigmas(problem, parameters, blocks, evidence_rows, floor_residual, options.spacing_m);
  const double pointing_m = pointing_px * pixel_m;
  const double edge_bias_m = edge_bias_share * options.strip_m * sigmas.class_residual / weights.evidence;
  const double edge_m = std::hypot(pointing_m, edge_bias_m);
  const auto seen = [&](std::size_t i) { return profiles.evidence[std::min(i, last - 1) * rows_per_segment] > 0.0F; };
  fit.sigma_offset_m.resize(count), fit.sigma_width_m.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    fit.sigma_offset_m[i] = std::hypot(sigmas.of_parameters[2 * own(i)], pointing_m / std::sqrt(2.0));
    const double unseen_m = seen(i) ? 0.0 : unseen_width_share * width[own(i)];
    fit.sigma_width_m[i] = std::hypot(sigmas.of_parameters[2 * own(i) + 1], std::sqrt(2.0) * edge_m, unseen_m);
  }
  if (chain.closed) offset[last] = offset[0], width[last] = width[0];
  return fit;
}

}  // namespace orthodrive
