// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/refine/fit_costs.hpp"

#include <ceres/sized_cost_function.h>

#include <algorithm>
#include <cmath>
#include <span>

namespace orthodrive::refine {
namespace {

class ClassificationCost final : public ceres::SizedCostFunction<4, 1, 1, 1, 1> {
 public:
  ClassificationCost(const StripCosts& strips, const CrossProfiles& profiles, std::size_t segment, double weight)
      : strips_(strips), segment_(segment) {
    for (std::size_t r = 0; r < rows_per_segment; ++r) {
      const EdgeEvidence& evidence = profiles.evidence[segment * rows_per_segment + r];
      weight_[r] = {weight * evidence.left / static_cast<double>(rows_per_segment),
                    weight * evidence.right / static_cast<double>(rows_per_segment)};
    }
  }

  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    const double offset_a = *parameters[0], width_a = *parameters[1], offset_b = *parameters[2],
                 width_b = *parameters[3];
    std::fill_n(residuals, 4, 0.0);
    for (int p = 0; jacobians && p < 4; ++p)
      if (jacobians[p]) std::fill_n(jacobians[p], 4, 0.0);
    for (std::size_t r = 0; r < rows_per_segment; ++r) {
      const double f = (static_cast<double>(r) + 0.5) / rows_per_segment;
      const double offset = offset_a + (offset_b - offset_a) * f, half = 0.5 * (width_a + (width_b - width_a) * f);
      for (const auto edge : {StripCosts::Edge::left, StripCosts::Edge::right}) {
        const double side = edge == StripCosts::Edge::left ? 1.0 : -1.0,
                     weight = weight_[r][static_cast<std::size_t>(edge)];
        if (weight == 0.0) continue;
        const StripCosts::Values strips = strips_.at(edge, segment_ * rows_per_segment + r, offset + side * half);
        const auto add = [&](int i, const StripCosts::Value& value) {
          residuals[i] += weight * value.cost;
          if (!jacobians) return;
          const double d = weight * value.derivative;
          const std::array<double, 4> by{d * (1.0 - f), 0.5 * side * d * (1.0 - f), d * f, 0.5 * side * d * f};
          for (int p = 0; p < 4; ++p)
            if (jacobians[p]) jacobians[p][i] += by[p];
        };
        add(static_cast<int>(edge), strips.context);
        add(2 + static_cast<int>(edge), strips.boundary);
      }
    }
    return true;
  }

 private:
  const StripCosts& strips_;
  std::size_t segment_;
  std::array<std::array<double, 2>, rows_per_segment> weight_{};  // of the left and the right edge
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

/// Signed, which makes it differentiable at zero; its square is the reference's.
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

/// Roads are built of arcs and clothoids: their curvature is constant or changes evenly.
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

class NodeShiftCost final : public ceres::SizedCostFunction<1, 2, 1> {
 public:
  NodeShiftCost(Vec2 normal, double expected_m, double weight)
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

class ShiftPriorCost final : public ceres::SizedCostFunction<2, 2> {
 public:
  explicit ShiftPriorCost(double weight) : weight_(weight) {}
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    for (int k = 0; k < 2; ++k) residuals[k] = weight_ * parameters[0][k];
    if (jacobians && jacobians[0]) jacobians[0][0] = jacobians[0][3] = weight_, jacobians[0][1] = jacobians[0][2] = 0.0;
    return true;
  }

 private:
  double weight_;
};

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

}  // namespace

ceres::CostFunction* classification_cost(const StripCosts& strips, const CrossProfiles& profiles, std::size_t segment,
                                         double weight) {
  return new ClassificationCost(strips, profiles, segment, weight);
}
ceres::CostFunction* angle_cost(const std::array<const ChainNode*, 3>& nodes, double weight) {
  return new AngleCost(nodes, weight);
}
ceres::CostFunction* curvature_change_cost(const std::array<const ChainNode*, 4>& nodes, double weight) {
  return new CurvatureChangeCost(nodes, weight);
}
ceres::CostFunction* difference_cost(double weight) { return new DifferenceCost(weight); }
ceres::CostFunction* prior_cost(double value, double sigma) { return new PriorCost(value, sigma); }
ceres::CostFunction* limit_cost(double side, double edge_m, double weight) {
  return new LimitCost(side, edge_m, weight);
}
ceres::CostFunction* shift_prior_cost(double weight) { return new ShiftPriorCost(weight); }
ceres::CostFunction* node_shift_cost(Vec2 normal, double expected_m, double weight) {
  return new NodeShiftCost(normal, expected_m, weight);
}
ceres::CostFunction* trace_cost(Vec2 normal, double told_m, double before_m, double after_m, double sigma_m) {
  return new TraceCost(normal, told_m, before_m, after_m, sigma_m);
}
ceres::CostFunction* trace_drift_cost(double correlation) { return new TraceDriftCost(correlation); }

}  // namespace orthodrive::refine
