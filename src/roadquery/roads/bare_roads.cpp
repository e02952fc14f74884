// SPDX-License-Identifier: Apache-2.0
#include "roadquery/roads/bare_roads.hpp"

#include <algorithm>

namespace roadquery {

std::vector<std::size_t> widen_bare_roads(RoadMap& map, double width_m) {
  const auto lane = [&](int id) {
    Lane made;
    made.id = id;
    made.width = {{0.0, 0.5 * width_m, 0.0, 0.0, 0.0}};
    return made;
  };
  std::vector<std::size_t> widened;
  for (std::size_t i = 0; i < map.roads.size(); ++i) {
    Road& road = map.roads[i];
    const bool is_bare = std::all_of(road.sections.begin(), road.sections.end(), [](const LaneSection& section) {
      return section.left.empty() && section.right.empty();
    });
    if (!is_bare || road.sections.empty()) continue;
    for (LaneSection& section : road.sections) section.left = {lane(1)}, section.right = {lane(-1)};
    widened.push_back(i);
  }
  return widened;
}

}  // namespace roadquery
