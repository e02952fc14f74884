// SPDX-License-Identifier: Apache-2.0
#pragma once
// Robust least squares whose residuals are all linear in the unknowns, as heights make them: sparse Newton steps with a
// line search. Where the loss is not convex, a tenth of the reweighted (majorising) curvature keeps the step a descent.
//
// Cauchy rows: Hampel et al., Robust Statistics, 1986.
// Bounds are one-sided Huber rows: quadratic up to `slack` beyond the bound, then with the constant force weight *
// slack, an exact penalty that holds the bound until what pulls at it is stronger (Nocedal and Wright, Numerical
// Optimization, 17.2).

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "orthodrive/math/normal_matrix.hpp"

namespace orthodrive {

struct Term {
  int unknown = 0;
  double factor = 0.0;
};

class RobustFit {
 public:
  explicit RobustFit(std::size_t unknowns) : unknowns_(unknowns) {}

  /// All rows: v = sum factor * x. An unknown may come twice. Weights are inverse variances.
  /// weight (v - target)^2 / 2
  void add_square(std::span<const Term> terms, double target, double weight);
  /// weight c^2 log(1 + (v - target)^2 / c^2) / 2, c = scale in the unit of v
  void add_cauchy(std::span<const Term> terms, double target, double weight, double scale);
  /// Nothing within [low, high]; e beyond it weight e^2 / 2 up to e = slack, then growing with weight * slack.
  void add_bounds(std::span<const Term> terms, double low, double high, double weight, double slack);

  struct Summary {
    bool converged = false;
    int iterations = 0;
    double cost_before = 0.0, cost_after = 0.0;
  };
  /// Descends from `x` to the minimum nearby. Converged: the largest step below `step_tolerance`.
  Summary solve(std::vector<double>& x, int max_iterations, double step_tolerance) const;

  /// Rows with their present weights (bounds only where they act), whose normal matrix says how sure x is.
  [[nodiscard]] SparseJacobian weighted_rows(const std::vector<double>& x) const;

 private:
  enum class Kind : std::uint8_t { square, cauchy, bounds };
  struct Row {
    Kind kind = Kind::square;
    double low = 0.0, high = 0.0;  // low = target of square and cauchy
    double weight = 0.0, scale = 0.0;
  };
  struct Pull {
    double cost = 0.0, force = 0.0;  // value and derivative by v
    double weight = 0.0;             // of the square with the same force: what the row is worth as an observation
    double bend = 0.0;               // second derivative, kept positive
  };
  void add(std::span<const Term> terms, const Row& row);
  [[nodiscard]] static Pull pull(const Row& row, double v, double softness);
  [[nodiscard]] double value(std::size_t row, const std::vector<double>& x) const;
  [[nodiscard]] double cost(const std::vector<double>& x, double softness) const;
  /// `softness` widens the slack of all bounds, with the same force.
  Summary descend(std::vector<double>& x, int max_iterations, double step_tolerance, double softness) const;

  std::size_t unknowns_;
  std::vector<Row> rows_;
  std::vector<std::size_t> start_{0};
  std::vector<Term> terms_;  // of all rows, unknowns ascending within a row
};

}  // namespace orthodrive
