// SPDX-License-Identifier: Apache-2.0
#pragma once
// Cross slopes of roads that share pavement, where nothing is measured: both are one surface there.

#include <vector>

#include "orthodrive/elevate/banking/fit_banking.hpp"
#include "orthodrive/elevate/profiles/parting_roads.hpp"

namespace orthodrive::elevate {

/// Heights of roads follow the terrain, designed cross slopes the bends of each road by itself. Where two roads share
/// pavement (`shared`) their surfaces then meet in a step. Slopes with the source "design" change by the least that
/// gives both surfaces one height in the middle of what the roads share, and one slope as far as carriageways lie on
/// each other; measured ones stay. Roads whose heights differ by more than `largest_slope` across are two surfaces, and
/// keep theirs.
/// Returns anchors for a second fit by chain, ordered by station; none for chains that fit already. `fits`: of a first
/// fit, by chain.
[[nodiscard]] std::vector<std::vector<BankingAnchor>> share_slopes(const NetworkStations& network,
                                                                   const std::vector<SharedPavement>& shared,
                                                                   const std::vector<BankingFit>& fits,
                                                                   double largest_slope);

}  // namespace orthodrive::elevate
