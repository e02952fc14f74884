// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/crf/crf_kernels.hpp"

#include <cassert>

namespace orthodrive {

std::vector<const CrfKernels*> available_crf_kernels() {
  std::vector<const CrfKernels*> tables{plain_crf_kernels()};
#if defined(ORTHODRIVE_X86_KERNELS)
  __builtin_cpu_init();
  if (__builtin_cpu_supports("avx2") != 0 && __builtin_cpu_supports("fma") != 0) {
    tables.push_back(avx2_crf_kernels());
    if (__builtin_cpu_supports("avx512vl") != 0 && __builtin_cpu_supports("avx512dq") != 0)
      tables.push_back(avx512_crf_kernels());
  }
#endif
  return tables;
}

const CrfKernels& crf_kernels(int chunks) {
  static const CrfKernels* const best = available_crf_kernels().back();
  assert(chunks >= 1 && chunks <= max_crf_classes / 8);
  return best[chunks - 1];
}

}  // namespace orthodrive
