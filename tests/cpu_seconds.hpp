// SPDX-License-Identifier: Apache-2.0
#pragma once
/// Time of the processor for tests that bound it: other work on the machine stretches the wall time to any length, this
/// by a fifth (both measured). It still makes a run slower, never faster, so the least of a few counts.

#include <algorithm>
#include <ctime>
#include <limits>

namespace orthodrive::test {

/// What all threads of this process have taken of the processor, s.
inline double cpu_seconds() {
  std::timespec time{};
  ::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

/// The least that `runs` runs take of the processor, s.
template <typename Function>
double least_cpu_seconds(int runs, const Function& function) {
  double least = std::numeric_limits<double>::infinity();
  for (int run = 0; run < runs; ++run) {
    const double start = cpu_seconds();
    function();
    least = std::min(least, cpu_seconds() - start);
  }
  return least;
}

}  // namespace orthodrive::test
