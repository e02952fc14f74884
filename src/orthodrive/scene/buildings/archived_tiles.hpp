// SPDX-License-Identifier: Apache-2.0
#pragma once
// The fields of tiles and buildings that processes which share a scene hand each other (core/byte_archive.hpp).

#include "orthodrive/model/archived_fields.hpp"
#include "orthodrive/model/scene.hpp"
#include "orthodrive/scene/buildings/buildings.hpp"

namespace orthodrive {

template <typename Archive>
void fields(Archive& archive, MeshPart& p) {
  archive(p.material, p.first_index, p.index_count);
}
template <typename Archive>
void fields(Archive& archive, TriMesh& m) {
  archive(m.kind, m.positions, m.normals, m.uv, m.indices, m.parts, m.tile_uv, m.colors, m.features);
}
template <typename Archive>
void fields(Archive& archive, SceneFeature& f) {
  archive(f.kind, f.id, f.osm_id, f.name, f.type, f.lane_id, f.lane_type);
}
template <typename Archive>
void fields(Archive& archive, MeshInstance& i) {
  archive(i.position, i.yaw_rad, i.scale, i.tint);
}
template <typename Archive>
void fields(Archive& archive, InstancedMesh& i) {
  archive(i.mesh, i.instances);
}
template <typename Archive>
void fields(Archive& archive, SceneTile& t) {
  archive(t.level, t.column, t.row, t.origin, t.min_z_m, t.max_z_m, t.geometric_error_m, t.meshes, t.lids, t.instanced,
          t.texture_rgb, t.labels, t.classes, t.features);
}

namespace scene {

template <typename Archive>
void fields(Archive& archive, Roof& r) {
  archive(r.shape, r.rise_m, r.slopes, r.gables, r.ridge);
}
template <typename Archive>
void fields(Archive& archive, PlacedBuilding& b) {
  archive(b.middle, b.footprint, b.roof, b.foot_z_m, b.base_z_m, b.eaves_z_m, b.hovers, b.storeys, b.look,
          b.wall_material, b.roof_material, b.wall_color, b.roof_color, b.seed, b.front, b.door_z_m, b.parapet_m,
          b.eaves_m, b.posts, b.chimney, b.use, b.osm_id);
}

}  // namespace scene
}  // namespace orthodrive
