// SPDX-License-Identifier: Apache-2.0
#pragma once
// Which pieces of path run on into each other.

#include <vector>

#include "orthodrive/network/topology/road_pieces.hpp"
#include "orthodrive/roads/continuation.hpp"

namespace orthodrive::network {

/// Pieces that run on into each other: through vertices of two ends, and straight through junctions. A chain gets one
/// smooth reference line and profile, from which its roads and the way through its junctions are cut.
struct Chain {
  std::vector<DirectedPiece> pieces;
  bool closed = false;  ///< starts at a junction if it touches one
};

struct Topology : RoadPieces {
  Table<PieceIndex, int> ring_of_piece;  ///< index of the roundabout that a piece is part of, -1 for none
  Table<ChainIndex, Chain> chains;
};

/// Findings: those of cut_into_pieces.
[[nodiscard]] Topology build_topology(const RoadNetwork& roads, DrivingSide driving_side, Findings& findings,
                                      const ContinuationRule& rule = piece_continuation);

}  // namespace orthodrive::network
