// SPDX-License-Identifier: Apache-2.0
#pragma once
// Includes ATen: for .cpp files only.

#include <ATen/Parallel.h>

namespace orthodrive {

/// While it lives, ATen runs on one thread where this thread asks for it. OpenMP keeps the number per thread: workers
/// need one each. We parallelise over windows, and sums inside a convolution must not depend on the number of threads.
class SingleThreadedTorch {
 public:
  SingleThreadedTorch() : before_(at::get_num_threads()) { at::set_num_threads(1); }
  ~SingleThreadedTorch() { at::set_num_threads(before_); }
  SingleThreadedTorch(const SingleThreadedTorch&) = delete;
  SingleThreadedTorch& operator=(const SingleThreadedTorch&) = delete;

 private:
  int before_;
};

}  // namespace orthodrive
