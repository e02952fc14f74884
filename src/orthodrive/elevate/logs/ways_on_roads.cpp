// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/elevate/logs/ways_on_roads.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <queue>
#include <utility>

#include "orthodrive/model/roads/osm_node_id.hpp"

namespace orthodrive::elevate {
namespace {

constexpr double backwards_m = 5.0;  // noise may put a pose behind the one before

/// How far `to` lies ahead on the path of `from`; -infinity on another path or in the other direction.
double ahead_m(const DirectedPlace& from, const DirectedPlace& to) {
  if (from.path != to.path || from.forward != to.forward) return -HUGE_VAL;
  return from.forward ? to.s_m - from.s_m : from.s_m - to.s_m;
}

}  // namespace

WaysOnRoads::WaysOnRoads(const RoadNetwork& roads) : roads_(roads), stops_(roads.paths.size()) {
  std::map<std::int64_t, int> uses;
  for (const RoadPath& path : roads.paths)
    for (const RoadNode& node : path.nodes)
      if (is_osm_node(node.osm_node)) ++uses[node.osm_node];
  std::map<std::int64_t, std::size_t> vertex_of;
  for (std::size_t k = 0; k < roads.paths.size(); ++k)
    for (const RoadNode& node : roads.paths[k].nodes) {
      if (!is_osm_node(node.osm_node) || uses[node.osm_node] < 2) continue;
      const auto [at, fresh] = vertex_of.emplace(node.osm_node, vertex_of.size());
      if (fresh) visits_.emplace_back();
      visits_[at->second].push_back({k, stops_[k].size()});
      stops_[k].push_back({node.s_m, at->second});
    }
}

/// The stop ahead of a place in its direction of travel; none behind the last.
const WaysOnRoads::Stop* WaysOnRoads::stop_after(const DirectedPlace& from) const {
  const auto& along = stops_[from.path];
  if (from.forward) {
    const auto at =
        std::lower_bound(along.begin(), along.end(), from.s_m, [](const Stop& a, double s) { return a.s_m < s; });
    return at == along.end() ? nullptr : &*at;
  }
  const auto at =
      std::upper_bound(along.begin(), along.end(), from.s_m, [](double s, const Stop& a) { return s < a.s_m; });
  return at == along.begin() ? nullptr : &*(at - 1);
}

/// The stop before a place in its direction of travel; none before the first.
const WaysOnRoads::Stop* WaysOnRoads::stop_before(const DirectedPlace& to) const {
  return stop_after({.path = to.path, .s_m = to.s_m, .forward = !to.forward});
}

WaysOnRoads::Reach WaysOnRoads::reach_from(const DirectedPlace& from, double limit_m) const {
  Reach reach;
  using Item = std::pair<double, std::size_t>;
  std::priority_queue<Item, std::vector<Item>, std::greater<>> queue;
  const auto offer = [&](std::size_t vertex, double way_m, std::optional<std::size_t> before,
                         const DrivenStretch& stretch) {
    if (way_m > limit_m) return;
    Reached& reached = reach[vertex];
    if (way_m >= reached.way_m) return;
    reached = {way_m, before, stretch};
    queue.push({way_m, vertex});
  };
  if (const Stop* stop = stop_after(from))
    offer(stop->vertex, from.forward ? stop->s_m - from.s_m : from.s_m - stop->s_m, {},
          {from.path, from.s_m, stop->s_m});
  while (!queue.empty()) {
    const auto [way_m, vertex] = queue.top();
    queue.pop();
    const Reached here = reach[vertex];
    if (way_m > here.way_m) continue;
    for (const Visit& visit : visits_[vertex]) {
      const auto& along = stops_[visit.path];
      const double s = along[visit.stop].s_m;
      const bool same_place = here.stretch.path == visit.path && here.stretch.s_to == s;  // never turn on the spot
      const bool came_forward = same_place && here.stretch.s_from < s;
      const bool came_backward = same_place && here.stretch.s_from > s;
      if (visit.stop + 1 < along.size() && !came_backward)
        offer(along[visit.stop + 1].vertex, way_m + along[visit.stop + 1].s_m - s, vertex,
              {visit.path, s, along[visit.stop + 1].s_m});
      if (visit.stop > 0 && !came_forward && roads_.paths[visit.path].oneway == Oneway::no)
        offer(along[visit.stop - 1].vertex, way_m + s - along[visit.stop - 1].s_m, vertex,
              {visit.path, s, along[visit.stop - 1].s_m});
    }
  }
  return reach;
}

double WaysOnRoads::way_m(const DirectedPlace& from, const DirectedPlace& to, const Reach& reach) const {
  double best = std::numeric_limits<double>::infinity();
  if (const double straight = ahead_m(from, to); straight >= -backwards_m) best = std::abs(straight);
  if (const Stop* stop = stop_before(to))
    if (const auto at = reach.find(stop->vertex); at != reach.end())
      best = std::min(best, at->second.way_m + std::abs(to.s_m - stop->s_m));
  return best;
}

std::vector<DrivenStretch> WaysOnRoads::stretches(const DirectedPlace& from, const DirectedPlace& to,
                                                  const Reach& reach) const {
  const double straight = ahead_m(from, to);
  const Stop* stop = stop_before(to);
  const auto at = stop ? reach.find(stop->vertex) : reach.end();
  const double round = at != reach.end() ? at->second.way_m + std::abs(to.s_m - stop->s_m) : HUGE_VAL;
  if (straight >= -backwards_m && std::abs(straight) <= round) return {{from.path, from.s_m, to.s_m}};
  std::vector<DrivenStretch> way{{to.path, stop->s_m, to.s_m}};
  for (std::optional<std::size_t> vertex = stop->vertex; vertex; vertex = reach.at(*vertex).before)
    way.push_back(reach.at(*vertex).stretch);
  std::reverse(way.begin(), way.end());
  return way;
}

}  // namespace orthodrive::elevate
