// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/core/kernel_family.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdlib>

#include "orthodrive/core/error.hpp"

namespace orthodrive {
namespace {

constexpr std::array all_families{KernelFamily::plain, KernelFamily::avx2, KernelFamily::avx512};

}  // namespace

const char* to_string(KernelFamily family) {
  switch (family) {
    case KernelFamily::plain:
      return "plain";
    case KernelFamily::avx2:
      return "avx2";
    case KernelFamily::avx512:
      break;
  }
  return "avx512";
}

std::vector<KernelFamily> supported_kernel_families() {
  std::vector<KernelFamily> families{KernelFamily::plain};
#if defined(__x86_64__)
  __builtin_cpu_init();
  if (__builtin_cpu_supports("avx2") != 0 && __builtin_cpu_supports("fma") != 0) {
    families.push_back(KernelFamily::avx2);
    if (__builtin_cpu_supports("avx512f") != 0 && __builtin_cpu_supports("avx512vl") != 0 &&
        __builtin_cpu_supports("avx512dq") != 0)
      families.push_back(KernelFamily::avx512);
  }
#endif
  return families;
}

KernelFamily kernel_family_named(const std::string& name) {
  const auto found =
      std::ranges::find(all_families, name, [](KernelFamily family) { return std::string(to_string(family)); });
  if (found == all_families.end())
    throw OptionError(fmt::format("kernel family '{}' is unknown: use plain, avx2 or avx512", name));
  if (std::ranges::count(supported_kernel_families(), *found) == 0)
    throw OptionError(
        fmt::format("this processor cannot run the kernel family '{}': leave ORTHODRIVE_KERNELS unset", name));
  return *found;
}

KernelFamily kernel_family() {
  static const KernelFamily chosen = [] {
    const char* name = std::getenv("ORTHODRIVE_KERNELS");
    return name ? kernel_family_named(name) : supported_kernel_families().back();
  }();
  return chosen;
}

}  // namespace orthodrive
