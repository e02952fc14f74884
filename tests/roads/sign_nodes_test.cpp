// SPDX-License-Identifier: Apache-2.0
// Signs stay on their roads when refinement lays other nodes.

#include "orthodrive/roads/sign_nodes.hpp"

#include <gtest/gtest.h>

namespace orthodrive {
namespace {

RoadPath path_with(std::int64_t osm_id, int part, const std::vector<std::pair<double, std::int64_t>>& nodes, double y) {
  RoadPath path{.osm_id = osm_id, .part = part};
  for (const auto& [x, id] : nodes) path.nodes.push_back({.p = {x, y}, .osm_node = id, .s_m = x});
  return path;
}

TEST(SignNodes, the_nearest_node_of_the_same_path_gets_the_sign) {
  RoadNetwork map;
  map.paths = {path_with(1, 0, {{0, 10}, {5.2, 11}, {20, 12}}, 0.0),
               path_with(1, 1, {{0, 20}, {5.2, 21}, {20, 22}}, 5.0)};
  map.signs = {
      {10, NodeSignKind::stop}, {11, NodeSignKind::zebra}, {21, NodeSignKind::zebra}, {99, NodeSignKind::stop}};
  RoadNetwork moved;
  moved.paths = {path_with(1, 1, {{0, 20}, {2, 0}, {4, 0}, {6, 0}, {20, 22}}, 6.0),
                 path_with(1, 0, {{0, 10}, {2, 0}, {4, 0}, {6, 0}, {20, 12}}, 3.0)};
  keep_signs(map, moved);
  EXPECT_EQ(moved.signs.size(), 4u);
  EXPECT_EQ(moved.paths[1].nodes[3].osm_node, 11);
  EXPECT_EQ(moved.paths[0].nodes[3].osm_node, 21) << "each on its own path";
  EXPECT_EQ(moved.paths[1].nodes[0].osm_node, 10) << "still there";
  EXPECT_EQ(moved.paths[1].nodes[2].osm_node, 0);
}

TEST(SignNodes, paths_without_free_nodes_keep_theirs) {
  RoadNetwork map;
  map.paths = {path_with(1, 0, {{0, 10}, {5, 11}, {20, 12}}, 0.0)};
  map.signs = {{11, NodeSignKind::zebra}};
  RoadNetwork moved;
  moved.paths = {path_with(1, 0, {{0, 10}, {20, 12}}, 0.0)};
  keep_signs(map, moved);
  EXPECT_EQ(moved.paths[0].nodes[0].osm_node, 10);
  EXPECT_EQ(moved.paths[0].nodes[1].osm_node, 12);
}

}  // namespace
}  // namespace orthodrive
