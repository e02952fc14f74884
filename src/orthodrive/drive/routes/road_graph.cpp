// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/drive/routes/road_graph.hpp"

#include <algorithm>
#include <queue>

#include "roadquery/surface/road_surface.hpp"

namespace orthodrive {
namespace {

using roadquery::ContactPoint;
using roadquery::LinkKind;
using roadquery::Road;

constexpr double max_gap_m = 10.0;  // a link between ends further apart is a mistake in the file: nobody can drive it

/// Sign of the ids of the lanes that go in this direction.
int lane_sign(const Road& road, bool forward) {
  return forward != (road.driving_side == roadquery::DrivingSide::left) ? -1 : 1;
}

template <typename Item>
const Item* find_by_id(const std::vector<Item>& items, int id) {
  const auto it = std::lower_bound(items.begin(), items.end(), id, [](const Item& item, int v) { return item.id < v; });
  return it != items.end() && it->id == id ? &*it : nullptr;
}

/// Whether a connecting road begins (at its end `contact`) where `road` ends. Files that leave the link out are
/// believed.
bool attaches(const Road& connecting, ContactPoint contact, const Road& road, bool forward) {
  const roadquery::RoadLink& link = contact == ContactPoint::start ? connecting.predecessor : connecting.successor;
  if (link.kind != LinkKind::road) return true;
  return link.id == road.id && link.contact == (forward ? ContactPoint::end : ContactPoint::start);
}

/// Whether one leaves the road by that lane, in that direction: lanes for both are on either side of the centre lane.
bool leaves_by(const Road& road, bool forward, int lane_id) {
  if (lane_id * lane_sign(road, forward) > 0) return true;
  const roadquery::LaneSection& section = forward ? road.sections.back() : road.sections.front();
  return std::ranges::any_of(lane_id < 0 ? section.right : section.left, [lane_id](const roadquery::Lane& lane) {
    return lane.id == lane_id && lane.type == roadquery::LaneType::bidirectional;
  });
}

/// Where a road is left in that direction (or entered, against it).
Vec2 end_of(const Road& road, bool forward) {
  const auto p = roadquery::reference_point(road, forward ? road.length : 0.0);
  return {p.x, p.y};
}

}  // namespace

bool is_drivable(const Road& road, bool forward) {
  return std::all_of(road.sections.begin(), road.sections.end(), [&](const roadquery::LaneSection& section) {
    const bool right = lane_sign(road, forward) < 0;
    const auto has = [](const std::vector<roadquery::Lane>& lanes, roadquery::LaneType type) {
      return std::ranges::any_of(lanes, [type](const roadquery::Lane& lane) { return lane.type == type; });
    };
    return has(right ? section.right : section.left, roadquery::LaneType::driving) ||
           has(section.right, roadquery::LaneType::bidirectional) ||
           has(section.left, roadquery::LaneType::bidirectional);
  });
}

RoadGraph::RoadGraph(const roadquery::RoadMap& map)
    : map_(&map), next_(2 * map.roads.size()), open_(2 * map.roads.size()) {
  for (int node = 0; node < node_count(); ++node) {
    open_[static_cast<std::size_t>(node)] = is_drivable(road(node), step_of(node).forward);
  }
  for (int node = 0; node < node_count(); ++node) {
    if (is_open(node)) connect(node);
  }
}

void RoadGraph::connect(int node) {
  const bool forward = step_of(node).forward;
  const Road& from = road(node);
  std::vector<int>& next = next_[static_cast<std::size_t>(node)];
  const auto add = [&](int road_id, ContactPoint contact, const auto& condition) {
    const Road* to = find_by_id(map_->roads, road_id);
    if (to == nullptr || !condition(*to)) return;
    const bool enter_forward = contact == ContactPoint::start;
    if (distance(end_of(from, forward), end_of(*to, !enter_forward)) > max_gap_m) return;
    const int target = node_of({static_cast<int>(to - map_->roads.data()), enter_forward});
    if (is_open(target)) next.push_back(target);
  };
  const roadquery::RoadLink& exit = forward ? from.successor : from.predecessor;
  if (exit.kind == LinkKind::road) {
    add(exit.id, exit.contact, [](const Road&) { return true; });
  } else if (exit.kind == LinkKind::junction) {
    const roadquery::Junction* junction = find_by_id(map_->junctions, exit.id);
    if (junction == nullptr) return;
    for (const roadquery::Connection& connection : junction->connections) {
      if (connection.incoming_road != from.id) continue;
      const auto& links = connection.lane_links;
      const bool our_lane =
          links.empty() || std::any_of(links.begin(), links.end(), [&](const roadquery::LaneLink& link) {
            return leaves_by(from, forward, link.from);
          });
      if (!our_lane) continue;
      add(connection.connecting_road, connection.contact,
          [&](const Road& to) { return attaches(to, connection.contact, from, forward); });
    }
  }
  std::sort(next.begin(), next.end());
  next.erase(std::unique(next.begin(), next.end()), next.end());
}

std::optional<std::vector<int>> PathTree::path_to(int to) const {
  if (before[static_cast<std::size_t>(to)] < 0) return std::nullopt;
  std::vector<int> path;
  int node = to;
  do {
    path.push_back(node);
    node = before[static_cast<std::size_t>(node)];
  } while (node != from);
  std::reverse(path.begin(), path.end());
  return path;
}

PathTree shortest_paths(const RoadGraph& graph, int from, const NodeCosts& costs, double max_cost) {
  PathTree tree{from, std::vector<double>(static_cast<std::size_t>(graph.node_count()), PathTree::unreached),
                std::vector<int>(static_cast<std::size_t>(graph.node_count()), -1)};
  using Entry = std::pair<double, int>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  const auto spread = [&](int node, double cost_so_far) {
    for (const int to : graph.next(node)) {
      const double total = cost_so_far + costs[static_cast<std::size_t>(to)];
      if (total < tree.cost[static_cast<std::size_t>(to)] && total <= max_cost) {
        tree.cost[static_cast<std::size_t>(to)] = total;
        tree.before[static_cast<std::size_t>(to)] = node;
        queue.emplace(total, to);
      }
    }
  };
  spread(from, 0.0);
  while (!queue.empty()) {
    const auto [total, node] = queue.top();
    queue.pop();
    // The loop back to `from` ends there; an entry that was undercut later is stale.
    if (node == from || total > tree.cost[static_cast<std::size_t>(node)]) continue;
    spread(node, total);
  }
  return tree;
}

}  // namespace orthodrive
