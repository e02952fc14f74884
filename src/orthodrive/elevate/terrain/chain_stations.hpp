// SPDX-License-Identifier: Apache-2.0
#pragma once
// Roads as they are driven: the nodes of ways that continue each other in one row, with the shape of the line.

#include <cstddef>
#include <vector>

#include "orthodrive/model/roads/road_network.hpp"

namespace orthodrive {

/// A place of a chain, seen in the chain's direction. Nodes on one spot (where ways join, or doubled) are one station.
struct Station {
  Vec2 p;
  Vec2 along;  ///< unit tangent of the smoothed line
  double s_m = 0.0;
  double curvature_1pm = 0.0;  ///< of the line smoothed over tens of metres; positive = left
  double half_width_m = 0.0;
  double z_m = 0.0;  ///< NaN where the profile is unknown
  double gradient = 0.0;
  std::size_t path = 0;
  bool against = false;  ///< the chain runs against the path
  bool bridge = false, tunnel = false;
};

struct StationChain {
  std::vector<Station> stations;  ///< closed: the first is not repeated
  bool closed = false;
  double length_m = 0.0;  ///< closed: all the way round
  int rank = 0;           ///< highest road_rank of its paths
};

/// Where a node of a path is found, and the sign of angles across the road there.
struct StationOfNode {
  std::size_t chain = 0, station = 0;
  double sign = 1.0;  ///< -1 where the chain runs against the path
};

struct NetworkStations {
  std::vector<StationChain> chains;                 ///< in the order of chain_paths
  std::vector<std::vector<StationOfNode>> of_node;  ///< [path][node]
};

[[nodiscard]] NetworkStations make_stations(const RoadNetwork& roads);

/// Distance from station i to the next one; the last of a closed chain goes on to the first.
[[nodiscard]] double step_m(const StationChain& chain, std::size_t i);

}  // namespace orthodrive
