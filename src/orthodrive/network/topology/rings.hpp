// SPDX-License-Identifier: Apache-2.0
#pragma once
// The rings of roundabouts among the pieces of way, and their smooth form.

#include <functional>
#include <vector>

#include "orthodrive/network/topology/road_pieces.hpp"

namespace orthodrive::network {

struct WalkRoundOptions {
  double side = 1.0;  ///< where the island lies: 1 left, -1 right
  double max_length_m = 0.0;
};
/// Pieces round an island, from `first` always keeping to its side until they are back; empty where they do not lead
/// back. `goes_on`: whether a ring may go from a piece into the piece of that end.
[[nodiscard]] std::vector<DirectedPiece> walk_round(
    const RoadNetwork& roads, const RoadPieces& pieces, DirectedPiece first, const WalkRoundOptions& options,
    const std::function<bool(DirectedPiece from, PieceEnd next)>& goes_on);

/// For every piece the ring that it is part of, -1 for none. Rings are numbered in the order of their first piece.
[[nodiscard]] Table<PieceIndex, int> find_rings(const RoadNetwork& roads, const RoadPieces& pieces,
                                                DrivingSide driving_side);

/// Moves the nodes of every ring, and the vertices on it, onto one smooth closed line: the distance from the centre of
/// the least squares circle becomes a constant and two waves round the ring (a shifted ellipse). Where entries and
/// exits touch the ring, refined lines bend towards them by some decimetres, and a ring that is fitted through that has
/// corners. Rings that are no such line within a tenth of their radius stay as they are.
void smooth_rings(const Table<PieceIndex, int>& ring_of_piece, RoadNetwork& roads, RoadPieces& pieces);

}  // namespace orthodrive::network
