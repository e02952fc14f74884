#pragma once
/// Wall time for tests that bound it. Other work on the machine makes a run slower, never faster, so the least of a few
/// counts.

#include <algorithm>
#include <chrono>
#include <limits>

namespace orthodrive::test {

/// The least wall time of `runs` runs, s.
template <typename Function>
double least_seconds(int runs, const Function& function) {
  double least = std::numeric_limits<double>::infinity();
  for (int run = 0; run < runs; ++run) {
    const auto start = std::chrono::steady_clock::now();
    function();
    least = std::min(least, std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  }
  return least;
}

}  // namespace orthodrive::test
