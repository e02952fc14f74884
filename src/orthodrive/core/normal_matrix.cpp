#include "orthodrive/core/normal_matrix.hpp"

#include <Eigen/Sparse>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cassert>
#include <cstddef>
#include <span>

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
  if (cholesky.info() != Eigen::Success) throw Error("the normal matrix is not positive definite: a parameter is not determined");
}

/// (J^T J)^-1 where its Cholesky factor has entries.
class InverseOnPattern {
 public:
  explicit InverseOnPattern(const SparseJacobian& jacobian) {
    Cholesky cholesky;
    factorize(jacobian, cholesky);
    factor_ = cholesky.matrixL();  // lower triangle, rows ascending in each column
    const int n = jacobian.columns;
    start_ = {factor_.outerIndexPtr(), static_cast<std::size_t>(n) + 1};
    row_ = {factor_.innerIndexPtr(), static_cast<std::size_t>(factor_.nonZeros())};
    const std::span value(factor_.valuePtr(), row_.size());
    inverse_.resize(row_.size());
    for (int c = n - 1; c >= 0; --c) {
      const int first = start_[c], last = start_[c + 1];
      const double pivot = value[first];
      for (int a = last - 1; a >= first; --a) {  // the diagonal (a == first) comes last: it needs the others
        double sum = a == first ? -1.0 / pivot : 0.0;
        for (int b = first + 1; b < last; ++b) sum += value[b] * (a == first ? inverse_[b] : permuted(row_[a], row_[b]));
        inverse_[a] = -sum / pivot;
      }
    }
    const auto& permutation = cholesky.permutationP().indices();  // permuted position of each column
    position_.assign(permutation.data(), permutation.data() + n);
  }

  [[nodiscard]] double at(int i, int k) const { return permuted(position_[i], position_[k]); }

 private:
  [[nodiscard]] double permuted(int i, int k) const {
    const int low = std::min(i, k), high = std::max(i, k);
    const auto begin = row_.begin() + start_[low], end = row_.begin() + start_[low + 1];
    const auto at = std::lower_bound(begin, end, high);
    assert(at != end && *at == high);
    return inverse_[static_cast<std::size_t>(at - row_.begin())];
  }

  Eigen::SparseMatrix<double> factor_;
  std::span<const int> start_, row_;
  std::vector<double> inverse_;  // of the permuted normal matrix
  std::vector<int> position_;
};

}  // namespace

std::vector<double> inverse_normal_diagonal(const SparseJacobian& jacobian) {
  if (jacobian.columns == 0) return {};
  const InverseOnPattern inverse(jacobian);
  std::vector<double> diagonal(static_cast<std::size_t>(jacobian.columns));
  for (int c = 0; c < jacobian.columns; ++c) diagonal[static_cast<std::size_t>(c)] = inverse.at(c, c);
  return diagonal;
}

std::vector<double> normal_variances(const SparseJacobian& jacobian, const SparseJacobian& functions) {
  std::vector<double> variances(functions.row_start.size() - 1, 0.0);
  if (variances.empty()) return variances;
  const InverseOnPattern inverse(jacobian);
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
