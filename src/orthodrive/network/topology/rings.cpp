// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/network/topology/rings.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "orthodrive/geo/roundness.hpp"
#include "orthodrive/math/cholesky.hpp"
#include "orthodrive/model/roads/highway_class.hpp"
#include "orthodrive/network/curves/fit_circle.hpp"

namespace orthodrive::network {
namespace {

constexpr double max_ring_m = 400.0;  // round the island; the largest roundabouts have 120 m across
constexpr double min_ring_m = 20.0;   // a mini-roundabout of 3 m radius
// Area over that of a circle of the same circumference: 0.785 for a square, 0.95 for an octagon, 0.83 for a regular
// pentagon with rounded corners. A block with one-way streets round it is no roundabout.
constexpr double min_roundness = 0.85, min_tagged_roundness = 0.6;

/// One-way pieces round islands.
class RingFinder {
 public:
  RingFinder(const RoadNetwork& roads, const RoadPieces& pieces, DrivingSide driving_side)
      : roads_(roads),
        pieces_(pieces),
        side_(driving_side == DrivingSide::left ? -1.0 : 1.0),
        ring_of_(pieces.pieces.size(), -1) {}

  Table<PieceIndex, int> run() {
    int rings = 0;
    for (const PieceIndex first : pieces_.pieces.indices()) {
      if (ring_of_[first] >= 0 || !may_ring(first)) continue;
      const auto goes_on = [&](DirectedPiece, PieceEnd next) {
        return !next.at_last && may_ring(next.piece) && (path_of(next.piece).roundabout || !path_of(first).roundabout);
      };
      const std::vector<DirectedPiece> round =
          walk_round(roads_, pieces_, {first, false}, {.side = side_, .max_length_m = max_ring_m}, goes_on);
      if (!is_roundabout(round)) continue;
      for (const DirectedPiece part : round) ring_of_[part.piece] = rings;
      ++rings;
    }
    return std::move(ring_of_);
  }

 private:
  [[nodiscard]] const RoadPath& path_of(PieceIndex piece) const { return roads_.paths[pieces_.pieces[piece].path]; }
  [[nodiscard]] bool may_ring(PieceIndex piece) const {
    return path_of(piece).oneway == Oneway::forward && !is_raceway(path_of(piece).highway);
  }
  [[nodiscard]] bool is_roundabout(const std::vector<DirectedPiece>& round) const {
    Ring ring;
    double length = 0.0;
    bool tagged = !round.empty();
    for (const DirectedPiece part : round) {
      const Polyline points = points_of(roads_, pieces_.pieces[part.piece]);
      ring.insert(ring.end(), points.begin(), points.end() - 1);
      length += length_m(points);
      tagged = tagged && path_of(part.piece).roundabout;
    }
    if (length < min_ring_m) return false;
    return side_ * roundness(ring) > (tagged ? min_tagged_roundness : min_roundness);
  }

