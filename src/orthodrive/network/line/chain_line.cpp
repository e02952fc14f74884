// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/network/line/chain_line.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "orthodrive/network/line/lay_bends.hpp"

namespace orthodrive::network {
namespace {

constexpr double fade_m = 30.0;  // a height step of 0.3 m at a joint becomes a slope of 1 in 100 (1.5 in 100 at most)
constexpr double notable_step_m = 0.5;  // steps between the ends of a vertex that deserve a finding
constexpr double min_spacing_m = 0.25;
constexpr double max_spacing_m = 3.0;  // refine resamples to 2 m; coarser lines are filled up along their chords
// The inner edge of a bend keeps this radius; a smaller one where nodes would have to move too far for it.
constexpr std::array inner_radii_m{2.5, 1.5, 0.5};
constexpr int easing_passes = 200, max_easing_rounds = 20;
constexpr double eased_spacing_m = 1.5;  // nodes that easing drew nearer together are thinned out
constexpr double max_easing_m = 8.0;     // a node moves no further; what is sharper then stays sharp (a finding)
constexpr double notable_easing_m = 0.05, reported_easing_m = 1.0;

PieceNode& end_node(PieceLines& pieces, PieceEnd end) {
  std::vector<PieceNode>& nodes = pieces[end.piece];
  return end.at_last ? nodes.back() : nodes.front();
}

/// Of the line into its end.
Vec2 end_direction(const PieceLines& pieces, PieceEnd end) {
  const std::vector<PieceNode>& nodes = pieces[end.piece];
  const std::size_t n = nodes.size();
  if (n < 2) return {};
  return end.at_last ? nodes[n - 1].p - nodes[n - 2].p : nodes[0].p - nodes[1].p;
}
bool is_corner(const PieceLines& pieces, PieceEnd a, PieceEnd b) {
  const Vec2 in = end_direction(pieces, a), out = end_direction(pieces, b) * -1.0;
  return std::abs(std::atan2(cross(in, out), dot(in, out))) > corner_rad;
}

/// Adds a correction at one end that fades out smoothly (value and slope 0) inwards.
void fade_in(std::vector<PieceNode>& nodes, bool at_last, const PieceNode& correction) {
  const double total = nodes.back().s, reach = std::min(fade_m, total);
  for (PieceNode& node : nodes) {
    const double away = at_last ? total - node.s : node.s;
    if (away >= reach && reach > 0.0) continue;
    const double x = reach > 0.0 ? away / reach : 0.0, weight = 1.0 - x * x * (3.0 - 2.0 * x);
    node.p = node.p + correction.p * weight;
    node.z_m += correction.z_m * weight;
    node.banking += correction.banking * weight;
    node.width_m += correction.width_m * weight;
    node.crown += correction.crown * weight;
  }
}

std::vector<PieceNode> piece_nodes(const RoadPath& path, const PathPiece& piece) {
  std::vector<PieceNode> nodes;
  double s = 0.0;
  for (std::size_t i = piece.first; i <= piece.last; ++i) {
    const RoadNode& node = path.nodes[i];
    if (!nodes.empty()) s += distance(nodes.back().p, node.p);
    nodes.push_back({node.p, s, node.z_m, node.banking, node.width_m, node.crown});
  }
  return nodes;
}

/// The two ends of every place where a chain goes on from piece to piece.
std::vector<std::array<PieceEnd, 2>> through_pairs(const Topology& topology) {
  std::vector<std::array<PieceEnd, 2>> pairs;
  for (const Chain& chain : topology.chains)
    for (std::size_t k = 0; k < chain.pieces.size(); ++k) {
      if (k + 1 == chain.pieces.size() && !chain.closed) continue;
      const DirectedPiece a = chain.pieces[k], b = chain.pieces[(k + 1) % chain.pieces.size()];
      pairs.push_back({PieceEnd{a.piece, !a.reversed}, PieceEnd{b.piece, b.reversed}});
    }
  return pairs;
}

ChainLine concatenate(const Chain& chain, const PieceLines& pieces) {
  ChainLine line;
  for (const DirectedPiece part : chain.pieces) {
    std::vector<PieceNode> nodes = pieces[part.piece];
    if (part.reversed) {
      std::reverse(nodes.begin(), nodes.end());
      for (PieceNode& node : nodes) node.banking = -node.banking;
    }
    if (line.nodes.empty())
      line.joint.push_back(0);
    else
      line.nodes.back().width_after_m = nodes.front().width_m;
    for (std::size_t i = line.nodes.empty() ? 0 : 1; i < nodes.size(); ++i)
      line.nodes.push_back(
          {nodes[i].p, nodes[i].z_m, nodes[i].banking, nodes[i].width_m, nodes[i].width_m, nodes[i].crown});
    line.joint.push_back(line.nodes.size() - 1);
  }
  if (chain.closed) {
    line.nodes.front().width_before_m = line.nodes.back().width_before_m;
    line.nodes.back() = line.nodes.front();
  }
  return line;
}

/// Nodes closer than the spacing would spoil tangents. A joint takes the place of a node too near to it; two joints too
/// near to each other become one node.
void drop_near_nodes(ChainLine& line) {
  std::vector<bool> is_joint(line.nodes.size(), false), kept_is_joint;
  for (const std::size_t joint : line.joint) is_joint[joint] = true;
  std::vector<ChainLineNode> kept;
  std::vector<std::size_t> new_index;
  for (std::size_t i = 0; i < line.nodes.size(); ++i) {
    const ChainLineNode& node = line.nodes[i];
    if (kept.empty() || distance(kept.back().p, node.p) >= min_spacing_m) {
      kept.push_back(node);
      kept_is_joint.push_back(is_joint[i]);
    } else if (is_joint[i] && kept_is_joint.back()) {
      kept.back().width_after_m = node.width_after_m;
    } else if (is_joint[i]) {
      kept.back() = node;
      kept_is_joint.back() = true;
    }
    new_index.push_back(kept.size() - 1);
  }
  for (std::size_t& joint : line.joint) joint = new_index[joint];
  line.nodes = std::move(kept);
}

void fill_gaps(ChainLine& line) {
  std::vector<ChainLineNode> filled{line.nodes.front()};
  std::vector<std::size_t> new_index{0};
  for (std::size_t i = 1; i < line.nodes.size(); ++i) {
    const ChainLineNode &a = line.nodes[i - 1], &b = line.nodes[i];
    const int steps = static_cast<int>(std::ceil(distance(a.p, b.p) / max_spacing_m - 1e-9));
    for (int k = 1; k < steps; ++k) {
      const double x = static_cast<double>(k) / steps;
      const auto mix = [x](double u, double v) { return u + (v - u) * x; };
      const double width = mix(a.width_after_m, b.width_before_m);
      filled.push_back(
          {a.p + (b.p - a.p) * x, mix(a.z_m, b.z_m), mix(a.banking, b.banking), width, width, mix(a.crown, b.crown)});
    }
    filled.push_back(b);
    new_index.push_back(filled.size() - 1);
  }
  for (std::size_t& joint : line.joint) joint = new_index[joint];
  line.nodes = std::move(filled);
}

double turn_at(Vec2 a, Vec2 b, Vec2 c) { return std::abs(std::atan2(cross(b - a, c - b), dot(b - a, c - b))); }

/// Nodes of a line whose bends are being eased, each with where it was.
class BendEasing {
 public:
  BendEasing(ChainLine& line, bool closed, double inner_radius_m)
      : line_(line), closed_(closed), inner_radius_m_(inner_radius_m) {
    for (const ChainLineNode& node : line.nodes) original_.push_back(node.p), was_.push_back(was_.size());
  }

