// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/scene/ground/coarse_ground.hpp"

#include <meshoptimizer.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_map>

#include "orthodrive/geo/spatial_index.hpp"
#include "orthodrive/geo/vec.hpp"

namespace orthodrive::scene {
namespace {

constexpr std::uint32_t no_coarse_vertex = std::numeric_limits<std::uint32_t>::max();

/// All grounds in one list of vertices, each once; roads and terrain have vertices of their own where they meet, which
/// the simplification takes for the two sides of a seam and moves together.
struct JoinedGround {
  std::vector<std::array<float, 3>> positions, normals;
  std::vector<char> is_road;
  std::vector<std::uint32_t> indices;
};

struct VertexKey {
  std::array<float, 3> position;
  bool is_road = false;
  friend bool operator==(const VertexKey&, const VertexKey&) = default;
};
struct VertexHash {
  std::size_t operator()(const VertexKey& key) const {
    std::size_t hash = key.is_road ? 1 : 0;
    for (const float v : key.position) hash = hash * 1000003 + std::hash<float>()(v);
    return hash;
  }
};

JoinedGround join(std::span<const SceneTile* const> tiles, Vec3 origin) {
  JoinedGround ground;
  std::unordered_map<VertexKey, std::uint32_t, VertexHash> slots;
  for (const SceneTile* tile : tiles) {
    const Vec3 moved = tile->origin - origin;
    const auto f = [](double v) { return static_cast<float>(v); };
    for (const TriMesh& mesh : tile->meshes) {
      if (mesh.kind != MeshKind::terrain && mesh.kind != MeshKind::water && mesh.kind != MeshKind::road) continue;
      const bool is_road = mesh.kind == MeshKind::road;
      std::vector<std::uint32_t> slot_of;
      slot_of.reserve(mesh.positions.size());
      for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
        const auto& p = mesh.positions[i];  // sums are exact: both are on the plan grid, and heights have one origin
        const std::array<float, 3> at = {f(p[0] + moved.x), f(p[1] + moved.y), f(p[2] + moved.z)};
        const auto [found, is_new] =
            slots.try_emplace({at, is_road}, static_cast<std::uint32_t>(ground.positions.size()));
        if (is_new) {
          ground.positions.push_back(at);
          ground.normals.push_back(mesh.normals[i]);
          ground.is_road.push_back(is_road ? 1 : 0);
        }
        slot_of.push_back(found->second);
      }
      for (const std::uint32_t v : mesh.indices) ground.indices.push_back(slot_of[v]);
    }
  }
  return ground;
}

/// Triangles by cells in plan.
class PlanIndex {
 public:
  PlanIndex(const JoinedGround& ground, std::span<const std::uint32_t> indices, double side_m)
      : ground_(ground), indices_(indices), cell_m_(side_m / cells), half_m_(0.5 * side_m), in_cell_(cells * cells) {
    for (std::size_t i = 0; i < indices.size(); i += 3) {
      const auto [west, east] = std::minmax({at(i)[0], at(i + 1)[0], at(i + 2)[0]});
      const auto [south, north] = std::minmax({at(i)[1], at(i + 1)[1], at(i + 2)[1]});
      for (int c = cell(west); c <= cell(east); ++c)
        for (int r = cell(south); r <= cell(north); ++r)
          in_cell_[static_cast<std::size_t>(c * cells + r)].push_back(static_cast<std::uint32_t>(i));
    }
  }
  /// From the nearest of the surfaces above and below p (decks lie over terrain); 0 where there is none.
  [[nodiscard]] double distance_m(const std::array<float, 3>& p) const {
    constexpr double none = std::numeric_limits<double>::infinity();
    double nearest = none;
    for (const std::uint32_t i : in_cell_[static_cast<std::size_t>(cell(p[0]) * cells + cell(p[1]))]) {
      const auto &a = at(i), &b = at(i + 1), &c = at(i + 2);
      const auto d = [](float u, float v) { return static_cast<double>(u) - static_cast<double>(v); };
      const Vec2 ab{d(b[0], a[0]), d(b[1], a[1])}, ac{d(c[0], a[0]), d(c[1], a[1])}, ap{d(p[0], a[0]), d(p[1], a[1])};
      const double area = cross(ab, ac);
      if (!(area > 0.0)) continue;
      const double u = cross(ap, ac) / area, v = cross(ab, ap) / area;
      if (u < -1e-9 || v < -1e-9 || u + v > 1.0 + 1e-9) continue;
      nearest = std::min(nearest, std::abs(d(a[2], p[2]) + u * d(b[2], a[2]) + v * d(c[2], a[2])));
    }
    return nearest == none ? 0.0 : nearest;
  }

