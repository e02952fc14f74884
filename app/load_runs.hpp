// SPDX-License-Identifier: Apache-2.0
#pragma once
// The units of the pipeline, which lie in a library: GDAL and the hundred libraries that it brings along are not loaded
// for what needs none of them, such as help, the version and wrong usage.

#include "orthodrive/pipeline/commands/runs.hpp"

namespace orthodrive::app {

/// Loads lib/orthodrive/liborthodrive.so when it is first called. Throws Error where the processor is too old, else as
/// load_part() does.
[[nodiscard]] const Runs& runs();

}  // namespace orthodrive::app
