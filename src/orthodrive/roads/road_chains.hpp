// SPDX-License-Identifier: Apache-2.0
#pragma once
// Chains: ways that continue each other, resampled, so that position and width run smoothly from way to way.

#include <cstddef>
#include <cstdint>
#include <vector>

#include "orthodrive/model/roads/road_network.hpp"

namespace orthodrive {

/// 0..1: how much the labels count for each edge of a road.
struct EdgeEvidence {
  double left = 1.0, right = 1.0;
  [[nodiscard]] double both() const { return left < right ? left : right; }
  [[nodiscard]] double mean() const { return 0.5 * (left + right); }
};

struct ChainNode {
  Vec2 base;    ///< on the OSM line
  Vec2 normal;  ///< unit, to the left; of the line smoothed over some metres, so that neighbours do not cross
  std::int64_t osm_node = 0;  ///< kept where paths meet or end
  double s_m = 0.0;           ///< along the OSM line
  double input_width_m = 0.0;
  double width_sigma_m = 0.0;  ///< standard deviation of the input width, by where it comes from
  EdgeEvidence evidence;       ///< between this node and the next
};

/// What the roads around a node say about its offset.
struct ExpectedOffset {
  double offset_m = 0.0, sigma_m = 0.0;
};
/// Both by the inverse of their variances.
[[nodiscard]] ExpectedOffset combined(ExpectedOffset a, ExpectedOffset b);

/// A path, or a part of a chain that is a path, in the chain's direction or against it.
struct ChainPiece {
  std::size_t path = 0;
  bool reversed = false;
  std::size_t first = 0, last = 0;  ///< nodes of the chain, both included
};

struct RoadChain {
  std::vector<ChainNode> nodes;  ///< closed: the last node repeats the first
  bool closed = false;
  int rank = 0;  ///< highest road_rank of its paths
  std::vector<ChainPiece> pieces;
};

struct ChainOptions {
  double spacing_m = 2.0;
  double normal_window_m = 6.0;  ///< half the length over which normals are smoothed
};

/// Joins ways end to end where they continue each other (the only two ends at a node, or the straightest pair of a
/// junction) and resamples them. Every path lands in exactly one chain; chains are ordered by their lowest path.
[[nodiscard]] std::vector<RoadChain> build_chains(const RoadNetwork& osm, const ChainOptions& options);

/// Lowers the evidence to 0 where the labels show another road: near junctions (the mouth of the other road; the edge
/// across from it counts where a road passes), where a road crosses above or below, and in tunnels.
void mask_evidence(std::vector<RoadChain>& chains, const RoadNetwork& osm);

}  // namespace orthodrive
