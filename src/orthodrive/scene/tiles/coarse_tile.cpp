// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/scene/tiles/coarse_tile.hpp"

#include <meshoptimizer.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <tuple>

#include "orthodrive/core/disjoint_sets.hpp"
#include "orthodrive/scene/buildings/building_blocks.hpp"
#include "orthodrive/scene/ground/coarse_ground.hpp"
#include "orthodrive/scene/plan/simplify_mesh.hpp"
#include "orthodrive/scene/structures/structures.hpp"

namespace orthodrive::scene {
namespace {

constexpr double base_tolerance_m = 0.25, base_square_m = 2.0;  // times 2^level
constexpr int first_level_of_squares = 2, first_level_without_trees = 4;
constexpr std::size_t lump_vertices = 10;

/// Not joined: paint, verges, rails, railways, objects and tunnels do not show from afar, buildings are made anew.
bool is_left_out(MeshKind kind) {
  return kind == MeshKind::verge || kind == MeshKind::marking || kind == MeshKind::rails || kind == MeshKind::track ||
         kind == MeshKind::building || kind == MeshKind::object || kind == MeshKind::tunnel ||
         kind == MeshKind::tunnel_road;
}

/// Openings for tunnels become ground again. Returns the height of the highest face of their walls and portals, which
/// the coarser ground is off by.
double close_openings(SceneTile& tile) {
  if (tile.lids.indices.empty()) return 0.0;
  float highest = 0.0F;
  for (const TriMesh& mesh : tile.meshes) {
    if (mesh.kind != MeshKind::tunnel) continue;
    for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
      const auto z = [&](std::size_t k) { return mesh.positions[mesh.indices[i + k]][2]; };
      const auto [low, high] = std::minmax({z(0), z(1), z(2)});
      highest = std::max(highest, high - low);
    }
  }
  tile.meshes.push_back(std::move(tile.lids));
  tile.lids = {};
  return static_cast<double>(highest);
}
bool is_ground(MeshKind kind) { return kind == MeshKind::terrain || kind == MeshKind::water || kind == MeshKind::road; }

/// Where a tile lies in its parent.
struct Quadrant {
  int column = 0, row = 0;
};
Quadrant quadrant_of(const SceneTile& tile) { return {tile.column & 1, tile.row & 1}; }

/// Calls visit(tile, pixel) for the four pixels that become one; rows count from the north.
template <typename Visit>
void each_source(std::span<const SceneTile* const> tiles, int size, int col, int row, const Visit& visit) {
  for (int k = 0; k < 4; ++k) {
    const int c = 2 * col + k % 2, r = 2 * row + k / 2;
    for (const SceneTile* tile : tiles) {
      const Quadrant q = quadrant_of(*tile);
      if (q.column == c / size && 1 - q.row == r / size) visit(*tile, c % size, r % size);
    }
  }
}

Raster<std::uint8_t> halved_photo(std::span<const SceneTile* const> tiles) {
  int size = 0;
  for (const SceneTile* tile : tiles) size = std::max(size, tile->texture_rgb.width);
  if (size == 0) return {};
  constexpr std::uint8_t no_photo_grey = 128;
  Raster<std::uint8_t> rgb(size, size, 3, no_photo_grey);
  for (int row = 0; row < size; ++row) {
    for (int col = 0; col < size; ++col) {
      std::array<int, 3> sum{};
      int count = 0;
      each_source(tiles, size, col, row, [&](const SceneTile& tile, int c, int r) {
        if (tile.texture_rgb.empty()) return;
        const std::uint8_t* pixel = &tile.texture_rgb.data[tile.texture_rgb.index(c, r)];
        for (std::size_t channel = 0; channel < 3; ++channel) sum[channel] += pixel[channel];
        ++count;
      });
      for (int channel = 0; count > 0 && channel < 3; ++channel)
        rgb.at(col, row, channel) =
            static_cast<std::uint8_t>((sum[static_cast<std::size_t>(channel)] + count / 2) / count);
    }
  }
  return rgb;
}

/// Every other pixel of every other row.
Raster<std::uint8_t> halved_labels(std::span<const SceneTile* const> tiles) {
  int size = 0;
  for (const SceneTile* tile : tiles) size = std::max(size, tile->labels.width);
  if (size == 0) return {};
  Raster<std::uint8_t> labels(size, size, 1, label_nodata);
  for (int row = 0; row < size; ++row)
    for (int col = 0; col < size; ++col)
      for (const SceneTile* tile : tiles) {
        const Quadrant q = quadrant_of(*tile);
        if (q.column == 2 * col / size && 1 - q.row == 2 * row / size && !tile->labels.empty())
          labels.at(col, row) = tile->labels.at(2 * col % size, 2 * row % size);
      }
  return labels;
}

template <typename T>
void append(std::vector<T>& to, const std::vector<T>& from) {
  to.insert(to.end(), from.begin(), from.end());
}

/// Meshes of one kind with their materials, in the frame of the new tile.
TriMesh joined(std::span<const SceneTile* const> tiles, MeshKind kind, Vec3 origin) {
  TriMesh all{.kind = kind};
  std::map<SurfaceMaterial, std::vector<std::uint32_t>> by_material;
  for (const SceneTile* tile : tiles) {
    const Vec3 moved = tile->origin - origin;
    for (const TriMesh& mesh : tile->meshes) {
      if (mesh.kind != kind) continue;
      const auto base = static_cast<std::uint32_t>(all.positions.size());
      for (const auto& p : mesh.positions) {
        const auto f = [](double v) { return static_cast<float>(v); };
        all.positions.push_back({f(p[0] + moved.x), f(p[1] + moved.y), f(p[2] + moved.z)});
      }
      append(all.normals, mesh.normals);
      append(all.tile_uv, mesh.tile_uv);
      append(all.colors, mesh.colors);
      for (const MeshPart& part : mesh.parts)
        for (std::size_t i = 0; i < part.index_count; ++i)
          by_material[part.material].push_back(base + mesh.indices[part.first_index + i]);
    }
  }
  for (const auto& [material, indices] : by_material) {
    all.parts.push_back({material, all.indices.size(), indices.size()});
    append(all.indices, indices);
  }
  return all;
}

/// Takes out what hangs together and has no face as high as the tolerance: kerbs, low walls. Returns the height of the
/// highest face that is gone.
double leave_out_low(TriMesh& mesh, double tolerance_m) {
  std::map<std::array<float, 3>, std::size_t> first_at;
  DisjointSets together(mesh.positions.size());
  for (std::size_t i = 0; i < mesh.positions.size(); ++i)
    together.join(i, first_at.try_emplace(mesh.positions[i], i).first->second);
  std::vector<double> height_m(mesh.positions.size(), 0.0);  // of the highest face, by the first vertex
  for (std::size_t i = 0; i < mesh.indices.size(); i += 3)
    for (std::size_t k = 1; k < 3; ++k) together.join(mesh.indices[i], mesh.indices[i + k]);
  for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
    const auto z = [&](std::size_t k) { return static_cast<double>(mesh.positions[mesh.indices[i + k]][2]); };
    const auto [low, high] = std::minmax({z(0), z(1), z(2)});
    double& highest = height_m[together.find(mesh.indices[i])];
    highest = std::max(highest, high - low);
  }
  double gone_m = 0.0;
  std::vector<std::uint32_t> indices;
  for (MeshPart& part : mesh.parts) {
    const std::size_t first = indices.size();
    for (std::size_t i = part.first_index; i < part.first_index + part.index_count; i += 3) {
      const double height = height_m[together.find(mesh.indices[i])];
      if (height < tolerance_m)
        gone_m = std::max(gone_m, height);
      else
        indices.insert(indices.end(), {mesh.indices[i], mesh.indices[i + 1], mesh.indices[i + 2]});
    }
    part = {part.material, first, indices.size() - first};
  }
  std::erase_if(mesh.parts, [](const MeshPart& part) { return part.index_count == 0; });
  mesh.indices = std::move(indices);
  return gone_m;
}

