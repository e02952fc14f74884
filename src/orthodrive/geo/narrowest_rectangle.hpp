// SPDX-License-Identifier: Apache-2.0
#pragma once
// The rectangle of least area around a ring.

#include "orthodrive/geo/polygon.hpp"

namespace orthodrive {

/// Its corners, counter-clockwise; none for fewer than three points off a line. One of its sides lies on the convex
/// hull (Freeman and Shapira, Determining the minimum-area encasing rectangle for an arbitrary closed curve, 1975).
[[nodiscard]] Ring narrowest_rectangle(const Ring& ring);

}  // namespace orthodrive
