// SPDX-License-Identifier: Apache-2.0
#include "roadquery/surface/short_ways.hpp"

#include <algorithm>
#include <unordered_map>

#include "roadquery/surface/junction_surface.hpp"

namespace roadquery {
namespace {

constexpr double longest_m = 2.0 * junction_transition_m;

using Places = std::unordered_map<int, std::size_t>;

/// On from a road that begins (or ends: `at_end`) at a junction; no roads where the way is too long or ends elsewhere.
ShortWay way_from(const RoadMap& map, const Places& place, std::size_t first, bool at_end) {
  ShortWay way;
  way.junctions[0] = (at_end ? map.roads[first].successor : map.roads[first].predecessor).id;
  double length_m = 0.0;
  for (std::size_t i = first;;) {
    const Road& road = map.roads[i];
    way.roads.push_back(i), length_m += road.length;
    if (length_m > longest_m) return {};
    const RoadLink& link = at_end ? road.predecessor : road.successor;
    if (link.kind == LinkKind::junction) {
      way.junctions[1] = link.id;
      return way;
    }
    const auto next = link.kind == LinkKind::road ? place.find(link.id) : place.end();
    if (next == place.end() || map.roads[next->second].junction >= 0) return {};
    if (std::find(way.roads.begin(), way.roads.end(), next->second) != way.roads.end()) return {};
    i = next->second, at_end = link.contact == ContactPoint::end;  // the end at which it is entered
  }
}

}  // namespace

std::vector<ShortWay> short_ways(const RoadMap& map) {
  Places place;
  for (std::size_t i = 0; i < map.roads.size(); ++i) place[map.roads[i].id] = i;
  std::vector<ShortWay> ways;
  for (std::size_t i = 0; i < map.roads.size(); ++i) {
    const Road& road = map.roads[i];
    if (road.junction >= 0) continue;
    for (const bool at_end : {false, true}) {
      if ((at_end ? road.successor : road.predecessor).kind != LinkKind::junction) continue;
      ShortWay way = way_from(map, place, i, at_end);
      // A way of one road is found from its end again, a longer one from its last road.
      const bool again = way.roads.size() == 1 ? at_end : way.roads.size() > 1 && way.roads.back() < i;
      if (!way.roads.empty() && !again) ways.push_back(std::move(way));
    }
  }
  return ways;
}

}  // namespace roadquery
