// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/scene/plants/trees.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "orthodrive/core/parallel.hpp"
#include "orthodrive/core/random.hpp"
#include "orthodrive/geo/spatial_index.hpp"
#include "orthodrive/scene/plan/plan_grid.hpp"

namespace orthodrive::scene {
namespace {

constexpr double tree_clearance_m = 0.3, min_radius_m = 0.8;
constexpr double shrub_radius_m = 1.7, single_radius_m = 2.4;
constexpr float dark_crown = 0.035F;  // linear green of crowns that are conifers more often than not
constexpr float photo_share = 0.5F;   // of a crown's colour: the rest is that of leaves, whatever light the photo had
constexpr float sunlit = 1.6F;        // a photo's crowns are half in the shadow

TreeShape shape_of(double radius_m, float green, Random& random) {
  if (radius_m < shrub_radius_m) return TreeShape::shrub;
  const double conifer = green < dark_crown ? 0.6 : 0.12;
  if (random.uniform() < conifer) return random.uniform() < 0.6 ? TreeShape::spruce : TreeShape::pine;
  if (radius_m < 2.6)
    return std::array{TreeShape::birch, TreeShape::oval, TreeShape::birch, TreeShape::cypress}[random.below(4)];
  return std::array{TreeShape::round, TreeShape::oval, TreeShape::spreading, TreeShape::birch}[random.below(4)];
}

double tree_height_m(TreeShape shape, double radius_m, Random& random) {
  constexpr std::array<double, tree_shape_count> over_diameter = {1.6, 1.9, 1.4, 2.4, 2.9, 2.5, 2.6, 0.85};
  const double share = over_diameter[static_cast<std::size_t>(shape)] * random.uniform(0.85, 1.15);
  return std::clamp(2.0 * radius_m * share, shape == TreeShape::shrub ? 0.8 : 3.0, 22.0);
}

LinearColor leaf_color(const LinearColor& in_photo) {
  LinearColor color{};
  for (std::size_t c = 0; c < 3; ++c)
    color[c] = photo_share * std::clamp(sunlit * in_photo[c], 0.4F * mean_foliage[c], 2.5F * mean_foliage[c]) +
               (1.0F - photo_share) * mean_foliage[c];
  return color;
}

/// Nothing where there is no room.
PlacedTree plant(const TreeCrown& crown, const FreeSpace& space, const Ground& ground, const Photo& photo) {
  const double radius_m =
      std::min(crown.radius_m, space.around(crown.at, crown.radius_m + tree_clearance_m) - tree_clearance_m);
  if (radius_m < min_radius_m) return {};
  const auto cell = [](double v) { return static_cast<std::uint64_t>(std::llround(v / plan_grid_m)); };
  Random random(derive_seed(cell(crown.at.x), cell(crown.at.y)));
  PlacedTree tree{.foot = {crown.at.x, crown.at.y, ground.height_m(crown.at)}};
  tree.crown_radius_m = radius_m * random.uniform(0.88, 1.0);
  tree.yaw_rad = random.uniform(0.0, 2.0 * std::numbers::pi);
  Polygon square;
  for (const Vec2 corner : {Vec2{-1, -1}, Vec2{1, -1}, Vec2{1, 1}, Vec2{-1, 1}})
    square.outer.push_back(crown.at + corner * (0.7 * crown.radius_m));
  tree.color = photo_median(photo, square);
  tree.shape = shape_of(radius_m, tree.color[1], random);
  tree.color = leaf_color(tree.color);
  tree.height_m = tree_height_m(tree.shape, tree.crown_radius_m, random);
  return tree;
}

std::vector<TreeCrown> with_singles(std::span<const TreeCrown> crowns, std::span<const Vec2> singles) {
  std::vector<TreeCrown> all(crowns.begin(), crowns.end());
  std::vector<Box2> boxes;
  boxes.reserve(crowns.size());
  for (const TreeCrown& crown : crowns)
    boxes.push_back(Box2{crown.at.x, crown.at.y, crown.at.x, crown.at.y}.grown(crown.radius_m));
  const SpatialIndex index(boxes);
  for (const Vec2 p : singles)
    if (std::ranges::none_of(index.near(p, 0.0),
                             [&](std::uint32_t i) { return distance(crowns[i].at, p) < crowns[i].radius_m; }))
      all.push_back({p, single_radius_m});
  return all;
}

}  // namespace

std::vector<PlacedTree> plant_trees(std::span<const TreeCrown> crowns, std::span<const Vec2> singles,
                                    const FreeSpace& space, const Ground& ground, const Photo& photo, int threads) {
  const std::vector<TreeCrown> all = with_singles(crowns, singles);
  std::vector<PlacedTree> trees(all.size());
  parallel_for(all.size(), threads, [&](std::size_t i) { trees[i] = plant(all[i], space, ground, photo); });
  std::erase_if(trees, [](const PlacedTree& tree) { return tree.crown_radius_m == 0.0; });
  return trees;
}

std::vector<InstancedMesh> tree_instances(std::span<const PlacedTree* const> trees, Vec3 origin) {
  std::array<InstancedMesh, tree_shape_count> by_shape;
  const auto f = [](double v) { return static_cast<float>(v); };
  for (const PlacedTree* tree : trees) {
    const Vec3 at = tree->foot - origin;
    MeshInstance instance{.position = {f(at.x), f(at.y), f(at.z)},
                          .yaw_rad = f(tree->yaw_rad),
                          .scale = {f(tree->crown_radius_m), f(tree->crown_radius_m), f(tree->height_m)}};
    for (std::size_t c = 0; c < 3; ++c) instance.tint[c] = tree->color[c] / mean_foliage[c];
    by_shape[static_cast<std::size_t>(tree->shape)].instances.push_back(instance);
  }
  std::vector<InstancedMesh> result;
  for (std::size_t i = 0; i < by_shape.size(); ++i) {
    if (by_shape[i].instances.empty()) continue;
    by_shape[i].mesh = tree_mesh(static_cast<TreeShape>(i));
    result.push_back(std::move(by_shape[i]));
  }
  return result;
}

}  // namespace orthodrive::scene
