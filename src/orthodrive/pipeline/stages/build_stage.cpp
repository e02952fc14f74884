// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/pipeline/stages/build_stage.hpp"

#include "orthodrive/core/hash.hpp"

namespace orthodrive {

nlohmann::json frame_options(const SiteFrame& frame) {
  nlohmann::json ring = nlohmann::json::array();
  for (const Vec2 p : frame.area.outer) ring.push_back({p.x, p.y});
  for (const Ring& hole : frame.area.holes)
    for (const Vec2 p : hole) ring.push_back({p.x, p.y});
  return {{"crs", frame.crs.definition}, {"area", hash_bytes(ring.dump())}};
}

}  // namespace orthodrive
