// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/model/road_map.hpp"

namespace orthodrive {

std::vector<RoadLine> road_lines(const RoadNetwork& roads) {
  std::vector<RoadLine> lines;
  for (const RoadPath& path : roads.paths)
    if (!path.tunnel) lines.push_back({centerline(path), 0.5 * path.nodes.front().width_m});
  return lines;
}

RoadMap road_map(const RoadNetwork& roads) { return RoadMap(road_lines(roads)); }

}  // namespace orthodrive