/// Largest distance from the shape's axis between two heights.
float reach_between(const TriMesh& shape, float low, float high) {
  float reach = 0.0F;
  for (const auto& p : shape.positions)
    if (p[2] >= low && p[2] <= high) reach = std::max(reach, std::hypot(p[0], p[1]));
  return reach;
}

/// The foliage of a shape as two squares between two tips, 16 triangles; as wide as the shape at their heights.
TriMesh lump_of(const TriMesh& shape) {
  if (shape.positions.size() <= lump_vertices) return shape;
  constexpr float trunk = 0.3F;
  float low = 1.0F, high = 0.0F;
  std::array<double, 4> color{};
  std::size_t count = 0;
  for (std::size_t i = 0; i < shape.positions.size(); ++i) {
    const auto& p = shape.positions[i];
    high = std::max(high, p[2]);
    if (std::hypot(p[0], p[1]) < trunk) continue;
    low = std::min(low, p[2]);
    for (std::size_t c = 0; c < 4; ++c) color[c] += shape.colors[i][c];
    ++count;
  }
  TriMesh lump{.kind = shape.kind};
  const auto add = [&](std::array<float, 3> p, std::array<float, 3> normal) {
    lump.positions.push_back(p);
    lump.normals.push_back(normal);
    lump.tile_uv.push_back({p[0] - p[1], p[2]});
    auto& word = lump.colors.emplace_back();
    for (std::size_t c = 0; c < 4; ++c) word[c] = static_cast<std::uint16_t>(color[c] / static_cast<double>(count));
  };
  const float band = 0.25F * (high - low);
  add({0.0F, 0.0F, low}, {0.0F, 0.0F, -1.0F});
  for (const float z : {low + band, low + 2.5F * band}) {
    const float r = reach_between(shape, z - 0.6F * band, z + 0.6F * band);
    for (const auto& [x, y] : {std::pair{1.0F, 0.0F}, {0.0F, 1.0F}, {-1.0F, 0.0F}, {0.0F, -1.0F}})
      add({r * x, r * y, z}, {x, y, 0.0F});
  }
  add({0.0F, 0.0F, high}, {0.0F, 0.0F, 1.0F});
  for (std::uint32_t k = 0; k < 4; ++k) {
    const std::uint32_t a = 1 + k, b = 1 + (k + 1) % 4, c = a + 4, d = b + 4;
    lump.indices.insert(lump.indices.end(), {0, b, a, a, b, d, a, d, c, c, d, 9});
  }
  lump.parts = {{SurfaceMaterial::foliage, 0, lump.indices.size()}};
  return lump;
}

