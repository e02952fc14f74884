// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/roads/path_junctions.hpp"

#include <map>

#include "orthodrive/model/roads/osm_node_id.hpp"

namespace orthodrive {
namespace {

/// Along the path, through its end into the one that goes on there.
Vec2 through_direction(const RoadNetwork& roads, PathEnd end, PathEnd next) {
  const auto outwards = [&](PathEnd e) {
    const auto& nodes = roads.paths[e.path].nodes;
    const std::vector<Vec2> along = tangents(centerline(roads.paths[e.path]));
    return e.at_back ? along[nodes.size() - 1] : along[0] * -1.0;
  };
  const Vec2 out = outwards(end), sum = out - outwards(next);
  const Vec2 through = length(sum) > 1e-9 ? normalized(sum) : out;
  return end.at_back ? through : through * -1.0;
}

}  // namespace

std::vector<PathJunction> find_junctions(const RoadNetwork& roads, const PathLinks& links) {
  std::map<std::int64_t, int> visits;  // of paths; a linked pair of ends counts once
  const auto end_of = [&](std::size_t path, std::size_t node) { return PathEnd{path, node > 0}; };
  const auto is_end = [&](std::size_t path, std::size_t node) {
    return node == 0 || node + 1 == roads.paths[path].nodes.size();
  };
  const auto is_repeated = [&](std::size_t path, std::size_t node) {  // a node written twice in a row
    return node > 0 && roads.paths[path].nodes[node - 1].osm_node == roads.paths[path].nodes[node].osm_node;
  };
  for (std::size_t p = 0; p < roads.paths.size(); ++p)
    for (std::size_t n = 0; n < roads.paths[p].nodes.size(); ++n) {
      const std::int64_t id = roads.paths[p].nodes[n].osm_node;
      if (id <= 0 || (is_repeated(p, n) && !is_end(p, n))) continue;
      const auto link = is_end(p, n) ? links.find(end_of(p, n)) : links.end();
      if (link == links.end() || end_of(p, n) < link->second) ++visits[id];
    }
  std::map<std::int64_t, PathJunction> found;
  for (std::size_t p = 0; p < roads.paths.size(); ++p) {
    std::vector<Vec2> along;
    for (std::size_t n = 0; n < roads.paths[p].nodes.size(); ++n) {
      const RoadNode& node = roads.paths[p].nodes[n];
      if (!is_osm_node(node.osm_node) || visits[node.osm_node] < 2 || (is_repeated(p, n) && !is_end(p, n))) continue;
      if (along.empty()) along = tangents(centerline(roads.paths[p]));
      const auto link = is_end(p, n) ? links.find(end_of(p, n)) : links.end();
      PathJunction& junction = found.try_emplace(node.osm_node, PathJunction{node.osm_node, node.p, {}}).first->second;
      junction.arms.push_back(
          {p, n, link == links.end() ? along[n] : through_direction(roads, link->first, link->second)});
    }
  }
  std::vector<PathJunction> junctions;
  junctions.reserve(found.size());
  for (auto& [id, junction] : found) junctions.push_back(std::move(junction));
  return junctions;
}

}  // namespace orthodrive
