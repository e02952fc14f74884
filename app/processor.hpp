// SPDX-License-Identifier: Apache-2.0
#pragma once
// Which instructions the processor must have. Asked by the program, which is compiled for any x86-64, before it loads
// the library, which is not.

#include <string>

namespace orthodrive::app {

struct ProcessorFeatures {
  bool avx2 = false, fma = false;
};

/// What to say where something is missing; empty: nothing is.
[[nodiscard]] inline std::string too_old(const ProcessorFeatures& has) {
  if (has.avx2 && has.fma) return "";
  const char* lacks = has.avx2 ? "FMA" : has.fma ? "AVX2" : "AVX2 and FMA";
  return std::string("this processor is too old: it has no ") + lacks +
         "; orthodrive needs x86-64-v3 (Intel since 2013, AMD since 2015)";
}

/// Of the processor that runs this; of another family than x86 all that is needed.
[[nodiscard]] inline ProcessorFeatures processor_features() {
#if defined(__x86_64__)
  return {.avx2 = __builtin_cpu_supports("avx2") != 0, .fma = __builtin_cpu_supports("fma") != 0};
#else
  return {.avx2 = true, .fma = true};
#endif
}

}  // namespace orthodrive::app
