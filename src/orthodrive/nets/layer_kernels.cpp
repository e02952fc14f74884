// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/nets/layer_kernels.hpp"

namespace orthodrive {

std::vector<const LayerKernels*> available_layer_kernels() {
  std::vector<const LayerKernels*> tables{plain_layer_kernels()};
#if defined(ORTHODRIVE_X86_KERNELS)
  __builtin_cpu_init();
  if (__builtin_cpu_supports("avx2") != 0 && __builtin_cpu_supports("fma") != 0) {
    tables.push_back(avx2_layer_kernels());
    if (__builtin_cpu_supports("avx512f") != 0 && __builtin_cpu_supports("avx512vl") != 0)
      tables.push_back(avx512_layer_kernels());
  }
#endif
  return tables;
}

const LayerKernels& layer_kernels() {
  static const LayerKernels* const best = available_layer_kernels().back();
  return *best;
}

}  // namespace orthodrive
