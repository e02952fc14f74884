// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/network/topology/road_pieces.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <utility>

#include "orthodrive/core/median.hpp"
#include "orthodrive/model/roads/osm_node_id.hpp"
#include "orthodrive/network/lanes/lanes.hpp"
#include "orthodrive/roads/continuation.hpp"

namespace orthodrive::network {
namespace {

constexpr double stub_m = 2.0;  // shorter dead ends cannot be cut back at their junction

struct VertexTable {
  std::map<std::int64_t, VertexIndex> of_osm_node;
  Table<VertexIndex, Vertex>& vertices;

  VertexIndex find_or_add(std::int64_t osm_node) {
    if (is_osm_node(osm_node))
      if (const auto it = of_osm_node.find(osm_node); it != of_osm_node.end()) return it->second;
    const VertexIndex index = vertices.push_back({.osm_node = osm_node});
    if (is_osm_node(osm_node)) of_osm_node[osm_node] = index;
    return index;
  }
};

std::map<std::int64_t, int> count_visits(const RoadNetwork& roads) {
  std::map<std::int64_t, int> visits;
  for (const RoadPath& path : roads.paths) {
    std::int64_t previous = no_osm_node;
    for (const RoadNode& node : path.nodes) {
      if (is_osm_node(node.osm_node) && node.osm_node != previous) ++visits[node.osm_node];
      previous = node.osm_node;
    }
  }
  return visits;
}

RoadPieces split_paths(const RoadNetwork& roads) {
  RoadPieces result;
  const std::map<std::int64_t, int> visits = count_visits(roads);
  VertexTable table{{}, result.vertices};
  for (std::size_t p = 0; p < roads.paths.size(); ++p) {
    const std::vector<RoadNode>& nodes = roads.paths[p].nodes;
    if (nodes.size() < 2) continue;
    const bool closed = nodes.front().p == nodes.back().p;
    const VertexIndex start = table.find_or_add(nodes.front().osm_node);
    std::size_t first = 0;
    VertexIndex first_vertex = start;
    for (std::size_t i = 1; i < nodes.size(); ++i) {
      const RoadNode& node = nodes[i];
      const bool last = i + 1 == nodes.size();
      const bool repeated = is_osm_node(node.osm_node) && node.osm_node == nodes[i - 1].osm_node;
      const bool shared = is_osm_node(node.osm_node) && visits.at(node.osm_node) > 1 && !repeated;
      if (!last && !shared) continue;
      const VertexIndex vertex = last && closed ? start : table.find_or_add(node.osm_node);
      result.pieces.push_back({p, first, i, first_vertex, vertex});
      first = i, first_vertex = vertex;
    }
  }
  return result;
}

void collect_ends(RoadPieces& road_pieces) {
  for (Vertex& vertex : road_pieces.vertices) vertex.ends.clear();
  for (const PieceIndex i : road_pieces.pieces.indices()) {
    const PathPiece& piece = road_pieces.pieces[i];
    road_pieces.vertices[piece.first_vertex].ends.push_back({i, false});
    road_pieces.vertices[piece.last_vertex].ends.push_back({i, true});
  }
}

void drop_stubs(const RoadNetwork& roads, RoadPieces& road_pieces, Findings& findings) {
  const auto degree = [&](VertexIndex v) { return road_pieces.vertices[v].ends.size(); };
  Table<PieceIndex, PathPiece> kept;
  for (const PathPiece& piece : road_pieces.pieces) {
    const std::size_t a = degree(piece.first_vertex), b = degree(piece.last_vertex);
    const double piece_m = length_m(points_of(roads, piece));
    if (!(std::min(a, b) == 1 && std::max(a, b) >= 3 && piece_m < stub_m)) {
      kept.push_back(piece);
      continue;
    }
    const RoadPath& path = roads.paths[piece.path];
    const Vec2 p = path.nodes[piece.first].p;
    findings.push_back({Severity::info, "network.stub_dropped",
                        fmt::format("way {}: a dead end of {:.1f} m at a junction is left out", path.osm_id, piece_m),
                        p.x, p.y});
  }
  road_pieces.pieces = std::move(kept);
  collect_ends(road_pieces);
}

void place_vertices(const RoadNetwork& roads, RoadPieces& road_pieces) {
  for (Vertex& vertex : road_pieces.vertices) {
    Vec2 sum;
    for (const PieceEnd& end : vertex.ends) {
      const PathPiece& piece = road_pieces.pieces[end.piece];
      sum = sum + roads.paths[piece.path].nodes[end.at_last ? piece.last : piece.first].p;
    }
    if (!vertex.ends.empty()) vertex.p = sum * (1.0 / static_cast<double>(vertex.ends.size()));
  }
}

/// Lanes of a piece at one of its ends.
struct EndLanes {
  int in = 0, out = 0;  ///< driving to the vertex and away from it
  bool shared = false;  ///< the same lanes
};

EndLanes lanes_at(const RoadNetwork& roads, const RoadPieces& road_pieces, const PieceEnd& end,
                  DrivingSide driving_side) {
  const PathPiece& piece = road_pieces.pieces[end.piece];
  const RoadPath& path = roads.paths[piece.path];
  std::vector<double> widths;
  for (std::size_t i = piece.first; i <= piece.last; ++i) widths.push_back(path.nodes[i].width_m);
  const LaneLayout layout = lane_layout(path, median(std::move(widths)), driving_side);
  const bool left_hand = driving_side == DrivingSide::left;
  const int forward = layout.main_lanes(left_hand), backward = layout.main_lanes(!left_hand);
  return end.at_last ? EndLanes{forward, backward, layout.is_shared()}
                     : EndLanes{backward, forward, layout.is_shared()};
}

/// Of two ends.
bool turns_back(const RoadNetwork& roads, const RoadPieces& road_pieces, const Vertex& vertex) {
  const MeetingEnd a{outward(roads, road_pieces, vertex.ends[0])}, b{outward(roads, road_pieces, vertex.ends[1])};
  return bend_rad(a, b) >= piece_continuation.max_bend_alone_rad;
}

/// Two ends whose lanes cannot simply go on. Where a two-way road goes on as a one-way road, its lanes move sideways,
/// as they do where one lane for both directions goes on as one each. Where one with more lanes goes on, every new lane
/// has to be reached: OpenDRIVE wants a junction where it is not clear which lane follows which (1.7, 8.2). One-way
/// roads need none: their new lanes taper in beside the others. Where a road turns back beside itself, its lanes need a
/// way round; two one-way roads that both leave the node, or both end there, have none.
void find_lane_shifts(const RoadNetwork& roads, DrivingSide driving_side, RoadPieces& road_pieces) {
  for (Vertex& vertex : road_pieces.vertices) {
    if (vertex.ends.size() != 2) continue;
    const EndLanes a = lanes_at(roads, road_pieces, vertex.ends[0], driving_side);
    const EndLanes b = lanes_at(roads, road_pieces, vertex.ends[1], driving_side);
    const bool a_both = a.in > 0 && a.out > 0, b_both = b.in > 0 && b.out > 0;
    vertex.lanes_shift = a_both != b_both || a.shared != b.shared || (a_both && (b.out > a.in || a.out > b.in)) ||
                         (turns_back(roads, road_pieces, vertex) && (a.in > 0 || b.in > 0) && (a.out > 0 || b.out > 0));
  }
}

}  // namespace

RoadPieces cut_into_pieces(const RoadNetwork& roads, DrivingSide driving_side, Findings& findings) {
  RoadPieces pieces = split_paths(roads);
  collect_ends(pieces);
  drop_stubs(roads, pieces, findings);
  place_vertices(roads, pieces);
  find_lane_shifts(roads, driving_side, pieces);
  return pieces;
}

Polyline points_of(const RoadNetwork& roads, const PathPiece& piece) {
  const std::vector<RoadNode>& nodes = roads.paths[piece.path].nodes;
  Polyline points;
  for (std::size_t i = piece.first; i <= piece.last; ++i) points.push_back(nodes[i].p);
  return points;
}

Vec2 outward(const RoadNetwork& roads, const RoadPieces& pieces, PieceEnd end) {
  Polyline line = points_of(roads, pieces.pieces[end.piece]);
  if (end.at_last) std::reverse(line.begin(), line.end());
  return direction_into(line, piece_continuation);
}

}  // namespace orthodrive::network
