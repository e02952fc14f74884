// SPDX-License-Identifier: Apache-2.0
#pragma once
// What of a carriageway lies beside its driving lanes: hard shoulders, edge strips, parking strips.

#include <string_view>

#include "orthodrive/model/roads/parse_driving_side.hpp"
#include "orthodrive/model/roads/road_network.hpp"
#include "roadquery/map/road_map.hpp"

namespace orthodrive::network {

struct LaneLayout;

/// Of one side, as a share of the carriageway's width.
struct LaneRest {
  roadquery::LaneType type = roadquery::LaneType::none;  ///< none: no rest
  double share = 0.0;
  [[nodiscard]] bool exists() const { return share > 0.0; }
};

/// Seen along the road.
struct LaneRests {
  LaneRest left, right;
  LaneRest left_cycles, right_cycles;  ///< cycle lanes, between the lanes and what else lies beside them
  [[nodiscard]] double left_share() const { return left.share + left_cycles.share; }
  [[nodiscard]] double share() const { return left_share() + right.share + right_cycles.share; }
};

/// The sides where RoadPath::side_lanes has lanes of a kind ("bicycle", "bus").
[[nodiscard]] Sides sides_with(const RoadPath& path, std::string_view kind, DrivingSide driving_side);

/// Where the carriageway is wider than lanes of its class are at most (docs/road_surface.md names the standards), or
/// than tags tell of all of them. Strips of less than 0.5 m stay with the lanes. Of motorways and trunk roads the inner
/// edge strip is at most 0.75 m, the hard shoulder lies outside; of roundabouts the rest lies at the island; shoulders
/// lie where the tags say so. Streets have `parking` where there is room on both sides (one-way: outside). Else both
/// sides have the same: `shoulder` from 1 m on of roads down to unclassified without sidewalk, `border` of others.
/// Cycle lanes of 1.5 m come before all that, as far as the lanes keep 2.2 m; none narrower than 0.75 m.
[[nodiscard]] LaneRests lane_rests(const RoadPath& path, const LaneLayout& layout, double median_width_m,
                                   DrivingSide driving_side);

/// Whether lanes of this type are part of the carriageway that nobody drives on.
[[nodiscard]] constexpr bool is_rest(roadquery::LaneType type) {
  using roadquery::LaneType;
  return type == LaneType::shoulder || type == LaneType::border || type == LaneType::parking;
}

/// What two roads that are linked have where they meet, along the first one; each type is the own one's. A strip ends
/// before roads that have none.
[[nodiscard]] LaneRests rests_at_joint(const LaneRests& own, const LaneRests& other, bool same_direction);

}  // namespace orthodrive::network
