#pragma once
// How a carriageway is divided into lanes.

#include <optional>
#include <span>
#include <vector>

#include "orthodrive/model/road_network.hpp"
#include "orthodrive/network/fit_profile.hpp"
#include "roadquery/road_map.hpp"

namespace orthodrive::network {

/// All lanes of a road are equally wide. Forward lanes run with s: right of the centre lane in right-hand traffic.
struct LaneLayout {
  int left = 1, right = 1;
  [[nodiscard]] int total() const { return left + right; }
};

/// By the tags lanes and oneway; untagged: as many lanes of a usual width as the median width has room for. An odd number
/// of lanes gives the additional one to the forward direction; a single lane used both ways becomes two narrow ones,
/// because OpenDRIVE gives a lane one direction.
[[nodiscard]] LaneLayout lane_layout(const RoadPath& path, double median_width_m, bool left_hand_traffic);

/// Fills sections and lane_offset: lanes together as wide as the carriageway and centred about the reference line.
void add_lanes(roadquery::Road& road, const LaneLayout& layout, std::span<const ProfileSample> widths, double tolerance_m);

/// Lane ids that drive along s (`forward`) or against it, from the inside out.
[[nodiscard]] std::vector<int> lanes_of_direction(const roadquery::Road& road, bool forward);

}  // namespace orthodrive::network
