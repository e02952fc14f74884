// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <vector>

namespace orthodrive {

/// Sets of the numbers 0 to count - 1 that grow together (union-find with path halving). A set is named by its lowest
/// member, whatever the order of the joins.
class DisjointSets {
 public:
  explicit DisjointSets(std::size_t count) : first_(count) { std::iota(first_.begin(), first_.end(), std::size_t{0}); }

  /// Lowest member of i's set.
  [[nodiscard]] std::size_t find(std::size_t i) {
    while (first_[i] != i) i = first_[i] = first_[first_[i]];
    return i;
  }

  void join(std::size_t a, std::size_t b) {
    a = find(a), b = find(b);
    first_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<std::size_t> first_;
};

}  // namespace orthodrive
