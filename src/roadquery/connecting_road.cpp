#include "roadquery/connecting_road.hpp"

#include <algorithm>

namespace roadquery {
namespace {

const Road* road_outside(const RoadMap& map, const RoadLink& link) {
  if (link.kind != LinkKind::road) return nullptr;
  const auto found = std::lower_bound(map.roads.begin(), map.roads.end(), link.id,
                                      [](const Road& road, int id) { return road.id < id; });
  return found != map.roads.end() && found->id == link.id && found->junction < 0 ? &*found : nullptr;
}

}  // namespace

Inherited inherited(const RoadMap& map, const Road& road) {
  if (road.junction < 0) return {};
  const Road *before = road_outside(map, road.predecessor), *after = road_outside(map, road.successor);
  Inherited from;
  if (before) from.highway = before->highway;
  if (!before || !after) return from;
  if (before->osm_id == after->osm_id) from.osm_id = before->osm_id;
  from.speed_limit_mps = std::min(before->speed_limit_mps, after->speed_limit_mps);
  return from;
}

}  // namespace roadquery
