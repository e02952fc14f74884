// SPDX-License-Identifier: Apache-2.0
#pragma once
// What this program was built of; CMake writes build_info.cpp from build_info.cpp.in.

#include <span>

namespace orthodrive::app {

struct BuildFact {
  const char* name = nullptr;
  const char* value = nullptr;
};

[[nodiscard]] std::span<const BuildFact> build_facts();

}  // namespace orthodrive::app
