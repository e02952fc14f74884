// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/scene/tiles/tile_features.hpp"

#include <map>

#include "roadquery/map/lane_type_name.hpp"
#include "roadquery/surface/road_surface.hpp"

namespace orthodrive::scene {
namespace {

/// Beside all lanes the outermost one of that side counts. `s_m`: of the road.
LaneUnder lane_under(const roadquery::RoadQuery& query, const Vec3& p, double& s_m) {
  roadquery::Cursor cursor;
  const auto hit = query.find(p.x, p.y, p.z, cursor, roadquery::hit_position | roadquery::hit_material);
  if (!hit) return {};
  s_m = hit->s;
  const roadquery::Road& road = query.map().roads[static_cast<std::size_t>(hit->road)];
  LaneUnder under{.road = hit->road, .surface = hit->surface, .in_junction = hit->in_junction || road.junction >= 0};
  const roadquery::LaneSection& section = roadquery::section_at(road, hit->s);
  const bool left = hit->lane_id > 0 || (hit->lane_id == 0 && hit->t > roadquery::evaluate(road.lane_offset, hit->s));
  const auto& lanes = (left && !section.left.empty()) || section.right.empty() ? section.left : section.right;
  for (const roadquery::Lane& lane : lanes)
    if (lane.id == hit->lane_id || (hit->lane_id == 0 && &lane == &lanes.back()))
      under.lane_id = lane.id, under.type = lane.type;
  return under;
}

SceneFeature feature_of(const roadquery::RoadQuery& query, const LaneUnder& key) {
  if (key.road < 0) return {.kind = "road"};
  const roadquery::Road& road = query.map().roads[static_cast<std::size_t>(key.road)];
  return {.kind = "road",
          .id = std::to_string(road.id),
          .osm_id = road.osm_id.empty() ? "" : "way/" + road.osm_id,
          .name = road.name,
          .type = road.highway,
          .lane_id = std::to_string(key.lane_id),
          .lane_type = roadquery::lane_type_name(key.type)};
}

template <typename T>
void append_copy(std::vector<T>& values, std::uint32_t v) {
  if (!values.empty()) values.push_back(values[v]);
}

}  // namespace

MeshLanes name_lanes(const roadquery::RoadQuery& query, SceneTile& tile, TriMesh& road) {
  MeshLanes lanes;
  std::map<LaneUnder, std::uint32_t> rows;
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> doubled;  // vertex and row
  std::vector<std::uint32_t> row_of(road.positions.size(), no_feature);
  lanes.near_s_m.resize(road.positions.size());
  for (std::size_t i = 0; i < road.indices.size(); i += 3) {
    Vec3 middle = tile.origin;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto& p = road.positions[road.indices[i + k]];
      middle = middle + Vec3{p[0], p[1], p[2]} * (1.0 / 3.0);
    }
    double s_m = 0.0;
    const LaneUnder key = lane_under(query, middle, s_m);
    const auto [row, is_new] = rows.try_emplace(key, static_cast<std::uint32_t>(tile.features.size()));
    if (is_new) {
      tile.features.push_back(feature_of(query, key));
      lanes.by_feature.emplace(row->second, key);
    }
    for (std::size_t k = 0; k < 3; ++k) {
      std::uint32_t& v = road.indices[i + k];
      if (row_of[v] == no_feature) row_of[v] = row->second;
      if (row_of[v] == row->second) {
        lanes.near_s_m[v] = s_m;
        continue;
      }
      const auto [at, first] = doubled.try_emplace({v, row->second}, static_cast<std::uint32_t>(row_of.size()));
      if (first) {
        row_of.push_back(row->second);
        append_copy(road.positions, v);
        append_copy(road.normals, v);
        append_copy(road.uv, v);
        lanes.near_s_m.push_back(s_m);
      }
      v = at->second;
    }
  }
  road.features = std::move(row_of);
  return lanes;
}

}  // namespace orthodrive::scene
