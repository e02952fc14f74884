// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/crf/crf_kernels.hpp"

#include <cassert>

namespace orthodrive {
namespace {

const CrfKernels* table_of([[maybe_unused]] KernelFamily family) {
#if defined(__x86_64__)
  if (family == KernelFamily::avx2) return avx2_crf_kernels();
  if (family == KernelFamily::avx512) return avx512_crf_kernels();
#endif
  return plain_crf_kernels();
}

}  // namespace

const CrfKernels& crf_kernels(int chunks, KernelFamily family) {
  assert(chunks >= 1 && chunks <= max_crf_classes / 8);
  return table_of(family)[chunks - 1];
}

}  // namespace orthodrive
