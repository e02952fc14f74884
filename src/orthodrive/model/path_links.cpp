#include "orthodrive/model/path_links.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <optional>
#include <vector>

namespace orthodrive {
namespace {

constexpr double direction_length_m = 10.0;  // the direction of a way at its end is that of its outermost 10 m

const RoadNode& node_of(const RoadNetwork& roads, PathEnd end) {
  const auto& nodes = roads.paths[end.path].nodes;
  return end.at_back ? nodes.back() : nodes.front();
}

/// Unit vector from the end into the path.
Vec2 inward_direction(const RoadNetwork& roads, PathEnd end) {
  Polyline line = centerline(roads.paths[end.path]);
  if (end.at_back) std::reverse(line.begin(), line.end());
  return normalized(point_at(line, direction_length_m) - line.front());
}

/// How badly b continues a, in rad of turning: 0 is straight on along the same road. None when it is no continuation.
std::optional<double> continuation_cost(const RoadNetwork& roads, PathEnd a, PathEnd b, bool only_pair) {
  constexpr double deg = std::numbers::pi / 180.0;
  const Vec2 in = inward_direction(roads, a) * -1.0, out = inward_direction(roads, b);
  const double turn = std::abs(std::atan2(cross(in, out), dot(in, out)));
  const RoadPath &pa = roads.paths[a.path], &pb = roads.paths[b.path];
  // A road may bend sharply between two ways; at a junction only a pair that is fairly straight is one road.
  if (turn > (only_pair ? 100.0 : 50.0) * deg) return std::nullopt;
  return turn + (pa.highway != pb.highway ? 30.0 * deg : 0.0) + (pa.name != pb.name ? 15.0 * deg : 0.0);
}

/// Goes from `path` against its direction to the beginning of the chain, then along the chain to its end.
PathChain walk_chain(const PathLinks& links, std::size_t path) {
  const auto next_of = [&](PathEnd leaving) -> std::optional<PathEnd> {
    const auto it = links.find(leaving);
    return it == links.end() ? std::nullopt : std::optional(it->second);
  };
  PathEnd entry{path, false};
  while (const auto previous = next_of(entry)) {
    entry = {previous->path, !previous->at_back};
    if (entry == PathEnd{path, false}) break;  // all the way round
  }
  PathChain chain;
  const PathEnd start = entry;
  for (;;) {
    chain.paths.push_back({entry.path, entry.at_back});
    const auto next = next_of({entry.path, !entry.at_back});
    if (!next) return chain;
    if (*next == start) break;
    entry = *next;
  }
  chain.closed = true;
  return chain;
}

}  // namespace

PathLinks link_path_ends(const RoadNetwork& roads) {
  std::map<std::int64_t, std::vector<PathEnd>> ends_at;
  std::map<std::int64_t, int> incidences;
  for (std::size_t p = 0; p < roads.paths.size(); ++p) {
    for (const bool at_back : {false, true})
      if (const auto id = node_of(roads, {p, at_back}).osm_node; id > 0) ends_at[id].push_back({p, at_back});
    for (const RoadNode& node : roads.paths[p].nodes)
      if (node.osm_node > 0) ++incidences[node.osm_node];
  }
  PathLinks links;
  for (const auto& [id, ends] : ends_at) {
    struct Pair {
      double cost;
      PathEnd a, b;
      auto operator<=>(const Pair&) const = default;
    };
    std::vector<Pair> pairs;
    for (std::size_t i = 0; i < ends.size(); ++i)
      for (std::size_t k = i + 1; k < ends.size(); ++k)
        if (const auto cost = continuation_cost(roads, ends[i], ends[k], incidences[id] == 2))
          pairs.push_back({*cost, ends[i], ends[k]});
    std::sort(pairs.begin(), pairs.end());
    for (const Pair& pair : pairs)
      if (!links.contains(pair.a) && !links.contains(pair.b)) links[pair.a] = pair.b, links[pair.b] = pair.a;
  }
  return links;
}

std::vector<PathChain> chain_paths(const RoadNetwork& roads, const PathLinks& links) {
  std::vector<PathChain> chains;
  std::vector<bool> taken(roads.paths.size(), false);
  for (std::size_t p = 0; p < roads.paths.size(); ++p) {
    if (taken[p]) continue;
    chains.push_back(walk_chain(links, p));
    for (const ChainPath& member : chains.back().paths) taken[member.path] = true;
  }
  return chains;
}

}  // namespace orthodrive