  /// Moves nodes of too sharp bends towards the chord of their neighbours until the circle through the three is wide
  /// enough. False: some are still too sharp.
  bool ease() {
    std::vector<ChainLineNode>& nodes = line_.nodes;
    bool sharp = true;
    for (int pass = 0; pass < easing_passes && sharp; ++pass) {
      sharp = false;
      for (std::size_t i = closed_ ? 0 : 1; i + 1 < nodes.size(); ++i) {
        const std::size_t before = i == 0 ? nodes.size() - 2 : i - 1, after = i + 1;
        if (!too_sharp(before, i, after)) continue;
        sharp = true;
        const Vec2 a = nodes[before].p, c = nodes[after].p;
        const double l1 = distance(a, nodes[i].p), l2 = distance(nodes[i].p, c);
        const Vec2 on_chord = a + (c - a) * (l1 + l2 > 0.0 ? l1 / (l1 + l2) : 0.5);
        const Vec2 moved = nodes[i].p + (on_chord - nodes[i].p) * 0.5;
        if (distance(moved, original_[i]) > max_easing_m) continue;
        nodes[i].p = moved;
        if (i == 0) nodes.back().p = moved;
      }
    }
    return !sharp;
  }

  /// Easing draws the nodes of a corner together, until no circle fits between them. False: nothing to take out.
  bool thin_out() {
    std::vector<bool> is_joint(line_.nodes.size(), false);
    for (const std::size_t joint : line_.joint) is_joint[joint] = true;
    ChainLine thinned;
    std::vector<std::size_t> kept, new_index;
    const auto moved = [&](std::size_t i) { return !is_joint[i] && distance_moved_m(i) > 0.0; };
    for (std::size_t i = 0; i < line_.nodes.size(); ++i) {
      const bool crowded = !kept.empty() && distance(line_.nodes[kept.back()].p, line_.nodes[i].p) < eased_spacing_m;
      if (crowded && is_joint[i] && moved(kept.back()))
        kept.pop_back();  // a joint takes the place of the node before it
      if (!crowded || !moved(i)) kept.push_back(i);
      new_index.push_back(kept.size() - 1);
    }
    std::vector<Vec2> original;
    std::vector<std::size_t> was;
    for (const std::size_t i : kept)
      thinned.nodes.push_back(line_.nodes[i]), original.push_back(original_[i]), was.push_back(was_[i]);
    if (thinned.nodes.size() == line_.nodes.size()) return false;
    for (std::size_t& joint : line_.joint) joint = new_index[joint];
    line_.nodes = std::move(thinned.nodes);
    original_ = std::move(original), was_ = std::move(was);
    return true;
  }

