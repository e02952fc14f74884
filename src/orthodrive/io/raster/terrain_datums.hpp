// SPDX-License-Identifier: Apache-2.0
#pragma once
// Terrain models of one site in one unit and over one datum. Internal to io.

#include <filesystem>
#include <vector>

#include "orthodrive/core/finding.hpp"
#include "orthodrive/model/rasters/rasters.hpp"
#include "orthodrive/model/site_frame.hpp"

namespace orthodrive::io {

/// Brings models that differ by a factor (feet) or a constant (vertical datums) onto each other where the data leave no
/// doubt, and tells what was done and what was left, as read_dtms says. `grids` belong to `paths`, best first; they
/// are compared in `box`.
void to_one_datum(const std::vector<std::filesystem::path>& paths, const Box2& box, std::vector<HeightGrid>& grids,
                  Findings* findings);

}  // namespace orthodrive::io
