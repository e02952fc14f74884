// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/drive/routes/route_cover.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "orthodrive/core/disjoint_sets.hpp"
#include "orthodrive/drive/routes/road_graph.hpp"

namespace orthodrive {
namespace {

using CoverNodes = std::vector<int>;

constexpr double route_m = 3000.0;  // a route ends with the road that makes it longer
constexpr double most_detour_m = 1500.0;
constexpr double straight_m = 12.0;  // a route begins and ends with at least so much road outside junctions

/// Which part of the graph every node belongs to, as the lowest node of that part.
CoverNodes parts_of(const RoadGraph& graph) {
  DisjointSets parts(static_cast<std::size_t>(graph.node_count()));
  const auto join = [&](int a, int b) { parts.join(static_cast<std::size_t>(a), static_cast<std::size_t>(b)); };
  for (int n = 0; n < graph.node_count(); ++n) {
    if (!graph.is_open(n)) continue;
    if (graph.is_open(n ^ 1)) join(n, n ^ 1);
    for (const int next : graph.next(n)) join(n, next);
  }
  CoverNodes part_of;
  for (int n = 0; n < graph.node_count(); ++n)
    part_of.push_back(static_cast<int>(parts.find(static_cast<std::size_t>(n))));
  return part_of;
}

/// Nodes of the part with the most metres of lane.
std::vector<bool> largest_part(const RoadGraph& graph) {
  const CoverNodes part = parts_of(graph);
  std::vector<double> length_m(part.size(), 0.0);
  for (int n = 0; n < graph.node_count(); ++n)
    if (graph.is_open(n)) length_m[static_cast<std::size_t>(part[static_cast<std::size_t>(n)])] += graph.road(n).length;
  const auto largest = std::max_element(length_m.begin(), length_m.end()) - length_m.begin();
  std::vector<bool> inside(part.size());
  for (int n = 0; n < graph.node_count(); ++n)
    inside[static_cast<std::size_t>(n)] = graph.is_open(n) && part[static_cast<std::size_t>(n)] == largest;
  return inside;
}

class Cover {
 public:
  explicit Cover(const RoadGraph& graph) : graph_(graph), to_drive_(largest_part(graph)) {
    costs_.resize(to_drive_.size());
    for (int n = 0; n < graph.node_count(); ++n) costs_[static_cast<std::size_t>(n)] = graph.road(n).length;
    before_.resize(to_drive_.size());
    for (int n = 0; n < graph.node_count(); ++n)
      for (const int next : graph.next(n)) before_[static_cast<std::size_t>(next)].push_back(n);
  }

  /// The nodes of the next route; empty when every road has been driven.
  CoverNodes next_route() {
    const int start = choose_start();
    if (start < 0) return {};
    CoverNodes route;
    double length_m = 0.0;
    const auto take = [&](int node) {
      route.push_back(node);
      to_drive_[static_cast<std::size_t>(node)] = false;
      length_m += graph_.road(node).length;
    };
    for (const int node : run_up(start)) take(node);
    while (length_m < route_m) {
      const CoverNodes more = way_to_nearest(route.back());
      if (more.empty()) break;
      for (const int node : more) take(node);
    }
    for (const int node : run_out(route.back())) take(node);
    return route;
  }

 private:
  /// First roads that nothing leads to, because no other route comes by them; connecting roads last.
  [[nodiscard]] int choose_start() const {
    int best = -1;
    const auto rank = [&](int n) {
      return (graph_.road(n).junction >= 0 ? 2 : 0) + (before_[static_cast<std::size_t>(n)].empty() ? 0 : 1);
    };
    for (int n = 0; n < graph_.node_count(); ++n)
      if (to_drive_[static_cast<std::size_t>(n)] && (best < 0 || rank(n) < rank(best))) best = n;
    return best;
  }

  /// Metres of a road that count as straight: a car that begins or ends its way on a connecting road stands askew.
  [[nodiscard]] double straight_on(int node) const {
    const roadquery::Road& road = graph_.road(node);
    return road.junction >= 0 ? 0.0 : road.length;
  }

  /// One of these, rather one that is to be driven anyway, but none of `taken`; -1: there is none.
  [[nodiscard]] int choose(const CoverNodes& nodes, const CoverNodes& taken) const {
    int best = -1;
    for (const int n : nodes) {
      if (std::find(taken.begin(), taken.end(), n) != taken.end()) continue;
      if (best < 0 || (to_drive_[static_cast<std::size_t>(n)] && !to_drive_[static_cast<std::size_t>(best)])) best = n;
    }
    return best;
  }

  /// The start, with the roads before it that the car needs to stand straight.
  [[nodiscard]] CoverNodes run_up(int start) const {
    CoverNodes way = {start};
    for (double straight = straight_on(start); straight < straight_m;) {
      const int node = choose(before_[static_cast<std::size_t>(way.front())], way);
      if (node < 0) break;
      way.insert(way.begin(), node);
      straight += straight_on(node);
    }
    return way;
  }

  /// The roads after the last one that the car needs to stand straight.
  [[nodiscard]] CoverNodes run_out(int last) const {
    CoverNodes way = {last};
    for (double straight = straight_on(last); straight < straight_m;) {
      const int node = choose(graph_.next(way.back()), way);
      if (node < 0) break;
      way.push_back(node);
      straight += straight_on(node);
    }
    way.erase(way.begin());
    return way;
  }

  /// Nodes after `from` to the nearest one that is to be driven, which is the last of them. Empty: there is none.
  [[nodiscard]] CoverNodes way_to_nearest(int from) const {
    for (const int next : graph_.next(from))
      if (to_drive_[static_cast<std::size_t>(next)]) return {next};
    const PathTree tree = shortest_paths(graph_, from, costs_, most_detour_m);
    int nearest = -1;
    for (int n = 0; n < graph_.node_count(); ++n) {
      const auto i = static_cast<std::size_t>(n);
      if (to_drive_[i] && tree.before[i] >= 0 &&
          (nearest < 0 || tree.cost[i] < tree.cost[static_cast<std::size_t>(nearest)]))
        nearest = n;
    }
    return nearest < 0 ? CoverNodes{} : tree.path_to(nearest).value_or(CoverNodes{});
  }

  const RoadGraph& graph_;
  std::vector<bool> to_drive_;
  NodeCosts costs_;
  std::vector<CoverNodes> before_;  ///< from where one comes to a node
};

}  // namespace

std::vector<Route> routes_over_all_roads(const roadquery::RoadMap& map) {
  const RoadGraph graph(map);
  if (graph.node_count() == 0) return {};
  Cover cover(graph);
  std::vector<Route> routes;
  for (CoverNodes nodes = cover.next_route(); !nodes.empty(); nodes = cover.next_route()) {
    Route route;
    for (const int n : nodes) {
      route.steps.push_back(RoadGraph::step_of(n));
      route.length_m += graph.road(n).length;
    }
    route.name = fmt::format("part {}", routes.size() + 1);
    routes.push_back(std::move(route));
  }
  return routes;
}

}  // namespace orthodrive
