// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/math/robust_fit.hpp"

#include <Eigen/Sparse>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <cstdint>

#include "orthodrive/core/error.hpp"

namespace orthodrive {

void RobustFit::add(std::span<const Term> terms, const Row& row) {
  const std::size_t begin = terms_.size();
  terms_.insert(terms_.end(), terms.begin(), terms.end());
  const auto first = terms_.begin() + static_cast<std::ptrdiff_t>(begin);
  std::stable_sort(first, terms_.end(), [](const Term& a, const Term& b) { return a.unknown < b.unknown; });
  auto last = first;
  for (auto it = first; it != terms_.end(); ++it) {
    if (it != first && it->unknown == last->unknown)
      last->factor += it->factor;
    else if (it != first)
      *++last = *it;
  }
  if (first != terms_.end()) terms_.erase(last + 1, terms_.end());
  start_.push_back(terms_.size());
  rows_.push_back(row);
}

void RobustFit::add_square(std::span<const Term> terms, double target, double weight) {
  add(terms, {Kind::square, target, target, weight, 0.0});
}
void RobustFit::add_cauchy(std::span<const Term> terms, double target, double weight, double scale) {
  add(terms, {Kind::cauchy, target, target, weight, scale});
}
void RobustFit::add_bounds(std::span<const Term> terms, double low, double high, double weight, double slack) {
  add(terms, {Kind::bounds, low, high, weight, slack});
}

RobustFit::Pull RobustFit::pull(const Row& row, double v, double softness) {
  constexpr double least_bend = 0.1;
  if (row.kind == Kind::square) {
    const double r = v - row.low;
    return {0.5 * row.weight * r * r, row.weight * r, row.weight, row.weight};
  }
  if (row.kind == Kind::cauchy) {
    const double r = v - row.low, c2 = row.scale * row.scale, x2 = r * r / c2, weight = row.weight / (1.0 + x2);
    return {0.5 * row.weight * c2 * std::log1p(x2), weight * r, weight,
            weight * std::max(least_bend, (1.0 - x2) / (1.0 + x2))};
  }
  const double excess = v < row.low ? v - row.low : v > row.high ? v - row.high : 0.0, size = std::abs(excess);
  const double slack = softness * row.scale, stiffness = row.weight / softness;
  if (size <= slack) {
    const double weight = size > 0.0 ? stiffness : 0.0;
    return {0.5 * stiffness * size * size, stiffness * excess, weight, weight};
  }
  const double weight = stiffness * slack / size;
  return {stiffness * slack * (size - 0.5 * slack), weight * excess, weight, least_bend * weight};
}

double RobustFit::value(std::size_t row, const std::vector<double>& x) const {
  double sum = 0.0;
  for (std::size_t k = start_[row]; k < start_[row + 1]; ++k)
    sum += terms_[k].factor * x[static_cast<std::size_t>(terms_[k].unknown)];
  return sum;
}

double RobustFit::cost(const std::vector<double>& x, double softness) const {
  double sum = 0.0;
  for (std::size_t i = 0; i < rows_.size(); ++i) sum += pull(rows_[i], value(i, x), softness).cost;
  return sum;
}

namespace {
using Matrix = Eigen::SparseMatrix<double>;

/// Lower triangle of the normal matrix, with zeros where any row may put something.
Matrix make_pattern(std::size_t unknowns, const std::vector<std::size_t>& start, const std::vector<Term>& terms) {
  std::vector<std::uint64_t> places;  // column, row
  places.reserve(unknowns);
  for (std::size_t i = 0; i < unknowns; ++i) places.push_back((static_cast<std::uint64_t>(i) << 32U) | i);
  std::size_t last = 0;  // row put in last: the next ones mostly have the same unknowns, or some of them
  const auto is_covered = [&](std::size_t row) {
    for (std::size_t a = start[row], b = start[last]; a < start[row + 1]; ++a, ++b) {
      while (b < start[last + 1] && terms[b].unknown < terms[a].unknown) ++b;
      if (b == start[last + 1] || terms[b].unknown != terms[a].unknown) return false;
    }
    return true;
  };
  for (std::size_t row = 0; row + 1 < start.size(); ++row) {
    if (row > 0 && is_covered(row)) continue;
    last = row;
    for (std::size_t a = start[row]; a < start[row + 1]; ++a)
      for (std::size_t b = a + 1; b < start[row + 1]; ++b)
        places.push_back((static_cast<std::uint64_t>(terms[a].unknown) << 32U) |
                         static_cast<std::uint64_t>(terms[b].unknown));
  }
  std::sort(places.begin(), places.end());
  places.erase(std::unique(places.begin(), places.end()), places.end());
  const auto n = static_cast<Eigen::Index>(unknowns);
  Matrix pattern(n, n);
  pattern.resizeNonZeros(static_cast<Eigen::Index>(places.size()));
  std::fill(pattern.outerIndexPtr(), pattern.outerIndexPtr() + n + 1, 0);
  for (std::size_t k = 0; k < places.size(); ++k) {
    ++pattern.outerIndexPtr()[(places[k] >> 32U) + 1];
    pattern.innerIndexPtr()[k] = static_cast<int>(places[k] & 0xffffffffU);
  }
  for (Eigen::Index c = 0; c < n; ++c) pattern.outerIndexPtr()[c + 1] += pattern.outerIndexPtr()[c];
  return pattern;
}

void add_at(Matrix& lower, int row, int column, double value) {
  const int* begin = lower.innerIndexPtr() + lower.outerIndexPtr()[column];
  const int* end = lower.innerIndexPtr() + lower.outerIndexPtr()[column + 1];
  lower.valuePtr()[std::lower_bound(begin, end, row) - lower.innerIndexPtr()] += value;
}
}  // namespace

RobustFit::Summary RobustFit::solve(std::vector<double>& x, int max_iterations, double step_tolerance) const {
  Summary summary = descend(x, max_iterations, step_tolerance, 1.0);
  // Newton's method stalls where a step runs into bounds that it did not see: softer ones are seen from further away.
  for (const double softness : {1000.0, 100.0, 10.0, 1.0}) {
    if (summary.converged && softness == 1000.0) break;
    const Summary next = descend(x, max_iterations, step_tolerance, softness);
    summary.iterations += next.iterations;
    summary.converged = next.converged, summary.cost_after = next.cost_after;
  }
  return summary;
}

RobustFit::Summary RobustFit::descend(std::vector<double>& x, int max_iterations, double step_tolerance,
                                      double softness) const {
  constexpr int max_halvings = 12;
  constexpr double sure_decrease = 1e-4;  // share of the slope's promise (Armijo)
  Matrix normal = make_pattern(unknowns_, start_, terms_);
  Eigen::SimplicialLLT<Matrix, Eigen::Lower> cholesky;
  cholesky.analyzePattern(normal);
  Summary summary{.cost_before = cost(x, softness)};
  summary.cost_after = summary.cost_before;
  Eigen::VectorXd gradient(static_cast<Eigen::Index>(unknowns_));
  std::vector<double> tried(x.size());
  while (summary.iterations < max_iterations && !summary.converged) {
    ++summary.iterations;
    std::fill(normal.valuePtr(), normal.valuePtr() + normal.nonZeros(), 0.0);
    gradient.setZero();
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      const Pull p = pull(rows_[i], value(i, x), softness);
      if (p.bend == 0.0) continue;
      for (std::size_t a = start_[i]; a < start_[i + 1]; ++a) {
        gradient[terms_[a].unknown] += p.force * terms_[a].factor;
        for (std::size_t b = a; b < start_[i + 1]; ++b)
          add_at(normal, terms_[b].unknown, terms_[a].unknown, p.bend * terms_[a].factor * terms_[b].factor);
      }
    }
    cholesky.factorize(normal);
    if (cholesky.info() != Eigen::Success)
      throw Error("heights: the normal matrix is not positive definite, an unknown is not determined");
    const Eigen::VectorXd step = cholesky.solve(gradient);
    const double slope = gradient.dot(step);
    summary.converged = step.lpNorm<Eigen::Infinity>() <= step_tolerance;
    double share = 1.0;
    bool moved = false;
    for (int halving = 0; halving <= max_halvings && !moved; ++halving, share *= 0.5) {
      for (std::size_t k = 0; k < x.size(); ++k) tried[k] = x[k] - share * step[static_cast<Eigen::Index>(k)];
      const double now = cost(tried, softness);
      if (!(now <= summary.cost_after - sure_decrease * share * slope) && !summary.converged) continue;
      x.swap(tried), summary.cost_after = now, moved = true;
    }
    if (!moved) {  // nothing to gain that doubles could show
      summary.converged = slope <= 1e-9 * (1.0 + summary.cost_after);
      break;
    }
  }
  return summary;
}

SparseJacobian RobustFit::weighted_rows(const std::vector<double>& x) const {
  SparseJacobian jacobian{.columns = static_cast<int>(unknowns_), .row_start = {0}};
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    const double root = std::sqrt(pull(rows_[i], value(i, x), 1.0).weight);
    for (std::size_t k = start_[i]; k < start_[i + 1]; ++k) {
      jacobian.column.push_back(terms_[k].unknown);
      jacobian.value.push_back(root * terms_[k].factor);
    }
    jacobian.row_start.push_back(static_cast<int>(jacobian.column.size()));
  }
  return jacobian;
}

}  // namespace orthodrive
