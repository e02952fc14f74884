// SPDX-License-Identifier: Apache-2.0
#pragma once
// Peak memory of this process, resettable so that each stage has its own figure.

#include <cstdint>

namespace orthodrive {

/// Peak resident set size since start or the last reset, in bytes (Linux VmHWM; 0 where unknown).
[[nodiscard]] std::uint64_t peak_memory_bytes();
/// Starts a new peak at the present resident size (Linux clear_refs 5; no effect where not permitted).
void reset_peak_memory();

/// Gives memory that is free back to the system: worker threads leave it in their pools (glibc; no effect elsewhere).
void release_free_memory();

}  // namespace orthodrive
