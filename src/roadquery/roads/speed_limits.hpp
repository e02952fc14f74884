// SPDX-License-Identifier: Apache-2.0
#pragma once
// What may be driven where: the road's limits along s (<type><speed>), and those of single lanes, which count more.

#include "roadquery/map/road_map.hpp"

namespace roadquery {

/// Of the road alone, m/s; infinity: no limit; 0: not known.
[[nodiscard]] double road_limit_mps(const Road& road, double s);
/// Of a lane (1.7, 11.8.4): its own limit, else the road's. As above; lanes that are not there have the road's.
[[nodiscard]] double lane_limit_mps(const Road& road, int lane_id, double s);
/// The highest of all driving lanes at s, or of those of one side; the road's where there is none.
enum class LimitSide { both, left, right };
[[nodiscard]] double fastest_limit_mps(const Road& road, double s, LimitSide side = LimitSide::both);
/// Whether limits differ along the road or between its lanes.
[[nodiscard]] bool has_lane_limits(const Road& road);

}  // namespace roadquery
