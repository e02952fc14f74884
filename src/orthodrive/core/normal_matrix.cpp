#include "orthodrive/core/normal_matrix.hpp"

#include <Eigen/Sparse>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cassert>
#include <cstddef>

#include "orthodrive/core/error.hpp"

namespace orthodrive {

std::size_t InverseNormal::index_of(int low, int high) const {
  const auto begin = row_.begin() + start_[static_cast<std::size_t>(low)],
             end = row_.begin() + start_[static_cast<std::size_t>(low) + 1];
  const auto found = std::lower_bound(begin, end, high);
  assert(found != end && *found == high);
  return static_cast<std::size_t>(found - row_.begin());
}

InverseNormal::InverseNormal(const SparseJacobian& jacobian) {
  const int n = jacobian.columns, rows = static_cast<int>(jacobian.row_start.size()) - 1;
  if (n == 0) return;
  using RowMajor = Eigen::SparseMatrix<double, Eigen::RowMajor>;
  const Eigen::Map<const RowMajor> j(rows, n, static_cast<Eigen::Index>(jacobian.value.size()),
                                     jacobian.row_start.data(), jacobian.column.data(), jacobian.value.data());
  const Eigen::SparseMatrix<double> normal = RowMajor(j.transpose() * j);
  const Eigen::SimplicialLLT<Eigen::SparseMatrix<double>> cholesky(normal);
  if (cholesky.info() != Eigen::Success)
    throw Error("the normal matrix is not positive definite: a parameter is not determined");

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
  for (int i = 0; i < jacobian.columns; ++i) diagonal.push_back(inverse.at(i, i));
  return diagonal;
}

}  // namespace orthodrive
