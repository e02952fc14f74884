// SPDX-License-Identifier: Apache-2.0
#pragma once
// A lap as tables of text.

#include <string>

#include "orthodrive/drive/drive_route.hpp"

namespace orthodrive {

/// Text of lap.csv: one row a sample, a header with the columns, numbers with fixed decimals. Columns with their
/// frames: docs/drive.md.
[[nodiscard]] std::string lap_csv(const DriveResult& result);

/// Text of cycle.csv, as consumption and emissions are computed from: once a second time (s), speed (km/h), gradient
/// (%), height (m), distance (m) and gear.
[[nodiscard]] std::string cycle_csv(const DriveResult& result);

}  // namespace orthodrive
