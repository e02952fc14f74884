// SPDX-License-Identifier: Apache-2.0
#pragma once
// How fast the surface of a road may turn about its line.

#include "orthodrive/network/line/chain_geometry.hpp"

namespace orthodrive::network {

/// Bankings change by the least that keeps the warp within what a car's springs take: with the banking b, the gradient
/// g and the curvature k, b' + k g is how much the surface across turns a metre beyond what a plane does in a bend.
/// Where nothing is too fast nothing changes. Of closed chains before they are laid round twice.
void limit_warp(ChainGeometry& geometry, double banking_tolerance_rad);

}  // namespace orthodrive::network
