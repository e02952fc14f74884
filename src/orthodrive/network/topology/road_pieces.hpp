// SPDX-License-Identifier: Apache-2.0
#pragma once
// Ways cut where they meet: pieces, and the vertices between them.

#include <cstdint>
#include <vector>

#include "orthodrive/core/finding.hpp"
#include "orthodrive/model/roads/parse_driving_side.hpp"
#include "orthodrive/model/roads/road_network.hpp"
#include "orthodrive/network/topology/typed_index.hpp"

namespace orthodrive::network {

/// The part of a path between two vertices.
struct PathPiece {
  std::size_t path = 0;
  std::size_t first = 0, last = 0;  ///< node indices in the path, both ends included
  VertexIndex first_vertex, last_vertex;
};

struct PieceEnd {
  PieceIndex piece;
  bool at_last = false;
  friend auto operator<=>(const PieceEnd&, const PieceEnd&) = default;
};

/// A piece in the direction in which it is passed.
struct DirectedPiece {
  PieceIndex piece;
  bool reversed = false;  ///< against the path
};

/// A place where paths end or meet.
struct Vertex {
  std::int64_t osm_node = 0;   ///< 0: an end that is no OSM node
  Vec2 p;                      ///< mean over the ends: paths are refined one by one and may disagree
  std::vector<PieceEnd> ends;  ///< in the order of the pieces
  /// Two ends whose lanes cannot simply be linked: two-way and one-way, more lanes than before, or the road turns back
  /// beside itself.
  bool lanes_shift = false;
  [[nodiscard]] bool is_junction() const { return ends.size() >= 3 || lanes_shift; }
};

struct RoadPieces {
  Table<PieceIndex, PathPiece> pieces;
  Table<VertexIndex, Vertex> vertices;
};

/// Dead ends shorter than 2 m at a junction are left out (a finding each).
[[nodiscard]] RoadPieces cut_into_pieces(const RoadNetwork& roads, DrivingSide driving_side, Findings& findings);

/// Node positions of a piece, along its path.
[[nodiscard]] Polyline points_of(const RoadNetwork& roads, const PathPiece& piece);
/// Unit vector from the vertex outwards along the piece.
[[nodiscard]] Vec2 outward(const RoadNetwork& roads, const RoadPieces& pieces, PieceEnd end);

[[nodiscard]] inline VertexIndex start_vertex(const RoadPieces& pieces, DirectedPiece part) {
  const PathPiece& piece = pieces.pieces[part.piece];
  return part.reversed ? piece.last_vertex : piece.first_vertex;
}
[[nodiscard]] inline VertexIndex end_vertex(const RoadPieces& pieces, DirectedPiece part) {
  return start_vertex(pieces, {part.piece, !part.reversed});
}

}  // namespace orthodrive::network
