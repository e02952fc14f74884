// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/core/memory.hpp"

#include <malloc.h>

#include <fstream>
#include <string>

namespace orthodrive {

std::uint64_t peak_memory_bytes() {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);)
    if (line.rfind("VmHWM:", 0) == 0) return std::stoull(line.substr(6)) * 1024;
  return 0;
}

void release_free_memory() { malloc_trim(0); }

void reset_peak_memory() {
  release_free_memory();  // or what the stage before freed would count for the next
  std::ofstream("/proc/self/clear_refs") << "5";
}

}  // namespace orthodrive
