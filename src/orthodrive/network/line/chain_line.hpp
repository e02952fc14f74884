// SPDX-License-Identifier: Apache-2.0
#pragma once
// The nodes of a chain as one line that can be fitted: ends that should meet do meet, spacing is even enough, bends are
// not sharper than the carriageway is wide.

#include <vector>

#include "orthodrive/network/topology/topology.hpp"

namespace orthodrive::network {

/// Ways that meet at more than this have a plane in common there, not a banking.
inline constexpr double corner_rad = 0.35;

/// One place along a chain, directions along the chain.
struct ChainLineNode {
  Vec2 p;
  double z_m = 0.0;
  double banking = 0.0;  ///< rad, positive = left side (seen along the chain) higher
  /// Differ where two pieces meet in a junction: widths are only made equal where roads are linked directly.
  double width_before_m = 0.0, width_after_m = 0.0;
  double crown = 0.0;  ///< rad, RoadNode::crown
};

struct ChainLine {
  std::vector<ChainLineNode> nodes;  ///< closed chains end with a copy of the first node
  std::vector<std::size_t> joint;    ///< node index of every vertex along the chain: pieces + 1
};

/// Heights of paths without any become 0 (a finding), single missing ones are interpolated along their path.
[[nodiscard]] RoadNetwork with_heights(RoadNetwork roads, Findings& findings);

/// Nodes of every piece, in path direction, with their ends moved to where the pieces of a vertex meet: position and
/// height at all vertices; banking and crown where the chain goes on; width where two pieces are linked. The
/// corrections fade out smoothly over 30 m.
struct PieceNode {
  Vec2 p;
  double s = 0.0, z_m = 0.0, banking = 0.0, width_m = 0.0, crown = 0.0;
};
using PieceLines = Table<PieceIndex, std::vector<PieceNode>>;
[[nodiscard]] PieceLines join_pieces(const RoadNetwork& roads, const Topology& topology, Findings& findings);

/// Concatenates the pieces, drops nodes nearer than 0.25 m to their neighbour, fills gaps to 3 m and eases bends whose
/// radius is below half the width plus 1 m. `eased` counts the nodes moved by more than 5 cm.
[[nodiscard]] ChainLine chain_line(const Chain& chain, const PieceLines& pieces, int& eased, Findings& findings);

}  // namespace orthodrive::network
