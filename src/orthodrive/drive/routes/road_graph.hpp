// SPDX-License-Identifier: Apache-2.0
#pragma once
// The roads of a map as a directed graph: a node is a road in one direction, an edge leads to where one may go on.

#include <limits>
#include <optional>
#include <vector>

#include "orthodrive/drive/routes/route.hpp"

namespace orthodrive {

class RoadGraph {
 public:
  explicit RoadGraph(const roadquery::RoadMap& map);

  /// Nodes are counted 2 * road + (forward ? 0 : 1).
  [[nodiscard]] static int node_of(RouteStep step) { return 2 * step.road + (step.forward ? 0 : 1); }
  [[nodiscard]] static RouteStep step_of(int node) { return {node / 2, node % 2 == 0}; }

  [[nodiscard]] int node_count() const { return static_cast<int>(next_.size()); }
  [[nodiscard]] bool is_open(int node) const {
    return open_[static_cast<std::size_t>(node)];
  }  ///< has a lane to drive on
  [[nodiscard]] const std::vector<int>& next(int node) const { return next_[static_cast<std::size_t>(node)]; }
  [[nodiscard]] const roadquery::Road& road(int node) const { return map_->roads[static_cast<std::size_t>(node / 2)]; }

 private:
  void connect(int node);

  const roadquery::RoadMap* map_;
  std::vector<std::vector<int>> next_;
  std::vector<bool> open_;
};

/// Cost of driving each node, >= 0; infinite: closed.
using NodeCosts = std::vector<double>;

/// Shortest paths from the end of one node (Dijkstra).
struct PathTree {
  static constexpr double unreached = std::numeric_limits<double>::infinity();
  int from = -1;
  std::vector<double>
      cost;                 ///< to the end of each node, without that of `from`; of `from` itself: back to it in a loop
  std::vector<int> before;  ///< the node before on the way, -1: unreached

  /// Nodes after `from` up to and with `to`; nothing when unreached. path_to(from) is a loop.
  [[nodiscard]] std::optional<std::vector<int>> path_to(int to) const;
};
[[nodiscard]] PathTree shortest_paths(const RoadGraph& graph, int from, const NodeCosts& costs,
                                      double max_cost = PathTree::unreached);

}  // namespace orthodrive
