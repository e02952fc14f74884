// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/pipeline/stages/bare_road_finding.hpp"

#include <fmt/format.h>

#include "roadquery/roads/bare_roads.hpp"
#include "roadquery/surface/road_surface.hpp"

namespace orthodrive {

std::optional<Finding> widen_bare_roads(roadquery::RoadMap& map, double width_m, const std::string& stage) {
  const std::vector<std::size_t> bare = roadquery::widen_bare_roads(map, width_m);
  if (bare.empty()) return std::nullopt;
  const roadquery::PlanPoint at = roadquery::reference_point(map.roads[bare.front()], 0.0);
  return Finding{
      Severity::info, stage + ".bare_roads",
      fmt::format("{} roads have no lanes and are {:g} m wide along their reference lines", bare.size(), width_m), at.x,
      at.y};
}

}  // namespace orthodrive
