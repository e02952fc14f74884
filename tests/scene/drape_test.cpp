// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/scene/plan/drape.hpp"

#include <gtest/gtest.h>

#include "scene_site.hpp"

namespace orthodrive::scene {
namespace {

/// A roof over (-10, -10) to (10, 10): z = 2 - 0.1 |x|, its ridge along y.
TriMesh roof() {
  TriMesh mesh;
  for (const float x : {-10.0F, 0.0F, 10.0F}) {
    for (const float y : {-10.0F, 10.0F}) {
      mesh.positions.push_back({x, y, 2.0F - 0.1F * std::abs(x)});
      mesh.normals.push_back({0.0F, 0.0F, 1.0F});
    }
  }
  mesh.indices = {0, 2, 1, 1, 2, 3, 2, 4, 3, 3, 4, 5};
  return mesh;
}

std::array<Vec2, 4> rectangle(double west, double south, double east, double north) {
  return {Vec2{west, south}, Vec2{east, south}, Vec2{east, north}, Vec2{west, north}};
}

TEST(Drape, lies_on_the_mesh_on_both_sides_of_a_ridge) {
  TriMesh paint;
  const std::array<std::array<Vec2, 4>, 1> line = {rectangle(-3.0, -0.1, 5.0, 0.1)};
  drape(roof(), 0, line, 0.01, paint);
  EXPECT_NEAR(scene_test::plan_area_m2(&paint), 8.0 * 0.2, 1e-5);
  scene_test::expect_upwards(paint);
  for (std::size_t i = 0; i < paint.positions.size(); ++i) {
    const auto& p = paint.positions[i];
    EXPECT_NEAR(p[2], 2.01 - 0.1 * std::abs(p[0]), 1e-5);
  }
}

TEST(Drape, what_is_beside_the_mesh_is_cut_off) {
  TriMesh paint;
  const std::array<std::array<Vec2, 4>, 2> lines = {rectangle(8.0, 0.0, 12.0, 1.0), rectangle(20.0, 0.0, 21.0, 1.0)};
  drape(roof(), 0, lines, 0.0, paint);
  EXPECT_NEAR(scene_test::plan_area_m2(&paint), 2.0, 1e-5);
}

TEST(Drape, triangles_before_the_first_one_do_not_count) {
  TriMesh paint;
  const std::array<std::array<Vec2, 4>, 1> line = {rectangle(-3.0, -0.1, 5.0, 0.1)};
  drape(roof(), 6, line, 0.0, paint);
  EXPECT_NEAR(scene_test::plan_area_m2(&paint), 5.0 * 0.2, 1e-5);
}

}  // namespace
}  // namespace orthodrive::scene
