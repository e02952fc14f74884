// SPDX-License-Identifier: Apache-2.0
#pragma once
// Curved regular grids (roadquery/crg.hpp) by their definition: places in the plane and heights, without the options of
// a file. What answers fast, with them, and asks for (u, v) of a place is
// roadquery/crg/crg_grid.hpp.

#include "orthodrive/geo/vec.hpp"
#include "roadquery/crg/crg.hpp"

namespace orthodrive {

using roadquery::CrgFormat;
using roadquery::CrgSurface;

struct CrgUv {
  double u_m = 0.0, v_m = 0.0;
};

/// Place of (u, v) in the plane; beyond the first and the last row straight on.
[[nodiscard]] Vec2 crg_xy(const CrgSurface& surface, CrgUv uv);
/// Height at (u, v); NaN outside the grid and where a value it depends on is missing.
[[nodiscard]] double crg_height(const CrgSurface& surface, CrgUv uv);

}  // namespace orthodrive