 private:
  static constexpr int cells = 64;
  [[nodiscard]] const std::array<float, 3>& at(std::size_t i) const { return ground_.positions[indices_[i]]; }
  [[nodiscard]] int cell(float v) const {
    return std::clamp(static_cast<int>((static_cast<double>(v) + half_m_) / cell_m_), 0, cells - 1);
  }
  const JoinedGround& ground_;
  std::span<const std::uint32_t> indices_;
  double cell_m_, half_m_;
  std::vector<std::vector<std::uint32_t>> in_cell_;
};

double twice_plan_area(const JoinedGround& ground, std::span<const std::uint32_t> corners) {
  const auto at = [&](std::size_t k) {
    const auto& p = ground.positions[corners[k]];
    return Vec2{static_cast<double>(p[0]), static_cast<double>(p[1])};
  };
  return cross(at(1) - at(0), at(2) - at(0));
}

Box2 plan_box(const JoinedGround& ground, std::span<const std::uint32_t> corners) {
  const auto at = [&](std::size_t k) { return ground.positions[corners[k]]; };
  const auto [west, east] = std::minmax({at(0)[0], at(1)[0], at(2)[0]});
  const auto [south, north] = std::minmax({at(0)[1], at(1)[1], at(2)[1]});
  return {west, south, east, north};
}

std::vector<std::uint32_t> simplify_ground(const JoinedGround& ground, std::span<const std::uint32_t> indices,
                                           double tolerance_m) {
  std::vector<std::uint32_t> kept(indices.size());
  if (indices.empty()) return kept;
  constexpr std::size_t stride = sizeof(ground.positions[0]);
  const float* first = ground.positions.front().data();
  const float scale_m = meshopt_simplifyScale(first, ground.positions.size(), stride);
  kept.resize(meshopt_simplify(kept.data(), indices.data(), indices.size(), first, ground.positions.size(), stride, 0,
                               static_cast<float>(tolerance_m) / scale_m, meshopt_SimplifyLockBorder, nullptr));
  return kept;
}

/// meshoptimizer asks whether a triangle turns over in space: steep ones can fold back in plan. Where one has, the
/// triangles around are left as they were, and the rest is done again beside them.
std::vector<std::uint32_t> simplified_ground(const JoinedGround& ground, const CoarseGroundOptions& options) {
  constexpr int most_rounds = 6;
  std::vector<std::uint32_t> free = ground.indices, fixed;
  for (int round = 0; round < most_rounds; ++round) {
    std::vector<std::uint32_t> kept = simplify_ground(ground, free, options.tolerance_m);
    std::vector<Box2> folds;
    for (std::size_t i = 0; i < kept.size(); i += 3) {
      const auto corners = std::span(kept).subspan(i, 3);
      if (!(twice_plan_area(ground, corners) > 0.0)) folds.push_back(plan_box(ground, corners).grown(1.0));
    }
    if (folds.empty()) {
      kept.insert(kept.end(), fixed.begin(), fixed.end());
      return kept;
    }
    const SpatialIndex index(folds);
    std::vector<std::uint32_t> still_free;
    for (std::size_t i = 0; i < free.size(); i += 3) {
      const auto corners = std::span(free).subspan(i, 3);
      auto& to = index.touching(plan_box(ground, corners)).empty() ? still_free : fixed;
      to.insert(to.end(), corners.begin(), corners.end());
    }
    free = std::move(still_free);
  }
  return ground.indices;
}

TriMesh part_of(const JoinedGround& ground, std::span<const std::uint32_t> indices, MeshKind kind, double side_m) {
  TriMesh mesh{.kind = kind};
  std::vector<std::uint32_t> slots(ground.positions.size(), no_coarse_vertex);
  for (std::size_t i = 0; i < indices.size(); i += 3) {
    if ((ground.is_road[indices[i]] != 0) != (kind == MeshKind::road)) continue;
    for (const std::uint32_t v : indices.subspan(i, 3)) {
      if (slots[v] == no_coarse_vertex) {
        slots[v] = static_cast<std::uint32_t>(mesh.positions.size());
        const auto& p = ground.positions[v];
        mesh.positions.push_back(p);
        mesh.normals.push_back(ground.normals[v]);
        const auto share = [&](double m) { return static_cast<float>(m / side_m + 0.5); };
        mesh.uv.push_back({share(static_cast<double>(p[0])), share(-static_cast<double>(p[1]))});
      }
      mesh.indices.push_back(slots[v]);
    }
  }
  return mesh;
}

}  // namespace

CoarseGround coarse_ground(std::span<const SceneTile* const> tiles, const CoarseGroundOptions& options) {
  const JoinedGround ground = join(tiles, options.origin);
  CoarseGround result;
  if (ground.indices.empty()) return result;
  const std::vector<std::uint32_t> kept = simplified_ground(ground, options);
  const PlanIndex index(ground, kept, options.side_m);
  for (const auto& p : ground.positions) result.error_m = std::max(result.error_m, index.distance_m(p));
  result.terrain = part_of(ground, kept, MeshKind::terrain, options.side_m);
  result.road = part_of(ground, kept, MeshKind::road, options.side_m);
  return result;
}

}  // namespace orthodrive::scene
