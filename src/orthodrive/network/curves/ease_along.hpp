// SPDX-License-Identifier: Apache-2.0
#pragma once
// Widths and offsets of the lanes of a connecting road, from those of one road to those of the next.

#include <span>
#include <vector>

#include "roadquery/map/road_map.hpp"

namespace orthodrive::network {

/// Cubics along a whole line from one value to another (m), C1, level at both ends, as those of roads are, and where
/// the line's curvature jumps: beside a reference line a lane turns by atan(slope / (1 - curvature t)), which would
/// jump there, too. Each stretch between two jumps takes a share of the change by the square of its length, so that all
/// of them have the same largest second derivative, which is what a driver feels.
[[nodiscard]] std::vector<roadquery::Cubic> ease_along(std::span<const roadquery::PlanElement> plan, double from,
                                                       double to);

}  // namespace orthodrive::network
