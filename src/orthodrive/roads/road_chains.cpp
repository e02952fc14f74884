// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/roads/road_chains.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <span>

#include "orthodrive/model/roads/highway_class.hpp"
#include "orthodrive/model/roads/osm_node_id.hpp"
#include "orthodrive/roads/path_crossings.hpp"
#include "orthodrive/roads/path_links.hpp"
#include "orthodrive/roads/ring_paths.hpp"

namespace orthodrive {
namespace {

/// Point of a polyline with known arc lengths at s; beyond the ends it clamps, or wraps when closed.
Vec2 point_along(std::span<const Vec2> line, std::span<const double> s, double at, bool closed) {
  const double total = s.back();
  if (closed && total > 0.0) at -= std::floor(at / total) * total;
  const auto it = std::upper_bound(s.begin(), s.end(), at);
  const auto i = std::clamp<std::ptrdiff_t>(it - s.begin() - 1, 0, std::ssize(line) - 2);
  const double length = s[i + 1] - s[i];
  return line[i] + (line[i + 1] - line[i]) * (length > 0.0 ? std::clamp((at - s[i]) / length, 0.0, 1.0) : 0.0);
}

/// Classes whose surface is what it happens to be: two ruts or a yard's drive; one-way roads above residential ones,
/// with or without shoulders, and rings.
bool is_of_any_width(const RoadPath& path, bool on_ring) {
  if (on_ring || path.highway == "service" || path.highway == "track") return true;
  return path.oneway == Oneway::forward && !is_raceway(path.highway) &&
         road_rank(path.highway) >= road_rank("tertiary_link");
}

/// Standard deviation of an input width as a share of it. Measured on hand-made carriageways: default widths err by a
/// fifth to a third; tags are of the carriageway in most cases, of the lanes alone or with pavements in some.
double width_sigma_share(const RoadPath& path, bool on_ring) {
  constexpr double of_any = 0.8;  // of a default width it may be twice as much
  if (path.width_source == WidthSource::tag) return 0.1;
  if (is_of_any_width(path, on_ring)) return of_any;
  return path.width_source == WidthSource::lanes ? 0.2 : 0.3;
}

/// The rings of a map, and how wide their carriageways are where no tag tells: that they have one lane does not.
class Rings {
 public:
  explicit Rings(const RoadNetwork& osm) : of_path_(rings_of_paths(osm)) {
    for (std::size_t p = 0; p < of_path_.size(); ++p)
      if (is_on(p)) length_m_[of_path_[p]] += length_m(centerline(osm.paths[p]));
  }
  [[nodiscard]] bool is_on(std::size_t path) const { return of_path_[path] >= 0; }
  [[nodiscard]] double width_m(std::size_t path) const { return usual_ring_width_m(length_m_.at(of_path_[path])); }

