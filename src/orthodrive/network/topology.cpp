#include "orthodrive/network/topology.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <tuple>

#include "orthodrive/network/lanes.hpp"
#include "orthodrive/network/roundabouts.hpp"

namespace orthodrive::network {
namespace {

constexpr double stub_m = 2.0;       // shorter dead ends cannot be cut back at their junction
constexpr double look_ahead_m = 8.0;  // directions at a vertex are taken this far out: the last node may jitter
// A pair of road ends runs on through a junction when it bends less than this; a way that turns off more sharply is
// joined by a turning road like any other.
constexpr double max_through_bend_rad = 40.0 * std::numbers::pi / 180.0;
constexpr double max_ring_bend_rad = 0.5 * std::numbers::pi;  // small roundabouts are drawn with few nodes

double piece_length_m(const RoadPath& path, const Piece& piece) {
  double sum = 0.0;
  for (int i = piece.first; i < piece.last; ++i)
    sum += distance(path.nodes[static_cast<std::size_t>(i)].p, path.nodes[static_cast<std::size_t>(i) + 1].p);
  return sum;
}

struct VertexTable {
  std::map<std::int64_t, int> of_osm_node;
  std::vector<Vertex>& vertices;

  int find_or_add(std::int64_t osm_node) {
    if (osm_node > 0)
      if (const auto it = of_osm_node.find(osm_node); it != of_osm_node.end()) return it->second;
    const int id = static_cast<int>(vertices.size());
    vertices.emplace_back().osm_node = osm_node;
    if (osm_node > 0) of_osm_node[osm_node] = id;
    return id;
  }
};

std::map<std::int64_t, int> count_visits(const RoadNetwork& roads) {
  std::map<std::int64_t, int> visits;
  for (const RoadPath& path : roads.paths) {
    std::int64_t previous = 0;
    for (const RoadNode& node : path.nodes) {
      if (node.osm_node > 0 && node.osm_node != previous) ++visits[node.osm_node];
      previous = node.osm_node;
    }
  }
  return visits;
}

void split_paths(const RoadNetwork& roads, Topology& topology) {
  const std::map<std::int64_t, int> visits = count_visits(roads);
  VertexTable table{{}, topology.vertices};
  for (std::size_t p = 0; p < roads.paths.size(); ++p) {
    const std::vector<RoadNode>& nodes = roads.paths[p].nodes;
    const int count = static_cast<int>(nodes.size());
    if (count < 2) continue;
    const bool closed = nodes.front().p == nodes.back().p;
    const int start = table.find_or_add(nodes.front().osm_node);
    int first = 0, first_vertex = start;
    for (int i = 1; i < count; ++i) {
      const RoadNode& node = nodes[static_cast<std::size_t>(i)];
      const bool last = i + 1 == count;
      const bool repeated = node.osm_node > 0 && node.osm_node == nodes[static_cast<std::size_t>(i) - 1].osm_node;
      const bool shared = node.osm_node > 0 && visits.at(node.osm_node) > 1 && !repeated;
      if (!last && !shared) continue;
      const int vertex = last && closed ? start : table.find_or_add(node.osm_node);
      topology.pieces.push_back({static_cast<int>(p), first, i, first_vertex, vertex});
      first = i, first_vertex = vertex;
    }
  }
}

void collect_ends(Topology& topology) {
  for (Vertex& vertex : topology.vertices) vertex.ends.clear();
  for (std::size_t i = 0; i < topology.pieces.size(); ++i) {
    const Piece& piece = topology.pieces[i];
    topology.vertices[static_cast<std::size_t>(piece.first_vertex)].ends.push_back({static_cast<int>(i), false});
    topology.vertices[static_cast<std::size_t>(piece.last_vertex)].ends.push_back({static_cast<int>(i), true});
  }
}

void drop_stubs(const RoadNetwork& roads, Topology& topology, Findings& findings) {
  const auto degree = [&](int v) { return topology.vertices[static_cast<std::size_t>(v)].ends.size(); };
  const auto is_stub = [&](const Piece& piece) {
    const std::size_t a = degree(piece.first_vertex), b = degree(piece.last_vertex);
    return std::min(a, b) == 1 && std::max(a, b) >= 3 &&
           piece_length_m(roads.paths[static_cast<std::size_t>(piece.path)], piece) < stub_m;
  };
  std::vector<Piece> kept;
  for (const Piece& piece : topology.pieces) {
    if (!is_stub(piece)) {
      kept.push_back(piece);
      continue;
    }
    const RoadPath& path = roads.paths[static_cast<std::size_t>(piece.path)];
    const Vec2 p = path.nodes[static_cast<std::size_t>(piece.first)].p;
    findings.push_back({Severity::info, "network.stub_dropped",
                        fmt::format("way {}: a dead end of {:.1f} m at a junction is left out", path.osm_id,
                                    piece_length_m(path, piece)),
                        p.x, p.y});
  }
  topology.pieces = std::move(kept);
  collect_ends(topology);
}

void place_vertices(const RoadNetwork& roads, Topology& topology) {
  for (Vertex& vertex : topology.vertices) {
    Vec2 sum;
    for (const PieceEnd& end : vertex.ends) {
      const Piece& piece = topology.pieces[static_cast<std::size_t>(end.piece)];
      const RoadPath& path = roads.paths[static_cast<std::size_t>(piece.path)];
      sum = sum + path.nodes[static_cast<std::size_t>(end.at_last ? piece.last : piece.first)].p;
    }
    if (!vertex.ends.empty()) vertex.p = sum * (1.0 / static_cast<double>(vertex.ends.size()));
  }
}

/// Lanes of a piece at one of its ends.
struct EndLanes {
  int in = 0, out = 0;  ///< driving to the vertex and away from it
};

EndLanes lanes_at(const RoadNetwork& roads, const Topology& topology, const PieceEnd& end, bool left_hand_traffic) {
  const Piece& piece = topology.pieces[static_cast<std::size_t>(end.piece)];
  const RoadPath& path = roads.paths[static_cast<std::size_t>(piece.path)];
  std::vector<double> widths;
  for (int i = piece.first; i <= piece.last; ++i) widths.push_back(path.nodes[static_cast<std::size_t>(i)].width_m);
  const auto middle = widths.begin() + static_cast<std::ptrdiff_t>(widths.size() / 2);
  std::nth_element(widths.begin(), middle, widths.end());
  const LaneLayout layout = lane_layout(path, *middle, left_hand_traffic);
  const int forward = left_hand_traffic ? layout.left : layout.right, backward = layout.total() - forward;
  return end.at_last ? EndLanes{forward, backward} : EndLanes{backward, forward};
}

/// Two ends whose lanes cannot simply go on. Where a two-way road goes on as a one-way road, its lanes move sideways. Where
/// one with more lanes goes on, every new lane has to be reached: OpenDRIVE wants a junction where it is not clear which
/// lane follows which (1.7, 8.2). One-way roads need none: their new lanes taper in beside the others.
void find_lane_shifts(const RoadNetwork& roads, bool left_hand_traffic, Topology& topology) {
  for (Vertex& vertex : topology.vertices) {
    if (vertex.ends.size() != 2) continue;
    const EndLanes a = lanes_at(roads, topology, vertex.ends[0], left_hand_traffic);
    const EndLanes b = lanes_at(roads, topology, vertex.ends[1], left_hand_traffic);
    const bool a_both = a.in > 0 && a.out > 0, b_both = b.in > 0 && b.out > 0;
    vertex.lanes_shift = a_both != b_both || (a_both && (b.out > a.in || a.out > b.in));
  }
}

}  // namespace

Vec2 outward(const RoadNetwork& roads, const Topology& topology, PieceEnd end) {
  const Piece& piece = topology.pieces[static_cast<std::size_t>(end.piece)];
  const std::vector<RoadNode>& nodes = roads.paths[static_cast<std::size_t>(piece.path)].nodes;
  Polyline line;
  for (int i = piece.first; i <= piece.last; ++i) line.push_back(nodes[static_cast<std::size_t>(i)].p);
  if (end.at_last) std::reverse(line.begin(), line.end());
  const double reach = std::min(look_ahead_m, 0.5 * length_m(line));
  return normalized(point_at(line, reach) - line.front());
}

namespace {

/// For every end of a vertex the end that its road runs on into, -1 for none. Two ends always run on. At a junction:
/// the ring of a roundabout first, then pieces of one way, then the straightest, ties to the lower index.
std::vector<int> pair_ends(const RoadNetwork& roads, const Topology& topology, const Vertex& vertex) {
  const int count = static_cast<int>(vertex.ends.size());
  std::vector<int> partner(vertex.ends.size(), -1);
  if (count == 2) return {1, 0};
  if (count < 2) return partner;
  std::vector<Vec2> direction;
  for (const PieceEnd& end : vertex.ends) direction.push_back(outward(roads, topology, end));
  const auto ring = [&](int k) {
    return topology.ring_of_piece[static_cast<std::size_t>(vertex.ends[static_cast<std::size_t>(k)].piece)];
  };
  std::vector<std::tuple<bool, bool, double, int, int>> candidates;  // no ring, other way, bend, ends
  for (int i = 0; i < count; ++i)
    for (int j = i + 1; j < count; ++j) {
      const Vec2 a = direction[static_cast<std::size_t>(i)] * -1.0, b = direction[static_cast<std::size_t>(j)];
      const double bend = std::abs(std::atan2(cross(a, b), dot(a, b)));
      const bool same_ring = ring(i) >= 0 && ring(i) == ring(j);
      if (!(bend < (same_ring ? max_ring_bend_rad : max_through_bend_rad))) continue;
      const auto path = [&](int k) {
        return topology.pieces[static_cast<std::size_t>(vertex.ends[static_cast<std::size_t>(k)].piece)].path;
      };
      candidates.emplace_back(!same_ring, path(i) != path(j), bend, i, j);
    }
  std::sort(candidates.begin(), candidates.end());
  for (const auto& [no_ring, other, bend, i, j] : candidates) {
    if (partner[static_cast<std::size_t>(i)] >= 0 || partner[static_cast<std::size_t>(j)] >= 0) continue;
    partner[static_cast<std::size_t>(i)] = j;
    partner[static_cast<std::size_t>(j)] = i;
  }
  return partner;
}

class ChainBuilder {
 public:
  ChainBuilder(const RoadNetwork& roads, Topology& topology) : topology_(topology), used_(topology.pieces.size(), false) {
    next_[0].assign(topology.pieces.size(), PieceEnd{});
    next_[1].assign(topology.pieces.size(), PieceEnd{});
    for (const Vertex& vertex : topology.vertices) {
      const std::vector<int> partner = pair_ends(roads, topology, vertex);
      for (std::size_t i = 0; i < partner.size(); ++i)
        if (partner[i] >= 0) next(vertex.ends[i]) = vertex.ends[static_cast<std::size_t>(partner[i])];
    }
  }

