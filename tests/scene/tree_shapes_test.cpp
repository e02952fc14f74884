// SPDX-License-Identifier: Apache-2.0
// The wood that trees are copies of.

#include "orthodrive/scene/plants/tree_shapes.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace orthodrive::scene {
namespace {

class EveryTreeShape : public testing::TestWithParam<int> {
 protected:
  const TriMesh& mesh = tree_mesh(static_cast<TreeShape>(GetParam()));
};

TEST_P(EveryTreeShape, has_height_and_crown_radius_of_1) {
  float radius = 0.0F, low = 1.0F, top = 0.0F;
  for (const auto& p : mesh.positions)
    radius = std::max(radius, std::hypot(p[0], p[1])), low = std::min(low, p[2]), top = std::max(top, p[2]);
  EXPECT_FLOAT_EQ(radius, 1.0F);
  EXPECT_FLOAT_EQ(top, 1.0F);
  EXPECT_LE(low, 0.0F) << "it floats";
  EXPECT_GE(low, -0.1F);
}

TEST_P(EveryTreeShape, is_a_small_mesh_of_triangles_with_an_area) {
  EXPECT_EQ(mesh.kind, MeshKind::tree);
  EXPECT_GE(mesh.indices.size() / 3, 60U);
  EXPECT_LE(mesh.indices.size() / 3, 330U);
  for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
    const auto at = [&](std::size_t k) {
      const auto& p = mesh.positions.at(mesh.indices[i + k]);
      return Vec3{p[0], p[1], p[2]};
    };
    const Vec3 a = at(0), u = at(1) - a, v = at(2) - a;
    EXPECT_GT(std::hypot(u.y * v.z - u.z * v.y, u.z * v.x - u.x * v.z, u.x * v.y - u.y * v.x), 1e-5);
  }
}

/// Cards are lit as balls: normals look away from the trunk, whichever side of a card is seen.
TEST_P(EveryTreeShape, is_lit_as_a_round_crown) {
  int outwards = 0, far_from_trunk = 0;
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    const auto &p = mesh.positions[i], &n = mesh.normals[i];
    if (std::hypot(p[0], p[1]) < 0.75F) continue;
    ++far_from_trunk;
    if (p[0] * n[0] + p[1] * n[1] > 0.0F) ++outwards;
  }
  EXPECT_GT(far_from_trunk, 10);
  EXPECT_GT(outwards, 0.9 * far_from_trunk);
}

TEST_P(EveryTreeShape, shows_parts_of_the_picture_of_leaves) {
  ASSERT_EQ(mesh.parts.size(), 1U);
  EXPECT_EQ(mesh.parts[0].material, SurfaceMaterial::leaves);
  for (const auto& [u, v] : mesh.tile_uv) {
    EXPECT_TRUE(u >= 0.0F && u <= 1.0F && v >= 0.0F && v <= 1.0F);
  }
}

TEST_P(EveryTreeShape, has_all_that_a_vertex_needs) {
  const std::size_t count = mesh.positions.size();
  ASSERT_EQ(mesh.normals.size(), count);
  ASSERT_EQ(mesh.tile_uv.size(), count);
  ASSERT_EQ(mesh.colors.size(), count);
  for (const auto& n : mesh.normals) EXPECT_NEAR(std::hypot(n[0], n[1], n[2]), 1.0F, 1e-5F);
  ASSERT_EQ(mesh.parts.size(), 1U);
  EXPECT_EQ(mesh.parts[0].index_count, mesh.indices.size());
}

INSTANTIATE_TEST_SUITE_P(TreeShapes, EveryTreeShape, testing::Range(0, static_cast<int>(tree_shape_count)));

TEST(TreeShapes, differ_from_each_other) {
  for (std::size_t i = 0; i < tree_shape_count; ++i)
    for (std::size_t k = 0; k < i; ++k)
      EXPECT_NE(tree_mesh(static_cast<TreeShape>(i)).positions, tree_mesh(static_cast<TreeShape>(k)).positions);
}

}  // namespace
}  // namespace orthodrive::scene
