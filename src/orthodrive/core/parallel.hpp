// SPDX-License-Identifier: Apache-2.0
#pragma once
// Loops over independent items. Each call writes to its own slot, so the result does not depend on the thread count.

#include <cstddef>
#include <functional>

namespace orthodrive {

/// Number of workers for an option value: 0 means all cores.
[[nodiscard]] int worker_count(int threads);

/// Calls body(i) for i in [0, count) on up to `threads` workers (0 = all cores), in no particular order.
/// The first exception (by index) is rethrown after all workers have stopped. Throws Stopped between two items when the
/// process was asked to end (core/stop.hpp).
/// `after_each(done)` runs on the calling thread from time to time with the number of items done: for progress bars.
void parallel_for(std::size_t count, int threads, const std::function<void(std::size_t)>& body,
                  const std::function<void(std::size_t)>& after_each = {});

}  // namespace orthodrive
