// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/network/topology/topology.hpp"

#include <optional>
#include <utility>

#include "orthodrive/network/topology/rings.hpp"
#include "orthodrive/roads/walk_chains.hpp"

namespace orthodrive::network {
namespace {

EndLinks<PieceEnd> link_piece_ends(const RoadNetwork& roads, const Topology& topology, const ContinuationRule& rule) {
  EndLinks<PieceEnd> links;
  for (const Vertex& vertex : topology.vertices) {
    std::vector<MeetingEnd> meeting;
    meeting.reserve(vertex.ends.size());
    for (const PieceEnd& end : vertex.ends)
      meeting.push_back({outward(roads, topology, end), &roads.paths[topology.pieces[end.piece].path],
                         topology.ring_of_piece[end.piece], end.at_last});
    const std::vector<std::optional<std::size_t>> partner = pair_ends(meeting, vertex.ends.size() == 2, rule);
    for (std::size_t i = 0; i < partner.size(); ++i)
      if (const std::optional<std::size_t>& other = partner[i]) links[vertex.ends[i]] = vertex.ends[*other];
  }
  return links;
}

Table<ChainIndex, Chain> walk_pieces(const Topology& topology, const EndLinks<PieceEnd>& links) {
  const auto is_at_junction = [&](PieceEnd end) {
    return topology.vertices[start_vertex(topology, {end.piece, end.at_last})].is_junction();
  };
  Table<ChainIndex, Chain> chains;
  for (const WalkedChain<PieceEnd>& walked :
       ChainWalk<PieceEnd>(topology.pieces.size(), links).open_ones_first(is_at_junction)) {
    Chain chain{.closed = walked.closed};
    for (const PieceEnd entry : walked.entries) chain.pieces.push_back({entry.piece, entry.at_last});
    chains.push_back(std::move(chain));
  }
  return chains;
}

}  // namespace

Topology build_topology(const RoadNetwork& roads, DrivingSide driving_side, Findings& findings,
                        const ContinuationRule& rule) {
  Topology topology{cut_into_pieces(roads, driving_side, findings)};
  topology.ring_of_piece = find_rings(roads, topology, driving_side);
  topology.chains = walk_pieces(topology, link_piece_ends(roads, topology, rule));
  return topology;
}

}  // namespace orthodrive::network
