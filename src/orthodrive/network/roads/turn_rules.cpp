// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/network/roads/turn_rules.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <string>
#include <utility>

#include "orthodrive/model/roads/osm_node_id.hpp"
#include "orthodrive/network/line/chain_geometry.hpp"

namespace orthodrive::network {
namespace {

/// The nodes of ways, and at which of them roads meet.
class WayNodes {
 public:
  WayNodes(const RoadNetwork& roads, const Topology& topology) {
    for (const RoadPath& path : roads.paths)
      for (const RoadNode& node : path.nodes)
        if (is_osm_node(node.osm_node)) nodes_[path.osm_id].insert(node.osm_node);
    for (const Vertex& vertex : topology.vertices)
      if (vertex.is_junction()) junctions_.insert(vertex.osm_node);
  }
  [[nodiscard]] bool has_junction(std::int64_t node) const { return junctions_.contains(node); }
  [[nodiscard]] bool knows(std::int64_t way) const { return nodes_.contains(way); }
  /// 0: none.
  [[nodiscard]] std::int64_t common(std::int64_t a, std::int64_t b) const {
    if (!knows(a) || !knows(b)) return 0;
    const auto shared =
        std::ranges::find_if(nodes_.at(a), [&](std::int64_t node) { return nodes_.at(b).contains(node); });
    return shared == nodes_.at(a).end() ? 0 : *shared;
  }

 private:
  std::map<std::int64_t, std::set<std::int64_t>> nodes_;
  std::set<std::int64_t> junctions_;
};

void settle(const WayNodes& ways, TurnRestriction& r) {
  while (!r.via_ways.empty() && ways.knows(r.via_ways.front()) && !ways.has_junction(r.via_node)) {
    const std::int64_t next = r.via_ways.size() > 1 ? r.via_ways[1] : r.to_way;
    const std::int64_t node = ways.common(r.via_ways.front(), next);
    if (node == 0) return;
    r.from_way = r.via_ways.front(), r.via_node = node;
    r.via_ways.erase(r.via_ways.begin());
  }
  while (!r.via_ways.empty()) {
    const std::int64_t node = ways.common(r.via_ways.back(), r.to_way);
    if (node == 0 || ways.has_junction(node)) return;
    r.to_way = r.via_ways.back();
    r.via_ways.pop_back();
  }
}

}  // namespace

std::vector<TurnRestriction> settled_restrictions(const RoadNetwork& roads, const Topology& topology) {
  std::vector<TurnRestriction> restrictions = roads.restrictions;
  const auto goes_over_ways = [](const TurnRestriction& r) { return !r.via_ways.empty(); };
  if (std::ranges::none_of(restrictions, goes_over_ways)) return restrictions;
  const WayNodes ways(roads, topology);
  for (TurnRestriction& r : restrictions) settle(ways, r);
  return restrictions;
}

TurnRules::TurnRules(std::vector<TurnRestriction> restrictions) : restrictions_(std::move(restrictions)) {
  for (std::size_t i = 0; i < restrictions_.size(); ++i) at_node_[restrictions_[i].via_node].push_back(i);
  are_told_ =
      std::ranges::any_of(restrictions_, [](const TurnRestriction& r) { return !r.only || r.from_way != r.to_way; });
}

template <typename F>
void TurnRules::each_over_ways(std::int64_t node, std::int64_t from_way, const F& call) const {
  const auto found = at_node_.find(node);
  if (found == at_node_.end()) return;
  for (const std::size_t i : found->second)
    if (const TurnRestriction& r = restrictions_[i]; r.from_way == from_way && !r.via_ways.empty()) call(i, r);
}

bool TurnRules::is_complete(const FollowedRestriction& followed) const {
  return followed.ways == restrictions_[followed.restriction].via_ways.size();
}

bool TurnRules::forbid(const DrivenWay& here, std::int64_t node, std::int64_t to_way) const {
  if (const auto found = at_node_.find(node); found != at_node_.end())
    for (const std::size_t i : found->second) {
      const TurnRestriction& r = restrictions_[i];
      if (r.via_ways.empty() && r.from_way == here.way && r.only != (r.to_way == to_way)) return true;
    }
  bool forbidden = false;
  each_over_ways(node, here.way, [&](std::size_t, const TurnRestriction& r) {
    forbidden = forbidden || (r.only && to_way != r.via_ways.front());
  });
  if (to_way == here.way) return forbidden;  // still on the last of the ways over which it goes
  return forbidden || std::ranges::any_of(here.followed, [&](const FollowedRestriction& f) {
           const TurnRestriction& r = restrictions_[f.restriction];
           if (!is_complete(f)) return r.only && to_way != r.via_ways[f.ways];
           return r.only != (to_way == r.to_way);
         });
}

DrivenWay TurnRules::drive_on(const DrivenWay& here, std::int64_t node, std::int64_t to_way) const {
  if (to_way == here.way) return here;
  DrivenWay there{to_way, {}};
  for (const FollowedRestriction& f : here.followed)
    if (!is_complete(f) && restrictions_[f.restriction].via_ways[f.ways] == to_way)
      there.followed.push_back({f.restriction, f.ways + 1});
  each_over_ways(node, here.way, [&](std::size_t i, const TurnRestriction& r) {
    if (r.via_ways.front() == to_way) there.followed.push_back({i, 1});
  });
  std::ranges::sort(there.followed);
  return there;
}

void report_restrictions_over_roads(const NetworkPlan& plan, const TurnRules& rules,
                                    const std::set<std::size_t>& followed, Findings& findings) {
  std::map<std::int64_t, Vec2> place_of;  // of the ways that have a road of their own: where one begins
  for (const Stretch& stretch : plan.junctions.stretches) {
    if (stretch.inside) continue;
    const ChainGeometry& geometry = plan.geometry[stretch.chain];
    const double s = 0.5 * (stretch.s0 + stretch.trim0_m + stretch.s1 - stretch.trim1_m);
    const std::size_t k = piece_at(geometry, s);
    const PathPiece& piece = plan.topology.pieces[plan.topology.chains[stretch.chain].pieces[k].piece];
    place_of.emplace(plan.roads.paths[piece.path].osm_id, pose_at(geometry.plan, s).p);
  }
  const auto is_known = [&](std::int64_t way) {
    return std::ranges::any_of(plan.roads.paths, [&](const RoadPath& path) { return path.osm_id == way; });
  };
  for (std::size_t i = 0; i < rules.restrictions().size(); ++i) {
    const TurnRestriction& r = rules.restrictions()[i];
    if (r.via_ways.empty() || followed.contains(i) || !is_known(r.from_way) || !is_known(r.to_way)) continue;
    const auto own = std::ranges::find_if(r.via_ways, [&](std::int64_t way) { return place_of.contains(way); });
    if (own == r.via_ways.end()) continue;
    std::string over;
    for (const std::int64_t way : r.via_ways) over += fmt::format("{}{}", over.empty() ? "" : ", ", way);
    const Vec2 where = place_of.at(*own);
    findings.push_back(
        {Severity::info, "network.restriction_over_road",
         fmt::format("{} from way {} over way {} into way {}: way {} is a road of its own here, on which "
                     "OpenDRIVE does not know where one comes from; cars may turn there",
                     r.only ? "the only turn" : "no turn", r.from_way, over, r.to_way, *own),
         where.x, where.y});
  }
}

}  // namespace orthodrive::network
