// SPDX-License-Identifier: Apache-2.0
#pragma once
// Curved regular grids (roadquery/crg.hpp) by their definition: places in the plane and heights, without the options of
// a file. What answers fast, with them, is roadquery/crg_grid.hpp.

#include <limits>
#include <optional>

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
/// The inverse, nearest to the reference line where several are. Nothing beside the rows' range. With a hint u the
/// search walks from there; without one it looks at all rows.
[[nodiscard]] std::optional<CrgUv> crg_uv(const CrgSurface& surface, Vec2 xy,
                                          double u_hint_m = std::numeric_limits<double>::quiet_NaN());
/// Height at (u, v); NaN outside the grid and where a value it depends on is missing.
[[nodiscard]] double crg_height(const CrgSurface& surface, CrgUv uv);

}  // namespace orthodrive
