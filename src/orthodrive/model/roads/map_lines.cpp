// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/model/roads/map_lines.hpp"

namespace orthodrive {

std::vector<RoadLine> road_lines(const RoadNetwork& roads) {
  std::vector<RoadLine> lines;
  for (const RoadPath& path : roads.paths)
    if (!path.tunnel) lines.push_back({centerline(path), 0.5 * path.nodes.front().width_m});
  return lines;
}

MapLines map_lines(const RoadNetwork& roads) { return MapLines(road_lines(roads)); }

}  // namespace orthodrive