  /// Index before easing, of every node.
  [[nodiscard]] const std::vector<std::size_t>& was() const { return was_; }
  [[nodiscard]] int moved() const {
    int count = 0;
    for (std::size_t i = 0; i < original_.size(); ++i)
      count += distance(line_.nodes[i].p, original_[i]) > notable_easing_m ? 1 : 0;
    return count;
  }
  [[nodiscard]] std::size_t farthest() const {
    std::size_t far = 0;
    for (std::size_t i = 1; i < original_.size(); ++i) far = distance_moved_m(i) > distance_moved_m(far) ? i : far;
    return far;
  }
  [[nodiscard]] double distance_moved_m(std::size_t i) const { return distance(line_.nodes[i].p, original_[i]); }
  [[nodiscard]] std::optional<std::size_t> sharp_node() const {
    for (std::size_t i = 1; i + 1 < line_.nodes.size(); ++i)
      if (too_sharp(i - 1, i, i + 1)) return i;
    return std::nullopt;
  }

 private:
  [[nodiscard]] bool too_sharp(std::size_t before, std::size_t i, std::size_t after) const {
    const std::vector<ChainLineNode>& nodes = line_.nodes;
    const Vec2 a = nodes[before].p, b = nodes[i].p, c = nodes[after].p;
    const double min_radius = 0.25 * (nodes[i].width_before_m + nodes[i].width_after_m) + inner_radius_m_;
    return turn_at(a, b, c) * min_radius > 0.5 * (distance(a, b) + distance(b, c));
  }

