// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace orthodrive {

/// The value that would stand at that place if they were sorted. Changes their order.
template <typename T>
[[nodiscard]] T at_rank(std::vector<T>& values, std::size_t rank) {
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(rank);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

/// The upper one of the two in the middle. Not of nothing.
template <typename T>
[[nodiscard]] T median(std::vector<T> values) {
  return at_rank(values, values.size() / 2);
}

}  // namespace orthodrive
