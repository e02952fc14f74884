// SPDX-License-Identifier: Apache-2.0
#pragma once
// Lines across the lanes into a junction at which drivers wait.

#include <vector>

#include "orthodrive/network/line/network_plan.hpp"
#include "roadquery/map/road_map.hpp"
#include "roadquery/surface/road_surface.hpp"

namespace orthodrive::network {

inline constexpr double waiting_line_m = 0.5;  ///< along the road (RMS-1 1993: stop and give-way lines are 0.50 m wide)
inline constexpr const char* stop_line = "stop line";
inline constexpr const char* give_way_line = "give way line";

/// Road marks (OpenDRIVE 1.8, 13.14.8: subtype "signalLines"; the name tells which) across the lanes that lead into
/// junctions:
/// - where OSM has highway=stop, give_way or traffic_signals on the way to this junction, within 40 m: that one's;
/// - else a give-way line where the road is of a lower class than the highest of the junction, that one is tertiary or
///   higher or the ring of a roundabout, and the road is paved and no service road or track. Between residential roads
///   nothing is painted. Slip roads that merge have none.
/// Crosswalks within 12 m of the end come after the line, 1 m away.
void add_waiting_lines(const NetworkPlan& plan, const std::vector<std::vector<JunctionEnd>>& ends,
                       roadquery::RoadMap& map);

/// Rank of the road that ends there among those of a junction: of its class, of rings above all.
[[nodiscard]] int rank_of(const NetworkPlan& plan, const JunctionEnd& end);
inline constexpr int ring_rank = 100;

/// t of the right and left border of the driving lanes that lead into the junction at a road's end.
[[nodiscard]] roadquery::Edges incoming_edges(const roadquery::Road& road, bool at_end, double s);

}  // namespace orthodrive::network
