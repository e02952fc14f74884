// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/roads/sign_nodes.hpp"

#include <map>
#include <set>
#include <utility>

#include "orthodrive/model/roads/osm_node_id.hpp"

namespace orthodrive {
namespace {

RoadNode* nearest_without_id(RoadPath& path, Vec2 p) {
  RoadNode* nearest = nullptr;
  for (RoadNode& node : path.nodes)
    if (!is_osm_node(node.osm_node) && (!nearest || distance(node.p, p) < distance(nearest->p, p))) nearest = &node;
  return nearest;
}

}  // namespace

void keep_signs(const RoadNetwork& map, RoadNetwork& moved) {
  moved.signs = map.signs;
  std::set<std::int64_t> wanted;
  for (const NodeSign& sign : map.signs) wanted.insert(sign.osm_node);
  std::map<std::pair<std::int64_t, int>, std::size_t> path_of;
  for (std::size_t i = 0; i < moved.paths.size(); ++i) {
    path_of.emplace(std::pair(moved.paths[i].osm_id, moved.paths[i].part), i);
    for (const RoadNode& node : moved.paths[i].nodes) wanted.erase(node.osm_node);
  }
  for (const RoadPath& path : map.paths) {
    if (wanted.empty()) return;
    const auto same = path_of.find({path.osm_id, path.part});
    if (same == path_of.end()) continue;
    for (const RoadNode& node : path.nodes) {
      if (!wanted.contains(node.osm_node)) continue;
      RoadNode* nearest = nearest_without_id(moved.paths[same->second], node.p);
      if (!nearest) continue;
      nearest->osm_node = node.osm_node;
      wanted.erase(node.osm_node);
    }
  }
}

}  // namespace orthodrive
