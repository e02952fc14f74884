// SPDX-License-Identifier: Apache-2.0
#pragma once
// Roads that run beside each other: dual carriageways, service roads along a main road. Each keeps to its side.

#include <vector>

#include "orthodrive/model/roads/road_network.hpp"
#include "orthodrive/refine/cross_profiles.hpp"
#include "orthodrive/refine/fit_chain.hpp"
#include "orthodrive/refine/search_offsets.hpp"
#include "orthodrive/roads/road_chains.hpp"

namespace orthodrive::refine {

/// Another chain across from a node of a chain.
struct Neighbour {
  std::size_t node = 0;
  std::size_t chain = 0, segment = 0;  ///< the other one, and the node before the place
  double fraction = 0.0;               ///< 0..1 along that segment
  double base_m = 0.0;                 ///< of the other OSM line along the node's normal, positive to the left
  double alignment = 1.0;  ///< dot product of both normals: near +1, or -1 where they run against each other
  double median_m = 0.0;   ///< least width of what divides them: above 0 between the carriageways of a divided road
};

/// For every chain the nearest other one to the left and to the right of each node, where both run within 20 degrees of
/// each other, on the same layer, and not where they part or merge. Linear in the number of nodes.
[[nodiscard]] std::vector<std::vector<Neighbour>> find_neighbours(const std::vector<RoadChain>& chains,
                                                                  const RoadNetwork& osm);

/// Between this node and the next another road runs to the left (side +1) or right (-1), so near that both overlap on
/// the map: a slip road and the carriageway that it joins or leaves.
struct Merging {
  std::size_t node = 0;
  double side = 1.0;
};
[[nodiscard]] std::vector<std::vector<Merging>> find_merging(const std::vector<RoadChain>& chains,
                                                             const RoadNetwork& osm);

/// The labels show merging roads as one surface: takes what lies on the other's side of the expected line out of the
/// evidence, so that the edges on the far sides and the widths of both ways tell where they are. What lies there
/// further away than half of the widest that the road may be, and a sigma of the expected line, is no road of this
/// chain: else it could hide, whole, where nothing is heard of it.
void silence_merging(const RoadChain& chain, const std::vector<Merging>& merging,
                     const std::vector<ExpectedOffset>& expected, const RefineRoadsOptions& options,
                     CrossProfiles& profiles);

/// From where on another road lies, or the median before it, beyond edge_m along a node's normal, to its left (side +1)
/// or right (-1).
struct Occupied {
  std::size_t node = 0;
  double side = 1.0;
  double edge_m = 0.0;
  double overlap_m = 0.0;  ///< how far the chain's own edge is beyond that one: below 0 where they are apart
  bool yields = false;     ///< where both claim the same road, the chain that has left its own way for it yields
  double share = 0.5;      ///< of the overlap that is not the chain's: the further its edge strays to the other's side
                           ///< from that of the map, beside the other's, the more. Half where they are apart
};
[[nodiscard]] std::vector<Occupied> occupied_by_neighbours(std::size_t chain, const std::vector<RoadChain>& chains,
                                                           const std::vector<std::vector<Neighbour>>& neighbours,
                                                           const std::vector<ChainShape>& shapes);

/// Borders between a chain and its neighbours. Of the search: a chain that yields ends at the other's edge, any other
/// half way between both edges. Of the fit: the overlap is shared.
[[nodiscard]] std::vector<ChainCoupling::Limit> borders_of_search(const std::vector<Occupied>& occupied);
[[nodiscard]] std::vector<ChainCoupling::Limit> borders_of_fit(const std::vector<Occupied>& occupied);

/// Takes what lies beyond the borders out of the evidence: no road of this chain.
void mask_neighbours(const std::vector<ChainCoupling::Limit>& borders, CrossProfiles& profiles);

/// What holds the edges of a chain where those of its neighbours are near: the border, half way between them where they
/// are apart.
[[nodiscard]] std::vector<ChainCoupling::Limit> limits_of(const std::vector<Occupied>& occupied);

}  // namespace orthodrive::refine
