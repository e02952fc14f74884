// SPDX-License-Identifier: Apache-2.0
#pragma once
// What GPS traces say about the offset of a chain's nodes.

#include <vector>

#include "orthodrive/model/roads/gps_traces.hpp"
#include "orthodrive/model/roads/road_network.hpp"
#include "orthodrive/refine/parallel_roads.hpp"
#include "orthodrive/refine/refine_roads.hpp"
#include "orthodrive/refine/trace_offset.hpp"
#include "orthodrive/roads/road_chains.hpp"

namespace orthodrive::refine {

/// A trace without its points less than 3 m apart (a standing receiver that wanders), and its direction at each
/// segment, over +-10 m (0 where it turns round within that).
struct MovingTrace {
  Polyline line;
  std::vector<Vec2> direction;
  std::size_t recording = 0;
};
[[nodiscard]] std::vector<MovingTrace> moving_traces(const GpsTraces& traces);

/// A trace that passes a node of a chain along its road.
struct TracePass {
  std::size_t node = 0;
  std::size_t recording = 0;
  double offset_m = 0.0;               ///< where it crosses the node's normal
  double drive = 1.0;                  ///< +1 along the chain, -1 against it
  double right_m = 0.0, left_m = 0.0;  ///< beyond these offsets a parallel road is nearer
};

/// For every chain the traces that cross the normals of its nodes within 12 m and run within 30 degrees of it, ordered
/// by node; in oneway roads only those in the direction of the traffic, in tunnels none. Linear in the number of nodes.
[[nodiscard]] std::vector<std::vector<TracePass>> find_passes(const std::vector<RoadChain>& chains,
                                                              const RoadNetwork& osm,
                                                              const std::vector<MovingTrace>& traces,
                                                              const std::vector<std::vector<Neighbour>>& neighbours,
                                                              int threads);

/// One a node: the robust mean over the recordings that pass. A driver keeps to the side of a two-way road: the middle
/// is a quarter of the width beside the line driven, where two vehicles can pass each other. `width_m` is one per node;
/// `expected` (empty: 0) tells how far the map is shifted, and with it the borders between parallel roads. Empty where
/// no trace passes.
[[nodiscard]] std::vector<TraceOffset> trace_offsets(const RoadChain& chain, const RoadNetwork& osm,
                                                     const std::vector<TracePass>& passes,
                                                     const std::vector<double>& width_m,
                                                     const std::vector<ExpectedOffset>& expected,
                                                     const RefineRoadsOptions& options);

/// Both by the inverse of their variances; what the map says where no trace passes.
[[nodiscard]] std::vector<ExpectedOffset> combine(const std::vector<ExpectedOffset>& map,
                                                  const std::vector<TraceOffset>& traces);

}  // namespace orthodrive::refine
