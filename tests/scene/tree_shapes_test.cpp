// The wood that trees are copies of.

#include "orthodrive/scene/tree_shapes.hpp"

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

TEST_P(EveryTreeShape, is_a_small_mesh_of_triangles_that_look_outwards) {
  EXPECT_EQ(mesh.kind, MeshKind::tree);
  EXPECT_GE(mesh.indices.size() / 3, 60U);
  EXPECT_LE(mesh.indices.size() / 3, 330U);
  double volume = 0.0;
  for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
    const auto at = [&](std::size_t k) {
      const auto& p = mesh.positions.at(mesh.indices[i + k]);
      return Vec3{p[0], p[1], p[2]};
    };
    const Vec3 a = at(0), u = at(1) - a, v = at(2) - a;
    const Vec3 n = {u.y * v.z - u.z * v.y, u.z * v.x - u.x * v.z, u.x * v.y - u.y * v.x};
    EXPECT_GT(std::hypot(n.x, n.y, n.z), 1e-5) << "a triangle without area";
    volume += (a.x * n.x + a.y * n.y + a.z * n.z) / 6.0;
  }
  EXPECT_GT(volume, 0.1);
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