 private:
  std::vector<int> of_path_;
  std::map<int, double> length_m_;
};

RoadChain resample(const RoadNetwork& osm, const PathChain& paths, const std::map<std::int64_t, int>& incidences,
                   const Rings& rings, const ChainOptions& options) {
  RoadChain chain{.closed = paths.closed};
  for (const ChainPath& member : paths.paths) chain.pieces.push_back({member.path, member.reversed});
  Polyline osm_line;  // of the whole chain, without repeated points
  const auto append = [&](Vec2 p) {
    if (osm_line.empty() || !(osm_line.back() == p)) osm_line.push_back(p);
  };
  for (ChainPiece& piece : chain.pieces) {
    const RoadPath& path = osm.paths[piece.path];
    chain.rank = std::max(chain.rank, road_rank(path.highway));
    const double sigma_share = width_sigma_share(path, rings.is_on(piece.path));
    std::vector<RoadNode> nodes = path.nodes;
    if (piece.reversed) std::reverse(nodes.begin(), nodes.end());
    if (rings.is_on(piece.path) && path.width_source != WidthSource::tag)
      for (RoadNode& node : nodes) node.width_m = std::max(node.width_m, rings.width_m(piece.path));
    piece.first = chain.nodes.empty() ? 0 : chain.nodes.size() - 1;
    if (chain.nodes.empty())
      chain.nodes.push_back({.base = nodes.front().p,
                             .osm_node = nodes.front().osm_node,
                             .input_width_m = nodes.front().width_m,
                             .width_sigma_m = sigma_share * nodes.front().width_m});
    append(nodes.front().p);
    for (std::size_t begin = 0; begin + 1 < nodes.size();) {  // from kept node to kept node
      std::size_t end = begin + 1;
      while (end + 1 < nodes.size() && !(is_osm_node(nodes[end].osm_node) && incidences.at(nodes[end].osm_node) > 1))
        ++end;
      Polyline part;
      for (std::size_t i = begin; i <= end; ++i) part.push_back(nodes[i].p), append(nodes[i].p);
      const std::vector<double> s = arc_lengths_m(part);
      const int steps = std::max(1, static_cast<int>(std::lround(s.back() / options.spacing_m)));
      for (int step = 1; step <= steps; ++step)
        chain.nodes.push_back({.base = point_along(part, s, s.back() * step / steps, false),
                               .osm_node = step == steps ? nodes[end].osm_node : no_osm_node,
                               .input_width_m = nodes[begin].width_m,
                               .width_sigma_m = sigma_share * nodes[begin].width_m});
      begin = end;
    }
    piece.last = chain.nodes.size() - 1;
  }
  if (osm_line.size() < 2) osm_line.push_back(osm_line.front() + Vec2{1e-3, 0.0});
  const std::vector<double> line_s = arc_lengths_m(osm_line);
  const Polyline bases = [&] {
    Polyline line;
    for (const ChainNode& node : chain.nodes) line.push_back(node.base);
    return line;
  }();
  const std::vector<double> s = arc_lengths_m(bases);
  // Cut corners make the resampled line a little shorter than OSM's: scale, so that both windows slide together.
  const double stretch = s.back() > 0.0 ? line_s.back() / s.back() : 1.0;
  for (std::size_t i = 0; i < chain.nodes.size(); ++i) {
    const double at = s[i] * stretch, window = options.normal_window_m;
    const Vec2 ahead = point_along(osm_line, line_s, at + window, chain.closed);
    const Vec2 behind = point_along(osm_line, line_s, at - window, chain.closed);
    Vec2 direction = normalized(ahead - behind);
    if (length(direction) == 0.0) direction = i > 0 ? left_normal(chain.nodes[i - 1].normal) * -1.0 : Vec2{1.0, 0.0};
    chain.nodes[i].normal = left_normal(direction);
    chain.nodes[i].s_m = s[i];
  }
  return chain;
}

}  // namespace

ExpectedOffset combined(ExpectedOffset a, ExpectedOffset b) {
  constexpr double least_sigma_m = 1e-3;
  const double of_a = 1.0 / std::pow(std::max(least_sigma_m, a.sigma_m), 2),
               of_b = 1.0 / std::pow(std::max(least_sigma_m, b.sigma_m), 2);
  return {(of_a * a.offset_m + of_b * b.offset_m) / (of_a + of_b), 1.0 / std::sqrt(of_a + of_b)};
}

std::vector<RoadChain> build_chains(const RoadNetwork& osm, const ChainOptions& options) {
  std::map<std::int64_t, int> incidences;
  for (const RoadPath& path : osm.paths)
    for (const RoadNode& node : path.nodes)
      if (is_osm_node(node.osm_node)) ++incidences[node.osm_node];
  const Rings rings(osm);
  std::vector<RoadChain> chains;
  for (const PathChain& paths : chain_paths(osm, link_path_ends(osm)))
    chains.push_back(resample(osm, paths, incidences, rings, options));
  return chains;
}

namespace {

/// Which edges of a chain another road opens.
struct MaskedEdges {
  bool left = false, right = false;
};
constexpr MaskedEdges both_edges{true, true};

/// Those on whose side the roads of another chain leave a node. Both where the own chain ends there: its mouth opens to
/// both; and where they leave along it.
MaskedEdges edges_beside(const RoadChain& own, std::size_t own_node, const RoadChain& other, std::size_t other_node) {
  constexpr double look_m = 8.0;       // so far along the other road
  constexpr double least_sine = 0.26;  // 15 degrees
  if (!own.closed && (own_node == 0 || own_node + 1 == own.nodes.size())) return both_edges;
  const ChainNode &at = own.nodes[own_node], &from = other.nodes[other_node];
  MaskedEdges sides;
  const auto look = [&](std::ptrdiff_t step) {
    const auto last = std::ssize(other.nodes) - 1;
    std::ptrdiff_t i = static_cast<std::ptrdiff_t>(other_node);
    if (other.closed && (i == 0 || i == last)) i = step > 0 ? 0 : last;
    Vec2 way{0.0, 0.0};
    while (i + step >= 0 && i + step <= last && length(way) < look_m)
      i += step, way = other.nodes[static_cast<std::size_t>(i)].base - from.base;
    if (length(way) == 0.0) return;  // it ends here
    const double sine = dot(normalized(way), at.normal);
    if (sine > -least_sine) sides.left = true;
    if (sine < least_sine) sides.right = true;
  };
  look(+1), look(-1);
  return sides;
}

}  // namespace

void mask_evidence(std::vector<RoadChain>& chains, const RoadNetwork& osm) {
  constexpr double fillet_m = 3.0;  // corners of a mouth reach about this far beyond the other road's edge
  const auto mask_around = [](RoadChain& chain, double s_m, double radius_m, MaskedEdges sides) {
    const double total = chain.nodes.back().s_m;
    for (std::size_t i = 0; i + 1 < chain.nodes.size(); ++i) {
      double d = std::abs(0.5 * (chain.nodes[i].s_m + chain.nodes[i + 1].s_m) - s_m);
      if (chain.closed) d = std::min(d, total - d);
      if (d >= radius_m) continue;
      if (sides.left) chain.nodes[i].evidence.left = 0.0;
      if (sides.right) chain.nodes[i].evidence.right = 0.0;
    }
  };

  struct Incidence {
    std::size_t chain, node;
    double width_m;
  };
  std::map<std::int64_t, std::vector<Incidence>> junctions;
  for (std::size_t c = 0; c < chains.size(); ++c)
    for (std::size_t i = 0; i < chains[c].nodes.size(); ++i) {
      const ChainNode& node = chains[c].nodes[i];
      if (chains[c].closed && i + 1 == chains[c].nodes.size()) continue;
      if (is_osm_node(node.osm_node)) junctions[node.osm_node].push_back({c, i, node.input_width_m});
    }
  for (const auto& [id, incidences] : junctions)
    for (const Incidence& own : incidences)
      for (const Incidence& other : incidences)
        if (&other != &own)
          mask_around(chains[own.chain], chains[own.chain].nodes[own.node].s_m, 0.5 * other.width_m + fillet_m,
                      edges_beside(chains[own.chain], own.node, chains[other.chain], other.node));

  // Where a path lies in its chain: s along the chain of a distance along the path.
  struct PathOnChain {
    std::size_t chain, piece;
  };
  std::vector<PathOnChain> on_chain(osm.paths.size());
  for (std::size_t c = 0; c < chains.size(); ++c)
    for (std::size_t k = 0; k < chains[c].pieces.size(); ++k) {
      const ChainPiece& piece = chains[c].pieces[k];
      on_chain[piece.path] = {c, k};
      if (osm.paths[piece.path].tunnel)
        for (std::size_t i = piece.first; i < piece.last; ++i) chains[c].nodes[i].evidence = {0.0, 0.0};
    }
  const auto mask_crossing = [&](std::size_t path, Vec2 p, double other_width_m) {
    RoadChain& chain = chains[on_chain[path].chain];
    const ChainPiece& piece = chain.pieces[on_chain[path].piece];
    std::size_t nearest = piece.first;
    for (std::size_t i = piece.first; i <= piece.last; ++i)
      if (distance(chain.nodes[i].base, p) < distance(chain.nodes[nearest].base, p)) nearest = i;
    mask_around(chain, chain.nodes[nearest].s_m, 0.5 * other_width_m + fillet_m, both_edges);
  };
  for (const PathCrossing& crossing : find_crossings(osm)) {
    mask_crossing(crossing.path_a, crossing.p, osm.paths[crossing.path_b].nodes[crossing.segment_b].width_m);
    mask_crossing(crossing.path_b, crossing.p, osm.paths[crossing.path_a].nodes[crossing.segment_a].width_m);
  }
}

}  // namespace orthodrive
