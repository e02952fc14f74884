#include "orthodrive/core/normal_matrix.hpp"

#include <Eigen/Sparse>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cstddef>
#include <span>

#include "orthodrive/core/error.hpp"

namespace orthodrive {

std::vector<double> inverse_normal_diagonal(const SparseJacobian& jacobian) {
  const int n = jacobian.columns, rows = static_cast<int>(jacobian.row_start.size()) - 1;
  if (n == 0) return {};
  using RowMajor = Eigen::SparseMatrix<double, Eigen::RowMajor>;
  const Eigen::Map<const RowMajor> j(rows, n, static_cast<Eigen::Index>(jacobian.value.size()), jacobian.row_start.data(),
                                     jacobian.column.data(), jacobian.value.data());
  const Eigen::SparseMatrix<double> normal = RowMajor(j.transpose() * j);
  const Eigen::SimplicialLLT<Eigen::SparseMatrix<double>> cholesky(normal);
  if (cholesky.info() != Eigen::Success) throw Error("the normal matrix is not positive definite: a parameter is not determined");

  const Eigen::SparseMatrix<double> factor = cholesky.matrixL();  // lower triangle, rows ascending in each column
  const std::span start(factor.outerIndexPtr(), static_cast<std::size_t>(n) + 1);
  const std::span row(factor.innerIndexPtr(), static_cast<std::size_t>(factor.nonZeros()));
  const std::span value(factor.valuePtr(), row.size());
  std::vector<double> inverse(row.size());  // of the permuted normal matrix, on the pattern of the factor
  const auto inverse_at = [&](int i, int k) {
    const int low = std::min(i, k), high = std::max(i, k);
    const auto begin = row.begin() + start[low], end = row.begin() + start[low + 1];
    return inverse[static_cast<std::size_t>(std::lower_bound(begin, end, high) - row.begin())];
  };
  for (int c = n - 1; c >= 0; --c) {
    const int first = start[c], last = start[c + 1];
    const double pivot = value[first];
    for (int a = last - 1; a >= first; --a) {  // the diagonal (a == first) comes last: it needs the others
      double sum = a == first ? -1.0 / pivot : 0.0;
      for (int b = first + 1; b < last; ++b) sum += value[b] * (a == first ? inverse[b] : inverse_at(row[a], row[b]));
      inverse[a] = -sum / pivot;
    }
  }
  std::vector<double> diagonal(n);
  const auto& permutation = cholesky.permutationP().indices();  // permuted position of each column
  for (int c = 0; c < n; ++c) diagonal[c] = inverse[start[permutation[c]]];
  return diagonal;
}

}  // namespace orthodrive
