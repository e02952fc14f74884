// SPDX-License-Identifier: Apache-2.0
#pragma once
// What a lane is made of at a place.

#include "roadquery/map/road_map.hpp"

namespace roadquery {

/// At a distance from the start of the lane section; asphalt with friction 1 before the first entry and without any.
[[nodiscard]] inline LaneMaterial material_at(const Lane& lane, double s_in_section) {
  LaneMaterial found;
  for (const LaneMaterial& material : lane.materials) {
    if (material.s_offset > s_in_section) break;
    found = material;
  }
  return found;
}

}  // namespace roadquery
