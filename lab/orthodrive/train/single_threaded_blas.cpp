// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/train/single_threaded_blas.hpp"

#include <dlfcn.h>

#include <algorithm>
#include <array>
#include <string_view>

namespace orthodrive {
namespace {

// Looked up when the program runs: libtorch may be built with any BLAS.
int threads_of_openblas() {
  auto* get = reinterpret_cast<int (*)()>(dlsym(RTLD_DEFAULT, "openblas_get_num_threads"));
  return get ? get() : 0;
}

void set_threads_of_openblas(int count) {
  auto* set = reinterpret_cast<void (*)(int)>(dlsym(RTLD_DEFAULT, "openblas_set_num_threads"));
  if (set) set(count);
}

}  // namespace

SingleThreadedBlas::SingleThreadedBlas() : before_(threads_of_openblas()) {
  if (before_ > 1) set_threads_of_openblas(1);
}

SingleThreadedBlas::~SingleThreadedBlas() {
  if (before_ > 1) set_threads_of_openblas(before_);
}

std::optional<std::string> faster_blas() {
  constexpr std::array<std::string_view, 4> old{"Prescott", "Core2", "Nehalem", "Generic"};
  auto* name = reinterpret_cast<const char* (*)()>(dlsym(RTLD_DEFAULT, "openblas_get_corename"));
  if (!name || std::ranges::find(old, std::string_view(name())) == old.end()) return {};
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx512f")) return "OPENBLAS_CORETYPE=SKYLAKEX";
  if (__builtin_cpu_supports("avx2")) return "OPENBLAS_CORETYPE=HASWELL";
#endif
  return {};
}

}  // namespace orthodrive
