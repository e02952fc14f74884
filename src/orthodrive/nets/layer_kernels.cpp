// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/nets/layer_kernels.hpp"

namespace orthodrive {

const LayerKernels& layer_kernels([[maybe_unused]] KernelFamily family) {
#if defined(__x86_64__)
  if (family == KernelFamily::avx2) return *avx2_layer_kernels();
  if (family == KernelFamily::avx512) return *avx512_layer_kernels();
#endif
  return *plain_layer_kernels();
}

}  // namespace orthodrive
