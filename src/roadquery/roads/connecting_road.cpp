// SPDX-License-Identifier: Apache-2.0
#include "roadquery/roads/connecting_road.hpp"

#include <algorithm>

#include "roadquery/roads/speed_limits.hpp"

namespace roadquery {
namespace {

const Road* road_outside(const RoadMap& map, const RoadLink& link) {
  if (link.kind != LinkKind::road) return nullptr;
  const auto found = std::lower_bound(map.roads.begin(), map.roads.end(), link.id,
                                      [](const Road& road, int id) { return road.id < id; });
  return found != map.roads.end() && found->id == link.id && found->junction < 0 ? &*found : nullptr;
}

bool same(const LaneMaterial& a, const LaneMaterial& b) {
  return a.s_offset == b.s_offset && a.surface == b.surface && a.friction == b.friction && a.roughness == b.roughness;
}

/// At the end of a road that a link names.
double limit_at(const Road& road, const RoadLink& link) {
  return fastest_limit_mps(road, link.contact == ContactPoint::end ? road.length : 0.0);
}

/// Of all driving lanes of a road.
std::optional<LaneMaterial> only_material(const Road& road) {
  std::optional<LaneMaterial> only;
  for (const LaneSection& section : road.sections)
    for (const auto* side : {&section.left, &section.right})
      for (const Lane& lane : *side) {
        if (!is_driven(lane.type)) continue;
        if (lane.materials.size() != 1 || (only && !same(*only, lane.materials.front()))) return std::nullopt;
        only = lane.materials.front();
      }
  return only;
}

}  // namespace

Inherited inherited(const RoadMap& map, const Road& road) {
  if (road.junction < 0) return {};
  const Road *before = road_outside(map, road.predecessor), *after = road_outside(map, road.successor);
  Inherited from;
  if (before) {
    from.highway = before->highway;
    from.material = only_material(*before);
    if (from.material && from.material->friction != 1.0) from.material.reset();
  }
  if (!before || !after) return from;
  if (before->osm_id == after->osm_id) from.osm_id = before->osm_id;
  from.speed_limit_mps = std::min(limit_at(*before, road.predecessor), limit_at(*after, road.successor));
  return from;
}

bool has_inherited_material(const Lane& lane, const Inherited& from) {
  return is_driven(lane.type) && from.material && lane.materials.size() == 1 &&
         same(lane.materials.front(), *from.material);
}

}  // namespace roadquery
