// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/scene/look/mesh_materials.hpp"

#include <algorithm>
#include <cmath>

#include "orthodrive/scene/look/surface_texture.hpp"

namespace orthodrive::scene {
namespace {

std::array<float, 2> tile_uv(double x_m, double y_m) {
  return {static_cast<float>(x_m / surface_texture_m), static_cast<float>(-y_m / surface_texture_m)};
}

}  // namespace

SurfaceMaterial material_of(roadquery::SurfaceClass surface) {
  switch (surface) {
    case roadquery::SurfaceClass::concrete:
      return SurfaceMaterial::concrete;
    case roadquery::SurfaceClass::setts:
      return SurfaceMaterial::setts;
    case roadquery::SurfaceClass::gravel:
      return SurfaceMaterial::gravel;
    case roadquery::SurfaceClass::ground:
      return SurfaceMaterial::ground;
    case roadquery::SurfaceClass::asphalt:
      break;
  }
  return SurfaceMaterial::asphalt;
}

std::array<std::uint16_t, 4> mesh_color(const LinearColor& color, double opacity) {
  const auto word = [](double v) { return static_cast<std::uint16_t>(std::lround(65535.0 * std::clamp(v, 0.0, 1.0))); };
  const auto over_texture = [&](float v) { return word(static_cast<double>(v) / surface_texture_mean); };
  return {over_texture(color[0]), over_texture(color[1]), over_texture(color[2]), word(opacity)};
}

void PartedTriangles::add(SurfaceMaterial material, std::array<std::uint32_t, 3> triangle) {
  auto& indices = by_material_[static_cast<std::size_t>(material)];
  indices.insert(indices.end(), triangle.begin(), triangle.end());
}

void PartedTriangles::finish(TriMesh& mesh) const {
  mesh.indices.clear();
  mesh.parts.clear();
  for (std::size_t m = 0; m < by_material_.size(); ++m) {
    if (by_material_[m].empty()) continue;
    mesh.parts.push_back({static_cast<SurfaceMaterial>(m), mesh.indices.size(), by_material_[m].size()});
    mesh.indices.insert(mesh.indices.end(), by_material_[m].begin(), by_material_[m].end());
  }
}

void add_tile_place(std::size_t vertex, TriMesh& mesh) {
  const auto &p = mesh.positions[vertex], &n = mesh.normals[vertex];
  if (std::abs(n[2]) > 0.5F) {
    mesh.tile_uv.push_back(tile_uv(p[0], p[1]));
    return;
  }
  const float length = std::hypot(n[0], n[1]);
  mesh.tile_uv.push_back(tile_uv((n[0] * p[1] - n[1] * p[0]) / length, p[2]));
}

void add_plain_material(SurfaceMaterial material, const LinearColor& color, TriMesh& mesh) {
  mesh.colors.assign(mesh.positions.size(), mesh_color(color));
  add_material(material, mesh);
}

void add_material(SurfaceMaterial material, TriMesh& mesh) {
  mesh.parts = {{material, 0, mesh.indices.size()}};
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) add_tile_place(i, mesh);
}

}  // namespace orthodrive::scene
