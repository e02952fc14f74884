// SPDX-License-Identifier: Apache-2.0
#pragma once
// Roads that part at a node or come together there, as far as they share pavement: forks, slip roads, carriageways.

#include <vector>

#include "orthodrive/elevate/terrain/profile_chains.hpp"
#include "orthodrive/roads/path_junctions.hpp"

namespace orthodrive::elevate {

/// Places of two roads beside each other, on one pavement.
struct SharedPavement {
  std::size_t main_chain = 0, other_chain = 0;  ///< the main road has the higher class, then the greater width
  double main_s_m = 0.0, other_s_m = 0.0;       ///< along the chains
  double left_m = 0.0;  ///< of the other place from the main road, in the direction of the main road's path
  std::size_t main_path = 0, main_node = 0, other_path = 0, other_node = 0;  ///< nearest to the two places
};

/// Every 5 m along roads that leave one node within 40 degrees of each other, from 5 m after it until 3 m lie
/// between their carriageways (less is paved in a junction), at most 300 m: beyond that they are roads beside each
/// other. Ends where one of them changes its layer and the other does not.
[[nodiscard]] std::vector<SharedPavement> find_shared_pavement(const RoadNetwork& roads, const ProfileChains& chains,
                                                               const std::vector<PathJunction>& junctions);

}  // namespace orthodrive::elevate
