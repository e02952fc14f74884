#pragma once
// Roundabouts: told by their tag, or by one-way pieces that go round in the sense of the traffic.

#include <vector>

#include "orthodrive/network/topology.hpp"

namespace orthodrive::network {

/// Ways tagged as roundabouts whose end does not meet their beginning are closed along their circle where less than a third
/// of it is missing (finding network.roundabout_closed); others stay open one-way roads (network.roundabout_open). Rings
/// that the border of the area cuts are left as they are.
[[nodiscard]] RoadNetwork close_roundabouts(RoadNetwork roads, Findings& findings);

/// Circles of two-way roads that nothing says to be roundabouts: maps that lost their tags have them. Nobody builds a small
/// round of road with arms to be driven both ways, so it becomes a one-way road round the island, in the sense of the traffic
/// (finding network.roundabout_assumed). The ways of the ring have to be all ring: 30 to 200 m round, as round as a circle, with
/// three or more arms, none of them inside, no service roads.
[[nodiscard]] RoadNetwork assume_roundabouts(RoadNetwork roads, bool left_hand_traffic, Findings& findings);

/// For every piece the ring that it is part of, -1 for none. Rings are numbered in the order of their first piece.
[[nodiscard]] std::vector<int> find_rings(const RoadNetwork& roads, const Topology& topology, bool left_hand_traffic);

/// Moves the nodes of every ring, and the vertices on it, onto one smooth closed line: the distance from the centre of the
/// least squares circle becomes a constant and two waves round the ring (a shifted ellipse). Where entries and exits touch the
/// ring, refined lines bend towards them by some decimetres, and a ring that is fitted through that has corners. Rings that
/// are no such line within a tenth of their radius stay as they are.
void smooth_rings(RoadNetwork& roads, Topology& topology);

}  // namespace orthodrive::network
