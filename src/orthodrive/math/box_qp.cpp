// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/math/box_qp.hpp"

#include <algorithm>
#include <cmath>

#include "orthodrive/core/error.hpp"

namespace orthodrive {
namespace {

constexpr int max_rounds = 100;
constexpr double tolerance = 1e-10;       // of the complementarity, relative to that of the start
constexpr double to_boundary = 0.995;     // share of the way to the nearest bound that a step takes
constexpr double diagonal_floor = 1e-12;  // relative: keeps a semidefinite matrix factorable

/// Variables, multipliers of the bounds, and the factor of the matrix of one Newton step.
class InteriorPoint {
 public:
  InteriorPoint(const SymmetricMatrix& hessian, std::span<const double> gradient, std::span<const double> lower,
                std::span<const double> upper)
      : hessian_(hessian), gradient_(gradient), lower_(lower), upper_(upper), n_(gradient.size()) {
    for (std::size_t i = 0; i < n_; ++i) x_.push_back(0.5 * (lower[i] + upper[i]));
    force_ = residual();
    double largest = 1e-12;
    for (const double f : force_) largest = std::max(largest, std::abs(f));
    below_.assign(n_, largest), above_.assign(n_, largest);
    factor_entries_.resize(n_ * (hessian.band + 1));
  }

  /// One predictor-corrector step; false when the multipliers have vanished against the start.
  bool advance() {
    const double now = complementarity();
    if (start_ < 0.0) start_ = now;
    if (!std::isfinite(now)) throw Error("a quadratic program has numbers that are not finite");
    if (now <= tolerance * start_) return false;
    force_ = residual();
    if (!factor()) throw Error("a quadratic program has a matrix that is not positive semidefinite");
    const Step predictor = solve(0.0, nullptr);
    const double reach = longest(predictor), after = complementarity_after(predictor, reach);
    const double centring = std::pow(after / now, 3.0);
    const Step step = solve(centring * now, &predictor);
    const double share = std::min(1.0, to_boundary * longest(step));
    for (std::size_t i = 0; i < n_; ++i) {
      x_[i] += share * step.x[i];
      below_[i] += share * step.below[i], above_[i] += share * step.above[i];
    }
    return true;
  }

  [[nodiscard]] const std::vector<double>& x() const { return x_; }

 private:
  struct Step {
    std::vector<double> x, below, above;
  };

  /// Hx + g.
  [[nodiscard]] std::vector<double> residual() const {
    std::vector<double> r(gradient_.begin(), gradient_.end());
    for (std::size_t i = 0; i < n_; ++i) {
      r[i] += hessian_(i, i) * x_[i];
      for (std::size_t k = i - std::min(i, hessian_.band); k < i; ++k) {
        r[i] += hessian_(i, k) * x_[k];
        r[k] += hessian_(i, k) * x_[i];
      }
    }
    return r;
  }
  [[nodiscard]] double complementarity() const {
    double sum = 0.0;
    for (std::size_t i = 0; i < n_; ++i) sum += below_[i] * (x_[i] - lower_[i]) + above_[i] * (upper_[i] - x_[i]);
    return 0.5 * sum / static_cast<double>(n_);
  }
  [[nodiscard]] double complementarity_after(const Step& step, double share) const {
    double sum = 0.0;
    for (std::size_t i = 0; i < n_; ++i) {
      const double x = x_[i] + share * step.x[i];
      sum +=
          (below_[i] + share * step.below[i]) * (x - lower_[i]) + (above_[i] + share * step.above[i]) * (upper_[i] - x);
    }
    return 0.5 * sum / static_cast<double>(n_);
  }
  bool factor() {
    const SymmetricMatrix m = SymmetricMatrix::banded(factor_entries_, hessian_.band);
    for (std::size_t i = 0; i < n_; ++i) {
      for (std::size_t k = i - std::min(i, hessian_.band); k < i; ++k) m(i, k) = hessian_(i, k);
      m(i, i) =
          hessian_(i, i) * (1.0 + diagonal_floor) + below_[i] / (x_[i] - lower_[i]) + above_[i] / (upper_[i] - x_[i]);
    }
    return factorize(m);
  }
  /// Newton's step towards complementarity `target`, with the predictor's second-order term when there is one.
  [[nodiscard]] Step solve(double target, const Step* predictor) {
    Step step{std::vector<double>(n_), std::vector<double>(n_), std::vector<double>(n_)};
    for (std::size_t i = 0; i < n_; ++i) {
      const double down = x_[i] - lower_[i], up = upper_[i] - x_[i];
      const double second_down = predictor != nullptr ? predictor->x[i] * predictor->below[i] : 0.0;
      const double second_up = predictor != nullptr ? -predictor->x[i] * predictor->above[i] : 0.0;
      step.below[i] = (target - second_down) / down - below_[i];
      step.above[i] = (target - second_up) / up - above_[i];
      step.x[i] = -force_[i] + below_[i] - above_[i] + step.below[i] - step.above[i];
    }
    solve_factored(SymmetricMatrix::banded(factor_entries_, hessian_.band), step.x);
    for (std::size_t i = 0; i < n_; ++i) {
      step.below[i] -= below_[i] / (x_[i] - lower_[i]) * step.x[i];
      step.above[i] += above_[i] / (upper_[i] - x_[i]) * step.x[i];
    }
    return step;
  }
  /// How much of the step keeps everything on its side of 0; at most 1 / to_boundary matters.
  [[nodiscard]] double longest(const Step& step) const {
    double share = 1.0 / to_boundary;
    const auto limit = [&](double value, double change) {
      if (change < 0.0) share = std::min(share, -value / change);
    };
    for (std::size_t i = 0; i < n_; ++i) {
      limit(x_[i] - lower_[i], step.x[i]), limit(upper_[i] - x_[i], -step.x[i]);
      limit(below_[i], step.below[i]), limit(above_[i], step.above[i]);
    }
    return share;
  }

  const SymmetricMatrix& hessian_;
  std::span<const double> gradient_, lower_, upper_;
  std::size_t n_;
  std::vector<double> x_, below_, above_, force_, factor_entries_;
  double start_ = -1.0;
};

}  // namespace

std::vector<double> minimize_in_box(const SymmetricMatrix& hessian, std::span<const double> gradient,
                                    std::span<const double> lower, std::span<const double> upper) {
  if (gradient.empty()) return {};
  InteriorPoint point(hessian, gradient, lower, upper);
  for (int round = 0; round < max_rounds && point.advance();) ++round;
  return point.x();
}

}  // namespace orthodrive
