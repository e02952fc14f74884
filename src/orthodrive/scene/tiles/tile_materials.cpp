// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/scene/tiles/tile_materials.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "orthodrive/scene/look/mesh_materials.hpp"
#include "orthodrive/scene/look/surface_texture.hpp"
#include "roadquery/surface/road_surface.hpp"

namespace orthodrive::scene {
namespace {

constexpr double verge_photo_m = 2.0;                            // square of the photo that tints a vertex of the verge
constexpr LinearColor tunnel_road_tint = {0.11F, 0.11F, 0.11F};  // of asphalt
constexpr std::uint32_t no_tile_vertex = std::numeric_limits<std::uint32_t>::max();

bool is_on_road_border(const SceneLayout& layout, Vec2 p) {
  return layout.roads.outline().nearest(p).distance_m <= 2.0 * plan_grid_m;
}

bool is_carriageway(roadquery::LaneType type) {
  using roadquery::LaneType;
  return roadquery::is_driven(type) || type == LaneType::bus || type == LaneType::taxi || type == LaneType::biking ||
         type == LaneType::shoulder || type == LaneType::parking || type == LaneType::border;
}

/// Asphalt follows the lanes of the carriageway; the others, and junctions, lie flat.
SurfaceMaterial material_under(const LaneUnder& lane) {
  const SurfaceMaterial material = material_of(lane.surface);
  const bool follows = lane.road >= 0 && !lane.in_junction && is_carriageway(lane.type);
  return follows && material == SurfaceMaterial::asphalt ? SurfaceMaterial::lane : material;
}

/// Place of p in the texture of its lane, found from `near_s_m` on (Newton's method). Lanes side by side have their
/// cracks and patches at different places.
std::array<float, 2> lane_uv(const roadquery::Road& road, int lane_id, double near_s_m, Vec2 p) {
  constexpr int steps = 5;
  double s = near_s_m, left_m = 0.0;
  for (int i = 0; i < steps; ++i) {
    const roadquery::PlanPoint on = roadquery::reference_point(road, s);
    const Vec2 along{std::cos(on.hdg), std::sin(on.hdg)}, off = p - Vec2{on.x, on.y};
    left_m = cross(along, off);
    s = std::clamp(s + dot(along, off) / std::max(0.2, 1.0 - on.curvature * left_m), 0.0, road.length);
  }
  const roadquery::LaneSection& section = roadquery::section_at(road, near_s_m);
  const double sign = lane_id > 0 ? 1.0 : -1.0;
  double inner = roadquery::evaluate(road.lane_offset, s), outer = inner;
  for (const roadquery::Lane& lane : lane_id > 0 ? section.left : section.right) {
    inner = outer;
    outer += sign * roadquery::lane_width(lane, s - section.s);
    if (lane.id == lane_id) break;
  }
  const double left_t = std::max(inner, outer), width_m = std::abs(outer - inner);
  const double u = width_m > 0.0 ? std::clamp((left_t - left_m) / width_m, 0.0, 1.0) : 0.5;
  const double shift = std::fmod(0.37 * std::abs(lane_id) + 0.61 * (road.id % 100), 1.0);
  return {static_cast<float>(u), static_cast<float>(shift - s / lane_texture_m)};
}

}  // namespace

void add_verge(const SceneLayout& layout, const TriMesh& terrain, Vec2 center, TriMesh& verge) {
  std::vector<char> on_border(terrain.positions.size());
  const auto world = [&](std::uint32_t v) { return center + Vec2{terrain.positions[v][0], terrain.positions[v][1]}; };
  for (std::uint32_t v = 0; v < terrain.positions.size(); ++v) on_border[v] = is_on_road_border(layout, world(v));
  std::vector<std::uint32_t> slots(terrain.positions.size(), no_tile_vertex);
  for (std::size_t i = 0; i < terrain.indices.size(); i += 3) {
    const auto corners = std::span(terrain.indices).subspan(i, 3);
    if (std::ranges::none_of(corners, [&](std::uint32_t v) { return on_border[v] != 0; })) continue;
    for (const std::uint32_t v : corners) {
      if (slots[v] == no_tile_vertex) {
        slots[v] = static_cast<std::uint32_t>(verge.positions.size());
        verge.positions.push_back(terrain.positions[v]);
        verge.normals.push_back(terrain.normals[v]);
        add_tile_place(slots[v], verge);
        verge.colors.push_back(
            mesh_color(photo_mean(*layout.photo, world(v), verge_photo_m), on_border[v] != 0 ? 1.0 : 0.0));
      }
      verge.indices.push_back(slots[v]);
    }
  }
  verge.parts = {{SurfaceMaterial::verge, 0, verge.indices.size()}};
}

void add_road_materials(const SceneLayout& layout, Vec2 center, const MeshLanes& lanes, TriMesh& road) {
  PartedTriangles parts;
  for (std::size_t i = 0; i < road.indices.size(); i += 3)
    parts.add(material_under(lanes.by_feature.at(road.features[road.indices[i]])),
              {road.indices[i], road.indices[i + 1], road.indices[i + 2]});
  parts.finish(road);
  for (std::size_t i = 0; i < road.positions.size(); ++i) {
    const Vec2 p = center + Vec2{road.positions[i][0], road.positions[i][1]};
    const auto under = lanes.by_feature.find(road.features[i]);
    if (under != lanes.by_feature.end() && material_under(under->second) == SurfaceMaterial::lane) {
      const LaneUnder& lane = under->second;
      const auto& roads = layout.query->map().roads;
      road.tile_uv.push_back(lane_uv(roads[static_cast<std::size_t>(lane.road)], lane.lane_id, lanes.near_s_m[i], p));
    } else {
      add_tile_place(i, road);
    }
    const bool is_seen = road.kind != MeshKind::tunnel_road;  // by the photo
    LinearColor tint = is_seen ? layout.tint.at(p) : tunnel_road_tint;
    if (under != lanes.by_feature.end() && material_of(under->second.surface) == SurfaceMaterial::asphalt)
      tint = as_asphalt(tint);
    road.colors.push_back(mesh_color(tint));
  }
}

void add_water_material(const SceneLayout& layout, Vec2 center, TriMesh& water) {
  for (const auto& p : water.positions) {
    const WaterBody* body = layout.waters.at(center + Vec2{p[0], p[1]});
    water.colors.push_back(mesh_color(body ? body->color : LinearColor{}));
  }
  add_material(SurfaceMaterial::water, water);
}

}  // namespace orthodrive::scene
