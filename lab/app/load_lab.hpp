// SPDX-License-Identifier: Apache-2.0
#pragma once
// The units of the laboratory, which lie in a library of their own.

#include "orthodrive/lab/commands/lab_runs.hpp"

namespace orthodrive::app {

/// Loads lib/orthodrive/liborthodrive-lab.so when it is first called. Throws as runs() does.
[[nodiscard]] const LabRuns& lab_runs();

}  // namespace orthodrive::app
