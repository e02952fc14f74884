// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/network/crg/sample_friction.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "orthodrive/core/error.hpp"
#include "roadquery/roads/lane_material.hpp"
#include "roadquery/surface/road_surface.hpp"

namespace orthodrive {
namespace {

using roadquery::Lane;
using roadquery::Road;

constexpr double row_step_m = 0.5, column_step_m = 0.25, edge_step_m = 5.0;

bool same_everywhere(const Road& road) {
  std::set<double> values;
  for (const roadquery::LaneSection& section : road.sections)
    for (const auto* side : {&section.left, &section.right})
      for (const Lane& lane : *side) {
        if (lane.materials.empty() || lane.materials.front().s_offset > 0.0) values.insert(1.0);
        for (const roadquery::LaneMaterial& material : lane.materials) values.insert(material.friction);
      }
  return values.size() < 2;
}

/// Of the lane at t, or of the outermost one beside the road.
double friction_at(const Road& road, double s, double t) {
  const roadquery::LaneSection& section = roadquery::section_at(road, s);
  const double in_section = s - section.s, centre_t = roadquery::evaluate(road.lane_offset, s);
  const std::vector<Lane>& side = t >= centre_t && !section.left.empty() ? section.left
                                  : section.right.empty()                ? section.left
                                                                         : section.right;
  double reach = 0.0;
  for (const Lane& lane : side) {
    reach += roadquery::lane_width(lane, in_section);
    if (std::abs(t - centre_t) <= reach || &lane == &side.back())
      return roadquery::material_at(lane, in_section).friction;
  }
  return 1.0;
}

}  // namespace

CrgSurface sample_friction(const Road& road) {
  if (!(road.length > 0.0)) throw Error("a road without length has no friction grid");
  double left = 1.0, right = -1.0;
  for (double s = 0.0; s < road.length; s += edge_step_m) {
    const roadquery::Edges edges = roadquery::road_edges(road, s);
    left = std::max(left, edges.left_t), right = std::min(right, edges.right_t);
  }
  const bool uniform = same_everywhere(road);
  CrgSurface surface;
  const auto steps = uniform ? 1 : static_cast<std::size_t>(std::ceil(road.length / row_step_m));
  surface.u_increment_m = road.length / static_cast<double>(steps);
  const int first = static_cast<int>(std::floor(right / column_step_m)),
            last = static_cast<int>(std::ceil(left / column_step_m));
  for (int i = first; i <= last; i += uniform ? last - first : 1) surface.v_m.push_back(i * column_step_m);
  surface.phi_rad.assign(steps + 1, 0.0), surface.slope = surface.banking = surface.phi_rad;
  integrate_reference_line(surface, 0.0, 0.0, 0.0);
  for (std::size_t row = 0; row <= steps; ++row)
    for (const double v : surface.v_m)
      surface.grid_m.push_back(
          friction_at(road, std::min(road.length, static_cast<double>(row) * surface.u_increment_m), v));
  return surface;
}

roadquery::SurfaceCrg friction_reference(const Road& road, const std::string& file) {
  return {.file = file, .s_end = road.length, .mode = "attached", .purpose = "friction"};
}

}  // namespace orthodrive
