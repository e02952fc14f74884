// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "roadquery/roads/road_ends.hpp"
#include "roadquery/surface/road_surface.hpp"

namespace orthodrive::evaluate {

/// Inner border of a lane at the end of its road.
[[nodiscard]] roadquery::SurfacePoint inner_border(const roadquery::RoadEnd& end, int lane_id);

}  // namespace orthodrive::evaluate
