// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/scene/plan/simplify_mesh.hpp"

#include <meshoptimizer.h>

#include <algorithm>
#include <cstdint>
#include <map>
#include <vector>

namespace orthodrive::scene {
namespace {

/// Drops vertices that no triangle has.
TriMesh without_unused(const TriMesh& mesh) {
  TriMesh result{.kind = mesh.kind, .indices = mesh.indices, .parts = mesh.parts};
  std::map<std::uint32_t, std::uint32_t> slots;
  for (const std::uint32_t v : mesh.indices) slots.try_emplace(v, 0);
  std::uint32_t next = 0;
  for (auto& [v, slot] : slots) {
    slot = next++;
    result.positions.push_back(mesh.positions[v]);
    result.normals.push_back(mesh.normals[v]);
    if (!mesh.tile_uv.empty()) result.tile_uv.push_back(mesh.tile_uv[v]);
    if (!mesh.colors.empty()) result.colors.push_back(mesh.colors[v]);
  }
  for (std::uint32_t& v : result.indices) v = slots.at(v);
  return result;
}

}  // namespace

double simplify(TriMesh& mesh, double tolerance_m) {
  if (mesh.indices.empty()) return 0.0;
  constexpr std::size_t stride = sizeof(mesh.positions[0]);
  const float* first = mesh.positions.front().data();
  const float scale_m = meshopt_simplifyScale(first, mesh.positions.size(), stride);
  float worst = 0.0F;
  std::vector<std::uint32_t> indices;
  for (MeshPart& part : mesh.parts) {
    std::vector<std::uint32_t> kept(part.index_count);
    float error = 0.0F;
    kept.resize(meshopt_simplify(kept.data(), &mesh.indices[part.first_index], part.index_count, first,
                                 mesh.positions.size(), stride, 0, static_cast<float>(tolerance_m) / scale_m, 0,
                                 &error));
    worst = std::max(worst, error);
    part = {part.material, indices.size(), kept.size()};
    indices.insert(indices.end(), kept.begin(), kept.end());
  }
  std::erase_if(mesh.parts, [](const MeshPart& part) { return part.index_count == 0; });
  mesh.indices = std::move(indices);
  mesh = without_unused(mesh);
  return static_cast<double>(worst * scale_m);
}

}  // namespace orthodrive::scene