  const RoadNetwork& roads_;
  const RoadPieces& pieces_;
  double side_;
  Table<PieceIndex, int> ring_of_;
};

constexpr std::size_t waves = 5;        // 1, cos a, sin a, cos 2a, sin 2a
constexpr double max_ring_error = 0.1;  // of the radius

std::array<double, waves> wave_values(double angle) {
  return {1.0, std::cos(angle), std::sin(angle), std::cos(2.0 * angle), std::sin(2.0 * angle)};
}

/// The distance from the centre as a sum of waves of the angle, by least squares. nullopt for points of too few angles.
std::optional<std::array<double, waves>> fit_waves(const std::vector<Vec2>& points, Vec2 center) {
  double normal[waves][waves] = {};
  std::array<double, waves> result{};
  for (const Vec2 p : points) {
    const Vec2 d = p - center;
    const auto w = wave_values(std::atan2(d.y, d.x));
    for (std::size_t i = 0; i < waves; ++i) {
      for (std::size_t k = 0; k <= i; ++k) normal[i][k] += w[i] * w[k];
      result[i] += w[i] * length(d);
    }
  }
  const SymmetricMatrix a = SymmetricMatrix::dense(&normal[0][0], waves, waves);
  if (!factorize(a, {.absolute = 1e-6})) return std::nullopt;
  solve_factored(a, result);
  return result;
}

struct PathNode {
  std::size_t path = 0, node = 0;
  friend auto operator<=>(const PathNode&, const PathNode&) = default;
};

/// A ring's nodes, each once.
std::vector<PathNode> ring_nodes(const Table<PieceIndex, int>& ring_of_piece, const RoadPieces& pieces, int ring) {
  std::vector<PathNode> nodes;
  for (const PieceIndex i : pieces.pieces.indices()) {
    const PathPiece& piece = pieces.pieces[i];
    if (ring_of_piece[i] != ring) continue;
    for (std::size_t k = piece.first; k <= piece.last; ++k) nodes.push_back({piece.path, k});
  }
  std::sort(nodes.begin(), nodes.end());
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  return nodes;
}

}  // namespace

std::vector<DirectedPiece> walk_round(const RoadNetwork& roads, const RoadPieces& pieces, DirectedPiece first,
                                      const WalkRoundOptions& options,
                                      const std::function<bool(DirectedPiece from, PieceEnd next)>& goes_on) {
  const auto piece_length_m = [&](DirectedPiece part) {
    Polyline points = points_of(roads, pieces.pieces[part.piece]);
    if (part.reversed) std::reverse(points.begin(), points.end());
    return length_m(points);
  };
  std::vector<DirectedPiece> round{first};
  double length = piece_length_m(first);
  for (;;) {
    const DirectedPiece last = round.back();
    const VertexIndex vertex = end_vertex(pieces, last);
    if (vertex == start_vertex(pieces, first)) return round;
    const Vec2 in = outward(roads, pieces, {last.piece, !last.reversed}) * -1.0;
    DirectedPiece best;
    double best_turn = -INFINITY;
    for (const PieceEnd& end : pieces.vertices[vertex].ends) {
      if (!goes_on(last, end)) continue;
      const Vec2 out = outward(roads, pieces, end);
      const double turn = options.side * std::atan2(cross(in, out), dot(in, out));
      if (turn > best_turn) best = {end.piece, end.at_last}, best_turn = turn;
    }
    if (!best.piece) return {};
    length += piece_length_m(best);
    if (length > options.max_length_m || round.size() > pieces.pieces.size()) return {};  // pieces may have no length
    round.push_back(best);
  }
}

Table<PieceIndex, int> find_rings(const RoadNetwork& roads, const RoadPieces& pieces, DrivingSide driving_side) {
  return RingFinder(roads, pieces, driving_side).run();
}

void smooth_rings(const Table<PieceIndex, int>& ring_of_piece, RoadNetwork& roads, RoadPieces& pieces) {
  int rings = 0;
  for (const int ring : ring_of_piece) rings = std::max(rings, ring + 1);
  for (int ring = 0; ring < rings; ++ring) {
    const std::vector<PathNode> nodes = ring_nodes(ring_of_piece, pieces, ring);
    const auto place = [&](PathNode node) -> Vec2& { return roads.paths[node.path].nodes[node.node].p; };
    std::vector<Vec2> points;
    points.reserve(nodes.size());
    for (const PathNode node : nodes) points.push_back(place(node));
    const std::optional<Circle> circle = fit_circle(points);
    const auto radius = circle ? fit_waves(points, circle->center) : std::nullopt;
    if (!radius) continue;
    const auto moved = [&](Vec2 p) {
      const Vec2 d = p - circle->center;
      const auto w = wave_values(std::atan2(d.y, d.x));
      double r = 0.0;
      for (std::size_t i = 0; i < waves; ++i) r += (*radius)[i] * w[i];
      return circle->center + normalized(d) * r;
    };
    const bool fits = std::all_of(points.begin(), points.end(),
                                  [&](Vec2 p) { return distance(p, moved(p)) <= max_ring_error * circle->radius_m; });
    if (!fits) continue;
    for (const PathNode node : nodes) place(node) = moved(place(node));
    for (const PieceIndex i : pieces.pieces.indices()) {
      if (ring_of_piece[i] != ring) continue;
      const PathPiece& piece = pieces.pieces[i];
      pieces.vertices[piece.first_vertex].p = place({piece.path, piece.first});
      pieces.vertices[piece.last_vertex].p = place({piece.path, piece.last});
    }
  }
}

}  // namespace orthodrive::network
