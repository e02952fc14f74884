// SPDX-License-Identifier: Apache-2.0
#pragma once
// Trees where the photo or the map has them, beside roads and buildings.

#include <span>
#include <vector>

#include "orthodrive/model/rasters/rasters.hpp"
#include "orthodrive/model/scene.hpp"
#include "orthodrive/scene/buildings/free_space.hpp"
#include "orthodrive/scene/ground/ground_surface.hpp"
#include "orthodrive/scene/plants/tree_crowns.hpp"
#include "orthodrive/scene/plants/tree_shapes.hpp"

namespace orthodrive::scene {

struct PlacedTree {
  Vec3 foot;  ///< site CRS
  double crown_radius_m = 0.0, height_m = 0.0, yaw_rad = 0.0;
  TreeShape shape = TreeShape::round;
  LinearColor color{};  ///< of the foliage
};

/// Outlines of roads must reach this far: the widest crown and its clearance.
constexpr double tree_reach_m = 5.5;

/// Plants the crowns, then the single trees of maps that stand in no crown (radius 2.4 m). Crowns shrink until they
/// keep 0.3 m from roads, decks of bridges and buildings; below 0.8 m, and outside the area, there is no tree. Crowns
/// below 1.7 m are shrubs. Shape, height (1.8 crown diameters, taller for conifers) and yaw are random, seeded by the
/// place; dark crowns are more often conifers. The colour is half the photo's, half that of leaves.
[[nodiscard]] std::vector<PlacedTree> plant_trees(std::span<const TreeCrown> crowns, std::span<const Vec2> singles,
                                                  const FreeSpace& space, const Ground& ground, const Photo& photo,
                                                  int threads);

/// Their copies by shape; positions relative to `origin`. Shapes without a tree are left out.
[[nodiscard]] std::vector<InstancedMesh> tree_instances(std::span<const PlacedTree* const> trees, Vec3 origin);

}  // namespace orthodrive::scene
