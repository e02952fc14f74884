// SPDX-License-Identifier: Apache-2.0
#pragma once
// Inner loops are compiled once per family of processors and chosen at run time. All families give the same bits: sums
// run in one order, each product is added with one rounding (fused multiply-add), and nothing else may be contracted.

#include <string>
#include <vector>

namespace orthodrive {

/// `plain` needs fused multiply-add in hardware and no wider vectors; on x86-64 libm needs AVX2 for the same bits.
enum class KernelFamily { plain, avx2, avx512 };

[[nodiscard]] const char* to_string(KernelFamily family);

/// Those that this processor can run, from the narrowest to the widest.
[[nodiscard]] std::vector<KernelFamily> supported_kernel_families();

/// The family of that name. Throws OptionError for an unknown name and for one that this processor cannot run.
[[nodiscard]] KernelFamily kernel_family_named(const std::string& name);

/// The widest that this processor can run, or the one that the environment variable ORTHODRIVE_KERNELS names: a switch
/// for tests. Throws as kernel_family_named().
[[nodiscard]] KernelFamily kernel_family();

}  // namespace orthodrive