  void build() {
    // Open chains from their loose ends first, so that what remains is closed; closed ones start at a junction.
    for (std::size_t i = 0; i < topology_.pieces.size(); ++i)
      for (const bool at_last : {false, true})
        if (!used_[i] && next({static_cast<int>(i), at_last}).piece < 0) follow({static_cast<int>(i), at_last}, false);
    for (const bool junctions_only : {true, false})
      for (std::size_t i = 0; i < topology_.pieces.size(); ++i)
        for (const bool at_last : {false, true}) {
          const Piece& piece = topology_.pieces[i];
          const int start = at_last ? piece.last_vertex : piece.first_vertex;
          if (!used_[i] && (!junctions_only || topology_.vertices[static_cast<std::size_t>(start)].is_junction()))
            follow({static_cast<int>(i), at_last}, true);
        }
  }

 private:
  PieceEnd& next(PieceEnd end) { return next_[end.at_last ? 1 : 0][static_cast<std::size_t>(end.piece)]; }

  /// From the piece that is entered at `entry` until the chain ends or comes back to it.
  void follow(PieceEnd entry, bool closed) {
    Chain chain;
    chain.closed = closed;
    while (entry.piece >= 0 && !used_[static_cast<std::size_t>(entry.piece)]) {
      used_[static_cast<std::size_t>(entry.piece)] = true;
      chain.pieces.push_back({entry.piece, entry.at_last});
      entry = next({entry.piece, !entry.at_last});
    }
    topology_.chains.push_back(std::move(chain));
  }

  Topology& topology_;
  std::vector<bool> used_;
  std::vector<PieceEnd> next_[2];
};

}  // namespace

Topology build_topology(const RoadNetwork& roads, bool left_hand_traffic, Findings& findings) {
  Topology topology;
  split_paths(roads, topology);
  collect_ends(topology);
  drop_stubs(roads, topology, findings);
  place_vertices(roads, topology);
  find_lane_shifts(roads, left_hand_traffic, topology);
  topology.ring_of_piece = find_rings(roads, topology, left_hand_traffic);
  ChainBuilder(roads, topology).build();
  return topology;
}

}  // namespace orthodrive::network