  ChainLine& line_;
  bool closed_;
  double inner_radius_m_;
  std::vector<Vec2> original_;
  std::vector<std::size_t> was_;
};

/// False: some bends are still too sharp.
bool ease_all(BendEasing& easing) {
  for (int round = 0; round < max_easing_rounds; ++round) {
    if (easing.ease()) return true;
    if (!easing.thin_out()) break;
  }
  return !easing.sharp_node();
}

int ease_bends(ChainLine& line, bool closed, Findings& findings) {
  if (line.nodes.size() < 3) return 0;
  const ChainLine before = line;
  std::optional<BendEasing> eased;
  BendEasing* last = nullptr;
  for (const double inner_radius_m : inner_radii_m) {
    line = before;
    last = &eased.emplace(line, closed, inner_radius_m);
    if (ease_all(*last)) break;
  }
  BendEasing& easing = *last;
  const auto report = [&](Severity severity, const char* code, std::string message, Vec2 where) {
    findings.push_back({severity, code, std::move(message), where.x, where.y});
  };
  const std::size_t far = easing.farthest();
  if (easing.distance_moved_m(far) > reported_easing_m)
    report(Severity::info, "network.bend_eased",
           fmt::format("a bend sharper than the carriageway is wide was eased: its nodes move by up to {:.1f} m",
                       easing.distance_moved_m(far)),
           line.nodes[far].p);
  if (const auto sharp = easing.sharp_node())
    report(Severity::warning, "network.bend_too_sharp", "a bend is sharper than the carriageway is wide and stays so",
           line.nodes[*sharp].p);
  lay_bends(line.nodes, before.nodes, easing.was(), closed);
  return easing.moved();
}

}  // namespace

RoadNetwork with_heights(RoadNetwork roads, Findings& findings) {
  int flat = 0;
  Vec2 where;
  for (RoadPath& path : roads.paths) {
    std::vector<std::size_t> known;
    for (std::size_t i = 0; i < path.nodes.size(); ++i)
      if (std::isfinite(path.nodes[i].z_m)) known.push_back(i);
    if (known.empty() && !path.nodes.empty()) {
      if (flat++ == 0) where = path.nodes.front().p;
      for (RoadNode& node : path.nodes) node.z_m = 0.0;
      continue;
    }
    for (std::size_t i = 0; i < path.nodes.size(); ++i) {
      if (std::isfinite(path.nodes[i].z_m)) continue;
      const auto after = std::lower_bound(known.begin(), known.end(), i);
      const std::size_t b = after == known.end() ? known.back() : *after, a = after == known.begin() ? b : *(after - 1);
      const double span = path.nodes[b].s_m - path.nodes[a].s_m;
      const double x = span > 0.0 ? (path.nodes[i].s_m - path.nodes[a].s_m) / span : 0.0;
      path.nodes[i].z_m = path.nodes[a].z_m + (path.nodes[b].z_m - path.nodes[a].z_m) * std::clamp(x, 0.0, 1.0);
    }
  }
  if (flat > 0)
    findings.push_back({Severity::warning, "network.no_heights",
                        fmt::format("{} of {} paths have no heights and lie flat at z = 0; run the elevate stage first",
                                    flat, roads.paths.size()),
                        where.x, where.y});
  return roads;
}

PieceLines join_pieces(const RoadNetwork& roads, const Topology& topology, Findings& findings) {
  PieceLines pieces;
  for (const PathPiece& piece : topology.pieces) pieces.push_back(piece_nodes(roads.paths[piece.path], piece));
  Table<PieceIndex, std::array<PieceNode, 2>> correction(pieces.size());  // at the first and last node
  const auto correction_of = [&](PieceEnd end) -> PieceNode& { return correction[end.piece][end.at_last ? 1 : 0]; };

  for (const Vertex& vertex : topology.vertices) {
    double z = 0.0, low = INFINITY, high = -INFINITY, apart = 0.0;
    for (const PieceEnd& end : vertex.ends) {
      const PieceNode& node = end_node(pieces, end);
      z += node.z_m / static_cast<double>(vertex.ends.size());
      low = std::min(low, node.z_m), high = std::max(high, node.z_m);
      apart = std::max(apart, distance(node.p, vertex.p));
    }
    for (const PieceEnd& end : vertex.ends) {
      correction_of(end).p = vertex.p - end_node(pieces, end).p;
      correction_of(end).z_m = z - end_node(pieces, end).z_m;
    }
    if (high - low > notable_step_m || apart > 2.0 * notable_step_m)
      findings.push_back(
          {Severity::info, "network.ends_apart",
           fmt::format("{} road ends that meet lie up to {:.2f} m apart in height and {:.2f} m from their mean",
                       vertex.ends.size(), std::max(0.0, high - low), apart),
           vertex.p.x, vertex.p.y});
  }
  for (const auto& [a, b] : through_pairs(topology)) {
    const PieceNode &na = end_node(pieces, a), &nb = end_node(pieces, b);
    // Seen along a's path; b's path may run the other way, which turns left into right.
    const double sign = a.at_last != b.at_last ? 1.0 : -1.0, banking = 0.5 * (na.banking + sign * nb.banking);
    if (!is_corner(pieces, a, b)) {
      correction_of(a).banking = banking - na.banking;
      correction_of(b).banking = sign * banking - nb.banking;
    }
    correction_of(a).crown = 0.5 * (nb.crown - na.crown), correction_of(b).crown = 0.5 * (na.crown - nb.crown);
    const PathPiece& piece = topology.pieces[a.piece];
    if (topology.vertices[a.at_last ? piece.last_vertex : piece.first_vertex].is_junction()) continue;
    const double width = 0.5 * (na.width_m + nb.width_m);
    correction_of(a).width_m = width - na.width_m;
    correction_of(b).width_m = width - nb.width_m;
  }
  for (const PieceIndex i : pieces.indices()) {
    // Both computed from the untouched ends: over a piece longer than zero neither reaches the other end.
    fade_in(pieces[i], false, correction[i][0]);
    fade_in(pieces[i], true, correction[i][1]);
  }
  return pieces;
}

ChainLine chain_line(const Chain& chain, const PieceLines& pieces, int& eased, Findings& findings) {
  ChainLine line = concatenate(chain, pieces);
  drop_near_nodes(line);
  if (line.nodes.size() < 2) return line;
  fill_gaps(line);
  eased = ease_bends(line, chain.closed, findings);
  drop_near_nodes(line);  // easing draws nodes together
  return line;
}

}  // namespace orthodrive::network
