// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/refine/parallel_roads.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <optional>
#include <utility>

#include "orthodrive/core/median.hpp"
#include "orthodrive/geo/spatial_index.hpp"
#include "orthodrive/model/roads/osm_node_id.hpp"

namespace orthodrive::refine {
namespace {

constexpr double parallel_reach_m = 25.0;      // two roads of 9 m, both 8 m off
constexpr double nearest_m = 3.0;              // OSM lines closer than that are one road that splits
constexpr double least_parallel_cos = 0.9397;  // cos 20 degrees, as the no-overlap constraint of Mattyus et al. 2015
constexpr double junction_m = 40.0;            // roads that split run into each other for about so far
constexpr double merge_m = 300.0;              // slip roads run beside the carriageway they join for at most so long
constexpr double watched_gap_m = 1.0;          // edges further apart need no limit
constexpr double least_strays_m = 0.1;         // keeps the share of an overlap steady where neither edge strays
// Maps draw two carriageways where something stands or grows between them. The narrowest is a barrier with two faces
// (0.6 m of concrete, 0.8 m of steel) and what keeps wheels off it; planted medians have 2.5 m and more (RAA 2008).
constexpr double least_median_m = 1.0;

std::vector<Polyline> base_lines(const std::vector<RoadChain>& chains) {
  std::vector<Polyline> lines(chains.size());
  for (std::size_t c = 0; c < chains.size(); ++c)
    for (const ChainNode& node : chains[c].nodes) lines[c].push_back(node.base);
  return lines;
}

/// Layer of every segment of a chain.
std::vector<int> layers_of(const RoadChain& chain, const RoadNetwork& osm) {
  std::vector<int> layers(chain.nodes.size(), 0);
  for (const ChainPiece& piece : chain.pieces)
    for (std::size_t i = piece.first; i < piece.last; ++i) layers[i] = osm.paths[piece.path].layer;
  if (layers.size() > 1) layers.back() = layers[layers.size() - 2];
  return layers;
}

/// Of every segment of a chain: traffic runs along it (+1) or against it (-1) alone, or both ways (0).
std::vector<int> traffic_of(const RoadChain& chain, const RoadNetwork& osm) {
  std::vector<int> traffic(chain.nodes.size(), 0);
  for (const ChainPiece& piece : chain.pieces)
    if (osm.paths[piece.path].oneway != Oneway::no)
      std::fill(traffic.begin() + static_cast<std::ptrdiff_t>(piece.first),
                traffic.begin() + static_cast<std::ptrdiff_t>(piece.last), piece.reversed ? -1 : 1);
  if (traffic.size() > 1) traffic.back() = traffic[traffic.size() - 2];
  return traffic;
}

/// Places along a chain of the OSM nodes that it shares with others.
using Meetings = std::vector<std::map<std::int64_t, double>>;

bool meet_near(const Meetings& meetings, std::size_t a, double s_a_m, std::size_t b, double s_b_m, double reach) {
  for (const auto& [id, s_m] : meetings[a]) {
    if (std::abs(s_m - s_a_m) > reach) continue;
    const auto other = meetings[b].find(id);
    if (other != meetings[b].end() && std::abs(other->second - s_b_m) <= reach) return true;
  }
  return false;
}

/// All chains with what finds those that run beside each other.
class ParallelRoads {
 public:
  ParallelRoads(const std::vector<RoadChain>& chains, const RoadNetwork& osm)
      : chains_(chains), index_(base_lines(chains)), meetings_(chains.size()) {
    for (std::size_t c = 0; c < chains.size(); ++c) {
      layers_.push_back(layers_of(chains[c], osm));
      traffic_.push_back(traffic_of(chains[c], osm));
      for (const ChainNode& node : chains[c].nodes)
        if (is_osm_node(node.osm_node)) meetings_[c].emplace(node.osm_node, node.s_m);
    }
  }

