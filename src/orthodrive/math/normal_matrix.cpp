// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/math/normal_matrix.hpp"

#include <Eigen/Core>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cassert>

#include "orthodrive/core/error.hpp"

namespace orthodrive {

namespace {

using RowMajor = Eigen::SparseMatrix<double, Eigen::RowMajor>;
using Cholesky = Eigen::SimplicialLLT<Eigen::SparseMatrix<double>>;

Eigen::Map<const RowMajor> as_matrix(const SparseJacobian& jacobian) {
  const int rows = static_cast<int>(jacobian.row_start.size()) - 1;
  return {rows,
          jacobian.columns,
          static_cast<Eigen::Index>(jacobian.value.size()),
          jacobian.row_start.data(),
          jacobian.column.data(),
          jacobian.value.data()};
}

void factorize(const SparseJacobian& jacobian, Cholesky& cholesky) {
  const auto j = as_matrix(jacobian);
  const Eigen::SparseMatrix<double> normal = RowMajor(j.transpose() * j);
  cholesky.compute(normal);
  if (cholesky.info() != Eigen::Success)
    throw Error("the normal matrix is not positive definite: a parameter is not determined");
}

}  // namespace

std::size_t InverseNormal::index_of(int low, int high) const {
  const auto begin = row_.begin() + start_[static_cast<std::size_t>(low)],
             end = row_.begin() + start_[static_cast<std::size_t>(low) + 1];
  const auto found = std::lower_bound(begin, end, high);
  assert(found != end && *found == high);
  return static_cast<std::size_t>(found - row_.begin());
}

InverseNormal::InverseNormal(const SparseJacobian& jacobian) {
  const int n = jacobian.columns;
  if (n == 0) return;
  Cholesky cholesky;
  factorize(jacobian, cholesky);
  const Eigen::SparseMatrix<double> factor = cholesky.matrixL();  // lower triangle, rows ascending in each column
  start_.assign(factor.outerIndexPtr(), factor.outerIndexPtr() + n + 1);
  row_.assign(factor.innerIndexPtr(), factor.innerIndexPtr() + factor.nonZeros());
  const auto& permutation = cholesky.permutationP().indices();
  position_.assign(permutation.data(), permutation.data() + n);
  const double* value = factor.valuePtr();
  value_.resize(row_.size());
  for (int c = n - 1; c >= 0; --c) {
    const int first = start_[static_cast<std::size_t>(c)], last = start_[static_cast<std::size_t>(c) + 1];
    const double pivot = value[first];
    for (int a = last - 1; a >= first; --a) {  // the diagonal (a == first) comes last: it needs the others
      double sum = a == first ? -1.0 / pivot : 0.0;
      for (int b = first + 1; b < last; ++b) {
        const auto [low, high] = std::minmax(row_[static_cast<std::size_t>(a)], row_[static_cast<std::size_t>(b)]);
        sum += value[b] * value_[a == first ? static_cast<std::size_t>(b) : index_of(low, high)];
      }
      value_[static_cast<std::size_t>(a)] = -sum / pivot;
    }
  }
}

double InverseNormal::at(int i, int k) const {
  const auto [low, high] = std::minmax(position_[static_cast<std::size_t>(i)], position_[static_cast<std::size_t>(k)]);
  return value_[index_of(low, high)];
}

std::vector<double> inverse_normal_diagonal(const SparseJacobian& jacobian) {
  const InverseNormal inverse(jacobian);
  std::vector<double> diagonal;
  diagonal.reserve(static_cast<std::size_t>(jacobian.columns));
  for (int i = 0; i < jacobian.columns; ++i) diagonal.push_back(inverse.at(i, i));
  return diagonal;
}

std::vector<double> normal_variances(const SparseJacobian& jacobian, const SparseJacobian& functions) {
  std::vector<double> variances(functions.row_start.size() - 1, 0.0);
  if (variances.empty()) return variances;
  const InverseNormal inverse(jacobian);
  for (std::size_t f = 0; f < variances.size(); ++f)
    for (int a = functions.row_start[f]; a < functions.row_start[f + 1]; ++a)
      for (int b = functions.row_start[f]; b < functions.row_start[f + 1]; ++b)
        variances[f] += functions.value[a] * functions.value[b] * inverse.at(functions.column[a], functions.column[b]);
  return variances;
}

std::vector<double> solve_normal(const SparseJacobian& jacobian, const std::vector<double>& right) {
  if (jacobian.columns == 0) return {};
  Cholesky cholesky;
  factorize(jacobian, cholesky);
  const Eigen::Map<const Eigen::VectorXd> b(right.data(), static_cast<Eigen::Index>(right.size()));
  const Eigen::VectorXd x = cholesky.solve(as_matrix(jacobian).transpose() * b);
  return {x.data(), x.data() + x.size()};
}

}  // namespace orthodrive
