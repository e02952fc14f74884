#pragma once
// Which pieces of path meet where, and which run on into each other.

#include <vector>

#include "orthodrive/core/finding.hpp"
#include "orthodrive/model/road_network.hpp"

namespace orthodrive::network {

/// A piece of a path between two vertices.
struct Piece {
  int path = 0;
  int first = 0, last = 0;  ///< node indices in the path, both ends included
  int first_vertex = 0, last_vertex = 0;
};

struct PieceEnd {
  int piece = -1;
  bool at_last = false;
};

/// A place where paths end or meet.
struct Vertex {
  std::int64_t osm_node = 0;   ///< 0: an end that is no OSM node
  Vec2 p;                      ///< mean over the ends: paths are refined one by one and may disagree
  std::vector<PieceEnd> ends;  ///< in the order of the pieces
  bool lanes_shift = false;    ///< two ends whose lanes cannot simply be linked: two-way and one-way, or more lanes than before
  [[nodiscard]] bool is_junction() const { return ends.size() >= 3 || lanes_shift; }
};

struct ChainPiece {
  int piece = 0;
  bool reversed = false;  ///< the chain runs against the path
};

/// Pieces that run on into each other: through vertices of two ends, and straight through junctions. A chain gets one
/// smooth reference line and profile, from which its roads and the way through its junctions are cut.
struct Chain {
  std::vector<ChainPiece> pieces;
  bool closed = false;  ///< starts at a junction if it touches one
};

struct Topology {
  std::vector<Piece> pieces;
  std::vector<int> ring_of_piece;  ///< index of the roundabout that a piece is part of, -1 for none
  std::vector<Vertex> vertices;
  std::vector<Chain> chains;
};

/// Dead ends shorter than 2 m at a junction are left out (a finding each).
[[nodiscard]] Topology build_topology(const RoadNetwork& roads, bool left_hand_traffic, Findings& findings);

/// Unit vector from the vertex outwards along the piece.
[[nodiscard]] Vec2 outward(const RoadNetwork& roads, const Topology& topology, PieceEnd end);

[[nodiscard]] inline int start_vertex(const Topology& t, ChainPiece c) {
  const Piece& piece = t.pieces[static_cast<std::size_t>(c.piece)];
  return c.reversed ? piece.last_vertex : piece.first_vertex;
}
[[nodiscard]] inline int end_vertex(const Topology& t, ChainPiece c) {
  return start_vertex(t, {c.piece, !c.reversed});
}

}  // namespace orthodrive::network