  /// Calls visit(neighbour, merges) for every other line that the normal of a node meets, within 20 degrees.
  template <typename Visit>
  void beside(std::size_t c, std::size_t i, const Visit& visit) const {
    const ChainNode& node = chains_[c].nodes[i];
    for (const auto [chain, segment] : index_.near(node.base, parallel_reach_m)) {
      if (chain == c || layers_[chain][segment] != layers_[c][i]) continue;
      const ChainNode &a = chains_[chain].nodes[segment], &b = chains_[chain].nodes[segment + 1];
      const Vec2 along = b.base - a.base;
      const double across = cross(along, node.normal);  // 0 where the other line runs along the normal
      if (across == 0.0) continue;
      const double fraction = cross(node.base - a.base, node.normal) / across;
      if (fraction < 0.0 || fraction >= 1.0) continue;
      const double t = dot(a.base + along * fraction - node.base, node.normal);
      const double alignment = dot(normalized(a.normal + (b.normal - a.normal) * fraction), node.normal);
      if (std::abs(t) > parallel_reach_m || std::abs(alignment) < least_parallel_cos) continue;
      const bool overlap = std::abs(t) < 0.5 * (node.input_width_m + a.input_width_m);
      const bool merges = meet_near(meetings_, c, node.s_m, chain, a.s_m, overlap ? merge_m : junction_m);
      const bool divided = traffic_[c][i] * traffic_[chain][segment] * alignment < 0.0;
      visit(Neighbour{i, chain, segment, fraction, t, alignment, divided ? least_median_m : 0.0}, merges);
    }
  }

