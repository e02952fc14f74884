// SPDX-License-Identifier: Apache-2.0
#pragma once
// Road ends at a junction, as a driver passes them.

#include <cmath>
#include <cstddef>
#include <vector>

#include "orthodrive/geo/vec.hpp"
#include "orthodrive/model/roads/road_network.hpp"
#include "orthodrive/network/curves/fit_plan.hpp"
#include "roadquery/map/road_map.hpp"

namespace orthodrive::network {

[[nodiscard]] inline std::size_t as_index(int i) { return static_cast<std::size_t>(i); }

/// A road end as a driver passes it, in driving direction.
struct Gate {
  Pose pose;
  double z_m = 0.0, gradient = 0.0, banking = 0.0, banking_rate = 0.0, crown = 0.0;  ///< crown: its tangent
  double outer_rest_m = 0.0, inner_rest_m = 0.0;  ///< widths of what lies beside the lanes of one direction alone
  double inner_t_m = 0.0;  ///< of the edge between the lanes of this direction and the oncoming ones
  std::vector<int> lanes;  ///< of this direction, from the inside out
  std::vector<double> lane_widths_m, lanes_from_m;  ///< of those lanes; their inner edges from inner_t_m outwards
  roadquery::LaneType type = roadquery::LaneType::driving;  ///< of those lanes, where they are none for cars
  std::vector<unsigned> arrows;  ///< of the lanes, where they are painted and the gate leads into the junction
};

[[nodiscard]] Gate gate_of(const roadquery::Road& road, const RoadPath& path, bool at_end, bool incoming);

/// How far from inner_t_m a gate's lane begins, or one more beside its outermost one would.
[[nodiscard]] double lane_from_m(const Gate& gate, std::size_t lane);
/// 0: there is none.
[[nodiscard]] double lane_width_m(const Gate& gate, std::size_t lane);

/// From one direction to another, positive to the left.
[[nodiscard]] inline double angle_between(Vec2 in, Vec2 out) { return std::atan2(cross(in, out), dot(in, out)); }

}  // namespace orthodrive::network
