#include "orthodrive/scene/tile_features.hpp"

#include <map>

namespace orthodrive::scene {
namespace {

SceneFeature feature_of(const roadquery::Road& road) {
  return {.kind = "road",
          .id = std::to_string(road.id),
          .osm_id = road.osm_id.empty() ? "" : "way/" + road.osm_id,
          .name = road.name,
          .type = road.highway};
}

template <typename T>
void append_copy(std::vector<T>& values, std::uint32_t v) {
  if (!values.empty()) values.push_back(values[v]);
}

}  // namespace

void name_roads(const roadquery::RoadQuery& query, SceneTile& tile, TriMesh& road) {
  constexpr int no_road = -1;
  std::map<int, std::uint32_t> rows;                                         // by index of the road
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> doubled;  // vertex and row
  std::vector<std::uint32_t> row_of(road.positions.size(), no_feature);
  for (std::size_t i = 0; i < road.indices.size(); i += 3) {
    Vec3 middle = tile.origin;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto& p = road.positions[road.indices[i + k]];
      middle = middle + Vec3{p[0], p[1], p[2]} * (1.0 / 3.0);
    }
    roadquery::Cursor cursor;
    const auto hit = query.find(middle.x, middle.y, middle.z, cursor, 0);
    const int index = hit ? hit->road : no_road;
    const auto [row, is_new] = rows.try_emplace(index, static_cast<std::uint32_t>(tile.features.size()));
    if (is_new)
      tile.features.push_back(index == no_road ? SceneFeature{.kind = "road"}
                                               : feature_of(query.map().roads[static_cast<std::size_t>(index)]));
    for (std::size_t k = 0; k < 3; ++k) {
      std::uint32_t& v = road.indices[i + k];
      if (row_of[v] == no_feature) row_of[v] = row->second;
      if (row_of[v] == row->second) continue;
      const auto [at, first] = doubled.try_emplace({v, row->second}, static_cast<std::uint32_t>(row_of.size()));
      if (first) {
        row_of.push_back(row->second);
        append_copy(road.positions, v);
        append_copy(road.normals, v);
        append_copy(road.uv, v);
      }
      v = at->second;
    }
  }
  road.features = std::move(row_of);
}

}  // namespace orthodrive::scene