using Copies = std::vector<InstancedMesh>;

/// All copies of shapes that are equal, as copies of one lump.
Copies joined_copies(std::span<const SceneTile* const> tiles, Vec3 origin) {
  Copies all;
  std::vector<const TriMesh*> shapes;
  for (const SceneTile* tile : tiles) {
    const Vec3 moved = tile->origin - origin;
    for (const InstancedMesh& copied : tile->instanced) {
      const auto same = std::ranges::find_if(shapes, [&](const TriMesh* shape) {
        return shape->positions == copied.mesh.positions && shape->colors == copied.mesh.colors;
      });
      const auto at = static_cast<std::size_t>(same - shapes.begin());
      if (same == shapes.end()) {
        shapes.push_back(&copied.mesh);
        all.push_back({lump_of(copied.mesh), {}});
      }
      for (MeshInstance copy : copied.instances) {
        for (const auto& [axis, m] : {std::pair{0, moved.x}, {1, moved.y}, {2, moved.z}})
          copy.position[static_cast<std::size_t>(axis)] += static_cast<float>(m);
        all[at].instances.push_back(copy);
      }
    }
  }
  return all;
}

/// In each square of the plan the tallest copy, as wide as all together.
Copies one_a_square(const Copies& copies, double square_m) {
  struct Square {
    std::size_t shape = 0;
    MeshInstance tallest;
    float radius2 = 0.0F;
    std::array<float, 3> tint{};
  };
  std::map<std::pair<int, int>, Square> squares;
  for (std::size_t shape = 0; shape < copies.size(); ++shape) {
    for (const MeshInstance& copy : copies[shape].instances) {
      const auto cell = [&](float v) { return static_cast<int>(std::floor(static_cast<double>(v) / square_m)); };
      Square& square = squares[{cell(copy.position[0]), cell(copy.position[1])}];
      const auto order = [](const MeshInstance& c) { return std::tuple(c.scale[2], c.position); };
      if (square.radius2 == 0.0F || order(copy) > order(square.tallest)) square.shape = shape, square.tallest = copy;
      const float radius2 = copy.scale[0] * copy.scale[0];
      square.radius2 += radius2;
      for (std::size_t c = 0; c < 3; ++c) square.tint[c] += radius2 * copy.tint[c];
    }
  }
  Copies result = copies;
  for (InstancedMesh& copied : result) copied.instances.clear();
  for (const auto& [cell, square] : squares) {
    MeshInstance copy = square.tallest;
    copy.scale[0] = copy.scale[1] = std::min(std::sqrt(square.radius2), static_cast<float>(0.7 * square_m));
    for (std::size_t c = 0; c < 3; ++c) copy.tint[c] = square.tint[c] / square.radius2;
    result[square.shape].instances.push_back(copy);
  }
  return result;
}

double tallest_m(const Copies& copies) {
  float tallest = 0.0F;
  for (const InstancedMesh& copied : copies)
    for (const MeshInstance& copy : copied.instances) tallest = std::max(tallest, copy.scale[2]);
  return static_cast<double>(tallest);
}

