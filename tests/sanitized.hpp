// SPDX-License-Identifier: Apache-2.0
#pragma once
// Whether the address sanitizer watches: it makes all several times slower, and asks of indices and bytes, not of
// numbers. So cases that differ by their seed alone are fewer there.

#include <cstddef>
#include <vector>

namespace orthodrive {

#ifdef __SANITIZE_ADDRESS__
constexpr bool sanitized = true;
#else
constexpr bool sanitized = false;
#endif

/// Why a case is left out there: it runs with other threads, tiles or windows what other cases run, and compares bytes.
constexpr const char* runs_again = "runs again what other cases run; the sanitizers have seen it";

/// All of these cases; under the sanitizer every `step`-th.
template <typename T>
std::vector<T> unless_sanitized(std::vector<T> cases, std::size_t step) {
  if (!sanitized) return cases;
  std::vector<T> some;
  for (std::size_t i = 0; i < cases.size(); i += step) some.push_back(cases[i]);
  return some;
}

}  // namespace orthodrive
