#include "orthodrive/model/road_map.hpp"

#include <utility>

namespace orthodrive {

RoadMap road_map(const RoadNetwork& roads) {
  std::vector<RoadLine> lines;
  for (const RoadPath& path : roads.paths)
    if (!path.tunnel) lines.push_back({centerline(path), 0.5 * path.nodes.front().width_m});
  return RoadMap(std::move(lines));
}

}  // namespace orthodrive
