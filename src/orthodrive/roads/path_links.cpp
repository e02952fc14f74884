// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/roads/path_links.hpp"

#include <algorithm>
#include <cstdint>
#include <map>
#include <optional>

#include "orthodrive/model/roads/osm_node_id.hpp"
#include "orthodrive/roads/ring_paths.hpp"

namespace orthodrive {
namespace {

const RoadNode& node_of(const RoadNetwork& roads, PathEnd end) {
  const auto& nodes = roads.paths[end.path].nodes;
  return end.at_back ? nodes.back() : nodes.front();
}

MeetingEnd meeting_end(const RoadNetwork& roads, PathEnd end, int ring, const ContinuationRule& rule) {
  Polyline line = centerline(roads.paths[end.path]);
  if (end.at_back) std::reverse(line.begin(), line.end());
  return {direction_into(line, rule), &roads.paths[end.path], ring, end.at_back};
}

}  // namespace

PathLinks link_path_ends(const RoadNetwork& roads, const ContinuationRule& rule) {
  std::map<std::int64_t, std::vector<PathEnd>> ends_at;
  std::map<std::int64_t, int> visits;  // of paths that begin, end or pass
  for (std::size_t p = 0; p < roads.paths.size(); ++p) {
    for (const bool at_back : {false, true})
      if (const auto id = node_of(roads, {p, at_back}).osm_node; is_osm_node(id)) ends_at[id].push_back({p, at_back});
    for (const RoadNode& node : roads.paths[p].nodes)
      if (is_osm_node(node.osm_node)) ++visits[node.osm_node];
  }
  const std::vector<int> ring = rings_of_paths(roads);
  PathLinks links;
  for (const auto& [id, ends] : ends_at) {
    std::vector<MeetingEnd> meeting;
    meeting.reserve(ends.size());
    for (const PathEnd end : ends) meeting.push_back(meeting_end(roads, end, ring[end.path], rule));
    const std::vector<std::optional<std::size_t>> partner = pair_ends(meeting, visits[id] == 2, rule);
    for (std::size_t i = 0; i < ends.size(); ++i)
      if (const std::optional<std::size_t>& other = partner[i]) links[ends[i]] = ends[*other];
  }
  return links;
}

std::vector<PathChain> chain_paths(const RoadNetwork& roads, const PathLinks& links, ChainOrder order) {
  ChainWalk<PathEnd> walk(roads.paths.size(), links);
  const auto anywhere = [](PathEnd) { return true; };
  std::vector<PathChain> chains;
  for (const WalkedChain<PathEnd>& walked :
       order == ChainOrder::by_lowest_path ? walk.along_lowest_lines() : walk.open_ones_first(anywhere)) {
    PathChain& chain = chains.emplace_back();
    chain.closed = walked.closed;
    for (const PathEnd entry : walked.entries) chain.paths.push_back({entry.path, entry.at_back});
  }
  return chains;
}

}  // namespace orthodrive
