// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/elevate/logs/road_meetings.hpp"

#include <algorithm>
#include <cmath>
#include <queue>
#include <set>
#include <utility>

#include "orthodrive/model/roads/osm_node_id.hpp"

namespace orthodrive::elevate {
namespace {

constexpr double driven_reach_m = 10.0;

}  // namespace

Meetings find_meetings(const RoadNetwork& roads, const LogChains& chains) {
  Meetings all;
  for (std::size_t k = 0; k < roads.paths.size(); ++k)
    for (std::size_t n = 0; n < roads.paths[k].nodes.size(); ++n)
      if (const RoadNode& node = roads.paths[k].nodes[n]; is_osm_node(node.osm_node))
        all[node.osm_node].push_back({k, n, chains.chain_of[k], chains.along_m(k, node.s_m)});
  std::erase_if(all, [](const auto& entry) { return entry.second.size() < 2; });
  return all;
}

DrivenPlaces::DrivenPlaces(std::size_t chains, const std::vector<DrivenSample>& samples) : places_m_(chains) {
  for (const DrivenSample& sample : samples) places_m_[sample.chain].push_back(sample.along_m);
  for (auto& list : places_m_) std::sort(list.begin(), list.end());
}

bool DrivenPlaces::near(std::size_t chain, double along_m) const {
  const auto& list = places_m_[chain];
  const auto at = std::lower_bound(list.begin(), list.end(), along_m);
  return (at != list.end() && *at - along_m <= driven_reach_m) ||
         (at != list.begin() && along_m - *(at - 1) <= driven_reach_m);
}

std::vector<std::size_t> chains_within(const LogChains& chains, const Meetings& meetings, const DrivenPlaces& driven,
                                       double reach_m) {
  std::vector<std::vector<std::pair<double, std::int64_t>>> along(chains.chains.size());
  for (const auto& [id, places] : meetings)
    for (const Meeting& m : places) along[m.chain].push_back({m.along_m, id});
  std::map<std::int64_t, double> nearest_m;
  using Item = std::pair<double, std::int64_t>;
  std::priority_queue<Item, std::vector<Item>, std::greater<>> queue;
  const auto offer = [&](std::int64_t id, double distance_m) {
    const auto [at, fresh] = nearest_m.emplace(id, distance_m);
    if (!fresh && at->second <= distance_m) return;
    at->second = distance_m;
    if (distance_m < reach_m) queue.push({distance_m, id});
  };
  std::set<std::size_t> chosen;
  for (std::size_t c = 0; c < driven.chains(); ++c) {
    std::sort(along[c].begin(), along[c].end());
    const std::vector<double>& places_m = driven.on_chain(c);
    if (places_m.empty()) continue;
    chosen.insert(c);
    for (const auto& [s, id] : along[c]) {
      const auto at = std::lower_bound(places_m.begin(), places_m.end(), s);
      double distance_m = HUGE_VAL;
      if (at != places_m.end()) distance_m = *at - s;
      if (at != places_m.begin()) distance_m = std::min(distance_m, s - *(at - 1));
      offer(id, distance_m);
    }
  }
  while (!queue.empty()) {
    const auto [distance_m, id] = queue.top();
    queue.pop();
    if (distance_m > nearest_m[id]) continue;
    for (const Meeting& m : meetings.at(id)) {
      chosen.insert(m.chain);
      const auto& stops = along[m.chain];
      const auto here = std::lower_bound(stops.begin(), stops.end(), std::pair(m.along_m, id));
      if (here != stops.begin()) offer((here - 1)->second, distance_m + m.along_m - (here - 1)->first);
      if (here + 1 != stops.end()) offer((here + 1)->second, distance_m + (here + 1)->first - m.along_m);
    }
  }
  return {chosen.begin(), chosen.end()};
}

}  // namespace orthodrive::elevate
