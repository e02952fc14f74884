// SPDX-License-Identifier: Apache-2.0
#pragma once
// Footprints of the buildings that the photo shows and the map lacks.

#include <span>
#include <vector>

#include "orthodrive/model/building.hpp"
#include "orthodrive/model/rasters/rasters.hpp"

namespace orthodrive::scene {

/// Patches of labels of the role building that lie 4 m or more beside all known buildings, as footprints with right
/// angles: along the direction in which the patch begins and ends most sharply, built of cells of about 2.5 m that the
/// patch covers by half. Patches below 40 m2, narrower than 4 m, or that fill less than 55 % of the rectangle around
/// them are left out: they are seldom buildings. In the order of their first pixel.
[[nodiscard]] std::vector<Building> footprints_of_labels(const LabelMap& labels, std::span<const Building> known);

}  // namespace orthodrive::scene
