// SPDX-License-Identifier: Apache-2.0
#pragma once
// OpenBLAS keeps threads of its own beside those of libtorch and of our windows; they only wait for each other.

#include <optional>
#include <string>

namespace orthodrive {

/// While it lives, matrix products of OpenBLAS run on the thread that asks for them. Nothing with another BLAS.
class SingleThreadedBlas {
 public:
  SingleThreadedBlas();
  ~SingleThreadedBlas();
  SingleThreadedBlas(const SingleThreadedBlas&) = delete;
  SingleThreadedBlas& operator=(const SingleThreadedBlas&) = delete;

 private:
  int before_ = 0;  ///< 0: there is no OpenBLAS
};

/// What to set in the environment where OpenBLAS does not know a CPU with AVX2 and takes its kernels for CPUs of 2004
/// (Debian 12's does so from Sapphire Rapids on): training is then slower by a half and more.
[[nodiscard]] std::optional<std::string> faster_blas();

}  // namespace orthodrive