/// Returns the error of what is no longer there.
double add_trees(std::span<const SceneTile* const> tiles, SceneTile& coarse) {
  Copies copies = joined_copies(tiles, coarse.origin);
  double error_m = 0.0;
  if (coarse.level >= first_level_without_trees) {
    error_m = tallest_m(copies);
    copies.clear();
  } else if (coarse.level >= first_level_of_squares && !copies.empty()) {
    const double square_m = std::ldexp(base_square_m, coarse.level);
    copies = one_a_square(copies, square_m);
    error_m = 0.5 * square_m;
  }
  std::erase_if(copies, [](const InstancedMesh& copied) { return copied.instances.empty(); });
  coarse.instanced = std::move(copies);
  return error_m;
}

/// As much as the trees of the level may be off: they are left out one by one from the second level on.
BlockOptions block_options(int level) {
  return {.outline_m = std::ldexp(base_tolerance_m, level),
          .roof_m = std::ldexp(2.0 * base_tolerance_m, level),
          .size_m = level < first_level_of_squares ? 0.0 : std::ldexp(0.5 * base_square_m, level)};
}

}  // namespace

bool is_seen_on(const PlacedBuilding& building, int level) { return height_m(building) > block_options(level).size_m; }

SceneTile ready_to_coarsen(SceneTile tile) {
  if (std::ranges::any_of(tile.meshes, [](const TriMesh& mesh) { return mesh.kind == MeshKind::rails; }))
    tile.geometric_error_m = std::max(tile.geometric_error_m, railing_height_m);
  tile.geometric_error_m = std::max(tile.geometric_error_m, close_openings(tile));
  std::erase_if(tile.meshes, [](const TriMesh& mesh) { return is_left_out(mesh.kind); });
  std::erase_if(tile.instanced, [](const InstancedMesh& copied) { return copied.mesh.kind != MeshKind::tree; });
  tile.features = {};
  for (TriMesh& mesh : tile.meshes)
    if (is_ground(mesh.kind)) mesh.uv = {}, mesh.tile_uv = {}, mesh.colors = {};
  return tile;
}

SceneTile coarse_tile(std::span<const SceneTile* const> tiles, std::span<const PlacedBuilding* const> buildings) {
  const SceneTile& first = *tiles.front();
  const TileAddress address = parent_of({first.column, first.row});
  const int level = first.level + 1;
  const double side_m = std::ldexp(scene_tile_m, level), tolerance_m = std::ldexp(base_tolerance_m, level);
  SceneTile coarse{.level = level, .column = address.column, .row = address.row};
  coarse.origin = {(address.column + 0.5) * side_m, (address.row + 0.5) * side_m, first.origin.z};
  coarse.min_z_m = std::numeric_limits<double>::infinity(), coarse.max_z_m = -coarse.min_z_m;
  double below_m = 0.0;
  for (const SceneTile* tile : tiles) {
    coarse.min_z_m = std::min(coarse.min_z_m, tile->min_z_m);
    coarse.max_z_m = std::max(coarse.max_z_m, tile->max_z_m);
    below_m = std::max(below_m, tile->geometric_error_m);
  }

  CoarseGround ground = coarse_ground(tiles, {.origin = coarse.origin, .side_m = side_m, .tolerance_m = tolerance_m});
  double change_m = ground.error_m;
  for (TriMesh* mesh : {&ground.terrain, &ground.road})
    if (!mesh->indices.empty()) coarse.meshes.push_back(std::move(*mesh));
  std::set<MeshKind> standing;
  for (const SceneTile* tile : tiles)
    for (const TriMesh& mesh : tile->meshes)
      if (!is_ground(mesh.kind) && !is_left_out(mesh.kind)) standing.insert(mesh.kind);
  for (const MeshKind kind : standing) {
    TriMesh mesh = joined(tiles, kind, coarse.origin);
    change_m = std::max(change_m, leave_out_low(mesh, tolerance_m));
    change_m = std::max(change_m, simplify(mesh, tolerance_m));
    if (!mesh.indices.empty()) coarse.meshes.push_back(std::move(mesh));
  }
  Blocks blocks = building_blocks(buildings, coarse.origin, block_options(level));
  if (!blocks.mesh.indices.empty()) coarse.meshes.push_back(std::move(blocks.mesh));
  const double trees_m = add_trees(tiles, coarse);

  coarse.texture_rgb = halved_photo(tiles);
  coarse.labels = halved_labels(tiles);
  for (const SceneTile* tile : tiles)
    if (!tile->classes.classes.empty()) coarse.classes = tile->classes;
  const double texel_m = coarse.texture_rgb.empty() ? 0.0 : side_m / coarse.texture_rgb.width;
  coarse.geometric_error_m = std::max({below_m + change_m, blocks.error_m, trees_m, texel_m});
  return coarse;
}

}  // namespace orthodrive::scene