 private:
  const std::vector<RoadChain>& chains_;
  SegmentIndex index_;
  std::vector<std::vector<int>> layers_, traffic_;
  Meetings meetings_;
};

}  // namespace

std::vector<std::vector<Merging>> find_merging(const std::vector<RoadChain>& chains, const RoadNetwork& osm) {
  const ParallelRoads parallel(chains, osm);
  std::vector<std::vector<Merging>> merging(chains.size());
  for (std::size_t c = 0; c < chains.size(); ++c)
    for (std::size_t i = 0; i + 1 < chains[c].nodes.size(); ++i)
      parallel.beside(c, i, [&](const Neighbour& other, bool merges) {
        const double widths_m =
            chains[c].nodes[i].input_width_m + chains[other.chain].nodes[other.segment].input_width_m;
        if (merges && std::abs(other.base_m) < 0.5 * widths_m)
          merging[c].push_back({i, other.base_m > 0.0 ? 1.0 : -1.0});
      });
  return merging;
}

void silence_merging(const RoadChain& chain, const std::vector<Merging>& merging,
                     const std::vector<ExpectedOffset>& expected, const RefineRoadsOptions& options,
                     CrossProfiles& profiles) {
  const std::size_t cells = static_cast<std::size_t>(profiles.cells);
  for (const auto& [node, side] : merging) {
    const ExpectedOffset line = expected.empty() ? ExpectedOffset{} : expected[node];
    const double half_m = 0.5 * max_width_factor(chain.nodes[node], options) * chain.nodes[node].input_width_m;
    for (std::size_t row = node * rows_per_segment; row < (node + 1) * rows_per_segment; ++row) {
      for (std::size_t k = 0; k < cells; ++k) {
        const double t = (static_cast<double>(k) + 0.5) * profiles.step_m - profiles.half_m;
        const double away_m = side * (t - line.offset_m);
        if (away_m <= 0.0) continue;
        profiles.false_positive[row * cells + k] = 0.0F;
        profiles.false_negative[row * cells + k] = away_m > half_m + line.sigma_m ? 1.0F : 0.0F;
      }
      profiles.look_again(row);
    }
  }
}

std::vector<std::vector<Neighbour>> find_neighbours(const std::vector<RoadChain>& chains, const RoadNetwork& osm) {
  const ParallelRoads parallel(chains, osm);
  std::vector<std::vector<Neighbour>> neighbours(chains.size());
  for (std::size_t c = 0; c < chains.size(); ++c)
    for (std::size_t i = 0; i < chains[c].nodes.size(); ++i) {
      std::optional<Neighbour> left, right;
      parallel.beside(c, i, [&](const Neighbour& other, bool merges) {
        if (merges || std::abs(other.base_m) < nearest_m) return;
        std::optional<Neighbour>& nearest = other.base_m > 0.0 ? left : right;
        if (!nearest || std::abs(other.base_m) < std::abs(nearest->base_m)) nearest = other;
      });
      for (const auto& found : {left, right})
        if (found) neighbours[c].push_back(*found);
    }
  return neighbours;
}

std::vector<Occupied> occupied_by_neighbours(std::size_t chain, const std::vector<RoadChain>& chains,
                                             const std::vector<std::vector<Neighbour>>& neighbours,
                                             const std::vector<ChainShape>& shapes) {
  std::vector<Occupied> occupied;
  if (neighbours[chain].empty()) return occupied;
  std::map<std::size_t, double> usual_m;  // median offset of a chain
  const auto strays_m = [&](std::size_t c, double offset_m) {
    const auto [it, fresh] = usual_m.try_emplace(c, 0.0);
    if (fresh) {
      std::vector<double> offsets = shapes[c].offset_m;
      it->second = median(std::move(offsets));
    }
    return offset_m - it->second;
  };
  const ChainShape& own = shapes[chain];
  for (const Neighbour& n : neighbours[chain]) {
    const auto value = [&](const std::vector<double>& of_nodes) {
      return of_nodes[n.segment] + n.fraction * (of_nodes[n.segment + 1] - of_nodes[n.segment]);
    };
    const double side = n.base_m > 0.0 ? 1.0 : -1.0;
    const double offset_m = value(shapes[n.chain].offset_m), width_m = value(shapes[n.chain].width_m);
    const double edge_m = n.base_m + n.alignment * offset_m - side * (0.5 * width_m + n.median_m);
    const double overlap_m = side * (own.offset_m[n.node] - edge_m) + 0.5 * own.width_m[n.node];
    const double own_strays_m = strays_m(chain, own.offset_m[n.node]), other_strays_m = strays_m(n.chain, offset_m);
    const bool yields = std::abs(own_strays_m) > std::abs(other_strays_m) ||
                        (std::abs(own_strays_m) == std::abs(other_strays_m) && chain > n.chain);
    const double own_grows_m = 0.5 * (own.width_m[n.node] - chains[chain].nodes[n.node].input_width_m);
    const double other_grows_m = 0.5 * (width_m - chains[n.chain].nodes[n.segment].input_width_m);
    const double own_beyond_m = std::max(0.0, side * own_strays_m + own_grows_m) + least_strays_m;
    const double other_beyond_m = std::max(0.0, other_grows_m - side * n.alignment * other_strays_m) + least_strays_m;
    const double share = overlap_m > 0.0 ? own_beyond_m / (own_beyond_m + other_beyond_m) : 0.5;
    occupied.push_back({n.node, side, edge_m, overlap_m, yields, share});
  }
  return occupied;
}

std::vector<ChainCoupling::Limit> borders_of_search(const std::vector<Occupied>& occupied) {
  std::vector<ChainCoupling::Limit> borders;
  borders.reserve(occupied.size());
  for (const Occupied& o : occupied)
    borders.push_back({o.node, o.side, o.edge_m + (o.yields ? 0.0 : o.side * 0.5 * std::max(0.0, o.overlap_m))});
  return borders;
}

std::vector<ChainCoupling::Limit> borders_of_fit(const std::vector<Occupied>& occupied) {
  std::vector<ChainCoupling::Limit> borders;
  borders.reserve(occupied.size());
  for (const Occupied& o : occupied)
    borders.push_back({o.node, o.side, o.edge_m + o.side * (1.0 - o.share) * std::max(0.0, o.overlap_m)});
  return borders;
}

void mask_neighbours(const std::vector<ChainCoupling::Limit>& borders, CrossProfiles& profiles) {
  const std::size_t cells = static_cast<std::size_t>(profiles.cells);
  for (const auto& [node, side, border_m] : borders) {
    for (std::size_t row = node * rows_per_segment;
         row < std::min((node + 1) * rows_per_segment, profiles.evidence.size()); ++row) {
      for (std::size_t k = 0; k < cells; ++k) {
        const double t = (static_cast<double>(k) + 0.5) * profiles.step_m - profiles.half_m;
        if (side * (t - border_m) <= 0.0) continue;
        profiles.false_positive[row * cells + k] = 0.0F;
        profiles.false_negative[row * cells + k] = 1.0F;
      }
      profiles.look_again(row);
    }
  }
}

std::vector<ChainCoupling::Limit> limits_of(const std::vector<Occupied>& occupied) {
  std::vector<ChainCoupling::Limit> limits;
  for (const Occupied& o : occupied)
    if (o.overlap_m > -watched_gap_m)
      limits.push_back({o.node, o.side, o.edge_m + o.side * (1.0 - o.share) * o.overlap_m});
  return limits;
}

}  // namespace orthodrive::refine
