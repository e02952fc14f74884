// SPDX-License-Identifier: Apache-2.0
#pragma once
// A small wood made in code: the shapes that trees are copies of.

#include <span>

#include "orthodrive/model/scene.hpp"

namespace orthodrive::scene {

enum class TreeShape : std::uint8_t { round, oval, spreading, birch, spruce, pine, cypress, shrub };
constexpr std::size_t tree_shape_count = 8;

/// A tree of height 1 and crown radius 1, with its foot in (0, 0, 0): a trunk, and cards with leaves around dark lumps
/// of foliage, lit as balls are; 60 to 330 triangles. Colours are those of a mean green and of bark; instances tint
/// them.
[[nodiscard]] const TriMesh& tree_mesh(TreeShape shape);

/// Linear colour of the foliage in tree_mesh: what a tint of 1 shows.
constexpr std::array<float, 3> mean_foliage = {0.11F, 0.15F, 0.055F};

}  // namespace orthodrive::scene
