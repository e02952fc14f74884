// SPDX-License-Identifier: Apache-2.0
#pragma once
// What relations of the map say of the ways on at a node, and over ways that one has come.

#include <compare>
#include <cstddef>
#include <cstdint>
#include <map>
#include <set>
#include <vector>

#include "orthodrive/core/finding.hpp"
#include "orthodrive/network/roads/road_parts.hpp"

namespace orthodrive::network {

/// A restriction over ways that one drives along: how many of its via_ways one has come onto.
struct FollowedRestriction {
  std::size_t restriction = 0;  ///< index in RoadNetwork::restrictions
  std::size_t ways = 0;
  auto operator<=>(const FollowedRestriction&) const = default;
};

/// Where a driver is, as far as restrictions ask: the way that one is on, and what one follows there.
struct DrivenWay {
  std::int64_t way = 0;                       ///< OSM's
  std::vector<FollowedRestriction> followed;  ///< sorted
  bool operator==(const DrivenWay&) const = default;
};

/// The restrictions of a network. Where only one way leads on from the one before, as where tags change, the two count
/// as one: a restriction over such a way is one over a node.
[[nodiscard]] std::vector<TurnRestriction> settled_restrictions(const RoadNetwork& roads, const Topology& topology);

class TurnRules {
 public:
  explicit TurnRules(std::vector<TurnRestriction> restrictions);

  /// Whether one may not drive on from there over the node onto a way.
  [[nodiscard]] bool forbid(const DrivenWay& here, std::int64_t node, std::int64_t to_way) const;
  /// Where one is after that. Linear in the restrictions at the node.
  [[nodiscard]] DrivenWay drive_on(const DrivenWay& here, std::int64_t node, std::int64_t to_way) const;
  /// Whether one has come over all ways of a restriction.
  [[nodiscard]] bool is_complete(const FollowedRestriction& followed) const;
  [[nodiscard]] const std::vector<TurnRestriction>& restrictions() const { return restrictions_; }
  /// Whether any is the map's: of crossings without a node each way leads on into itself alone (crossing_nodes.hpp).
  [[nodiscard]] bool are_told() const { return are_told_; }

 private:
  /// Of restrictions over ways that begin there.
  template <typename F>
  void each_over_ways(std::int64_t node, std::int64_t from_way, const F& call) const;

  std::vector<TurnRestriction> restrictions_;
  bool are_told_ = false;
  std::map<std::int64_t, std::vector<std::size_t>> at_node_;
};

/// Restrictions over ways of which some have roads of their own: OpenDRIVE has no words for where one comes from before
/// that. `followed`: those that are kept. Finding network.restriction_over_road.
void report_restrictions_over_roads(const NetworkPlan& plan, const TurnRules& rules,
                                    const std::set<std::size_t>& followed, Findings& findings);

}  // namespace orthodrive::network
