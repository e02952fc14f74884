#pragma once
// Roundabouts: told by their tag, or by one-way pieces that go round in the sense of the traffic.

#include <vector>

#include "orthodrive/network/topology.hpp"

namespace orthodrive::network {

/// Ways tagged as roundabouts whose end does not meet their beginning are closed along their circle where less than a third
/// of it is missing (finding network.roundabout_closed); others stay open one-way roads (network.roundabout_open). Rings
/// that the border of the area cuts are left as they are.
[[nodiscard]] RoadNetwork close_roundabouts(RoadNetwork roads, Findings& findings);

/// For every piece the ring that it is part of, -1 for none. Rings are numbered in the order of their first piece.
[[nodiscard]] std::vector<int> find_rings(const RoadNetwork& roads, const Topology& topology, bool left_hand_traffic);

}  // namespace orthodrive::network
