// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/scene/plants/tree_shapes.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "orthodrive/core/random.hpp"
#include "orthodrive/scene/look/leaf_picture.hpp"
#include "orthodrive/scene/look/mesh_materials.hpp"

namespace orthodrive::scene {
namespace {

constexpr LinearColor bark = {0.06F, 0.045F, 0.03F}, birch_bark = {0.42F, 0.41F, 0.38F};
// What a tree is meant to be like, in whose metres cards have their shape: instances are stretched otherwise.
constexpr double meant_radius_m = 3.0, meant_height_m = 10.0;

Vec3 in_metres(Vec3 p) { return {p.x * meant_radius_m, p.y * meant_radius_m, p.z * meant_height_m}; }
Vec3 in_units(Vec3 p) { return {p.x / meant_radius_m, p.y / meant_radius_m, p.z / meant_height_m}; }
Vec3 unit(Vec3 v) {
  const double length = std::hypot(v.x, v.y, v.z);
  return length > 0.0 ? v * (1.0 / length) : Vec3{0.0, 0.0, 1.0};
}

/// One ring of a body of revolution.
struct Row {
  double radius = 0.0, z = 0.0;
  double shade = 1.0;  ///< of its colour: foliage is dark inside and below
};

/// Where a body stands, how uneven it is and what it shows.
struct Body {
  Vec2 at;
  int columns = 5;
  double bumps = 0.0;  ///< of the radius
  LinearColor color = mean_foliage;
  PictureBox picture = dense_leaves_box;
};

/// A crown or a part of one.
struct Lump {
  Vec3 middle;
  double radius = 1.0, half_height = 0.5;
  int cards = 10;
  PictureBox picture = broad_leaves_box;
};

/// Trees are cards with clusters of leaves around closed, darker lumps; conifers have rings of twigs.
class TreeBuilder {
 public:
  explicit TreeBuilder(std::uint64_t seed) : random_(seed) { mesh_.kind = MeshKind::tree; }

  void add_trunk(double top_z, double radius, const LinearColor& color = bark) {
    add_body({{1.3 * radius, -0.06}, {radius, 0.03}, {0.6 * radius, top_z}},
             {.columns = 5, .color = color, .picture = bark_box});
  }

  void add_lump(const Lump& lump) {
    constexpr double core = 0.68, core_shade = 0.62;
    constexpr int bands = 3;
    std::vector<Row> rows;
    for (int i = 0; i <= bands; ++i) {
      const double angle = std::numbers::pi * (static_cast<double>(i) / bands - 0.5);
      rows.push_back({i == 0 || i == bands ? 0.0 : core * lump.radius * std::cos(angle),
                      lump.middle.z + core * lump.half_height * std::sin(angle),
                      core_shade * (0.85 + 0.3 * static_cast<double>(i) / bands)});
    }
    add_body(rows, {.at = {lump.middle.x, lump.middle.y}, .bumps = 0.12});
    // Evenly around (golden angle), but for what is straight below.
    constexpr double lowest = -0.8, golden_rad = 2.399963;
    const Vec3 size = in_metres({lump.radius, lump.radius, lump.half_height});
    const double first_rad = random_.uniform(0.0, 2.0 * std::numbers::pi);
    for (int i = 0; i < lump.cards; ++i) {
      const double up = lowest + (1.0 - lowest) * (i + 0.5) / lump.cards, out = std::sqrt(1.0 - up * up);
      const double turn = first_rad + golden_rad * i;
      const Vec3 way{out * std::cos(turn), out * std::sin(turn), up};
      const Vec3 outwards = unit({way.x / size.x, way.y / size.y, way.z / size.z});
      const auto askew = [&] { return random_.uniform(-0.45, 0.45); };
      const Vec3 normal = unit(outwards + Vec3{askew(), askew(), askew()});
      const Vec3 u = unit(cross(normal, unit({askew(), askew(), 1.0}))), v = cross(normal, u);
      const double half_m = random_.uniform(0.72, 0.86) * std::min(size.x, 1.25 * size.z);
      const double inside = random_.uniform(0.66, 0.82);
      const Vec3 middle = in_metres(lump.middle) + Vec3{way.x * size.x, way.y * size.y, way.z * size.z} * inside;
      const double shade = 0.98 + 0.26 * up + random_.uniform(-0.08, 0.08);
      add_card({middle - u * half_m - v * half_m, middle + u * half_m - v * half_m, middle + u * half_m + v * half_m,
                middle - u * half_m + v * half_m},
               in_metres(lump.middle), shade, lump.picture);
    }
  }

  /// A ring of drooping twigs around the trunk.
  void add_twigs(double z, double radius, double droop, int count) {
    const double first_rad = random_.uniform(0.0, 2.0 * std::numbers::pi);
    for (int i = 0; i < count; ++i) {
      const double turn = first_rad + 2.0 * std::numbers::pi * (i + random_.uniform(-0.15, 0.15)) / count;
      const double reach = radius * random_.uniform(0.88, 1.0), lift = random_.uniform(-0.015, 0.015);
      const Vec3 out{std::cos(turn), std::sin(turn), 0.0}, across{-out.y, out.x, 0.0};
      const Vec3 root = in_metres({0.0, 0.0, z + lift}),
                 tip = in_metres(out * reach + Vec3{0.0, 0.0, z + lift - droop});
      const Vec3 half = across * (0.56 * meant_radius_m * reach);
      add_card({root - half, tip - half, tip + half, root + half}, in_metres({0.0, 0.0, z - 0.25}),
               0.95 + 0.25 * z + random_.uniform(-0.08, 0.08), needles_box);
    }
  }

  /// Of height 1 and crown radius 1.
  TriMesh finish() {
    float radius = 0.0F, top = 0.0F;
    for (const auto& p : mesh_.positions) radius = std::max(radius, std::hypot(p[0], p[1])), top = std::max(top, p[2]);
    for (auto& p : mesh_.positions) p = {p[0] / radius, p[1] / radius, p[2] / top};
    mesh_.parts = {{SurfaceMaterial::leaves, 0, mesh_.indices.size()}};
    return std::move(mesh_);
  }

  /// A body of revolution, from its lowest row upwards.
  void add_body(const std::vector<Row>& rows, const Body& body) {
    const auto first = static_cast<std::uint32_t>(mesh_.positions.size());
    const auto columns = static_cast<std::uint32_t>(body.columns);
    const std::vector<Vec3> points = points_of(rows, body);
    const PictureBox& box = body.picture;
    for (std::size_t r = 0; r < rows.size(); ++r) {
      const double v = box.v1 + (box.v0 - box.v1) * static_cast<double>(r) / static_cast<double>(rows.size() - 1);
      for (std::uint32_t c = 0; c <= columns; ++c)
        add_vertex(points[r * columns + c % columns], normal_at(points, r, c, rows.size(), columns),
                   shaded(body.color, rows[r].shade), {box.u0 + (box.u1 - box.u0) * c / columns, v});
    }
    for (std::uint32_t r = 0; r + 1 < rows.size(); ++r) {
      for (std::uint32_t c = 0; c < columns; ++c) {
        const std::uint32_t a = first + r * (columns + 1) + c, b = a + 1, d = a + columns + 1, e = d + 1;
        if (rows[r].radius > 0.0) mesh_.indices.insert(mesh_.indices.end(), {a, b, rows[r + 1].radius > 0.0 ? e : d});
        if (rows[r + 1].radius > 0.0) mesh_.indices.insert(mesh_.indices.end(), {a, e, d});
      }
    }
  }

 private:
  static LinearColor shaded(LinearColor color, double shade) {
    for (float& v : color) v *= static_cast<float>(shade);
    return color;
  }

  /// Four corners, m, seen counter-clockwise from outside. They are lit as a ball around `middle_m` would be.
  void add_card(const std::array<Vec3, 4>& corners_m, Vec3 middle_m, double shade, const PictureBox& box) {
    const auto first = static_cast<std::uint32_t>(mesh_.positions.size());
    const std::array<Vec2, 4> places = {{{box.u0, box.v1}, {box.u1, box.v1}, {box.u1, box.v0}, {box.u0, box.v0}}};
    for (std::size_t i = 0; i < 4; ++i)
      add_vertex(in_units(corners_m[i]), unit(corners_m[i] - middle_m), shaded(mean_foliage, shade), places[i]);
    mesh_.indices.insert(mesh_.indices.end(), {first, first + 1, first + 2, first, first + 2, first + 3});
  }

  /// `columns` points a row; rows of no radius have them all in one place.
  std::vector<Vec3> points_of(const std::vector<Row>& rows, const Body& body) {
    std::vector<Vec3> points;
    for (const Row& row : rows) {
      for (int c = 0; c < body.columns; ++c) {
        const double angle = 2.0 * std::numbers::pi * c / body.columns;
        const double r = row.radius * (1.0 + random_.uniform(-body.bumps, body.bumps));
        points.push_back({body.at.x + r * std::cos(angle), body.at.y + r * std::sin(angle), row.z});
      }
    }
    return points;
  }
  /// By differences to the neighbours, in the metres that are meant.
  static Vec3 normal_at(const std::vector<Vec3>& points, std::size_t row, std::uint32_t column, std::size_t rows,
                        std::uint32_t columns) {
    const auto at = [&](std::size_t r, std::uint32_t c) { return in_metres(points[r * columns + c % columns]); };
    const std::size_t low = row == 0 ? 0 : row - 1, high = std::min(rows - 1, row + 1);
    if (row == 0 || row + 1 == rows) {
      const Vec3 a = at(row, 0), b = at(row, columns / 2);
      if (std::hypot(a.x - b.x, a.y - b.y) < 1e-9) return {0.0, 0.0, row == 0 ? -1.0 : 1.0};
    }
    return unit(cross(at(row, column + 1) - at(row, column + columns - 1), at(high, column) - at(low, column)));
  }
  void add_vertex(Vec3 p, Vec3 n, const LinearColor& color, Vec2 place) {
    const auto f = [](double v) { return static_cast<float>(v); };
    mesh_.positions.push_back({f(p.x), f(p.y), f(p.z)});
    mesh_.normals.push_back({f(n.x), f(n.y), f(n.z)});
    mesh_.colors.push_back(mesh_color(color));
    mesh_.tile_uv.push_back({f(place.x), f(place.y)});
  }

  TriMesh mesh_;
  Random random_;
};

TriMesh make_tree(TreeShape shape) {
  TreeBuilder tree(derive_seed(17, static_cast<std::uint64_t>(shape)));
  switch (shape) {
    case TreeShape::round:
      tree.add_trunk(0.5, 0.07);
      tree.add_lump({{0.1, -0.15, 0.7}, 0.75, 0.28, 11});
      tree.add_lump({{0.4, 0.25, 0.52}, 0.6, 0.22});
      tree.add_lump({{-0.42, 0.12, 0.54}, 0.6, 0.23});
      tree.add_lump({{0.0, -0.4, 0.48}, 0.58, 0.2});
      break;
    case TreeShape::oval:
      tree.add_trunk(0.4, 0.06);
      tree.add_lump({{0.1, 0.05, 0.4}, 0.82, 0.2, 13});
      tree.add_lump({{-0.12, 0.1, 0.6}, 0.8, 0.22, 13});
      tree.add_lump({{0.05, -0.1, 0.8}, 0.58, 0.18, 11});
      break;
    case TreeShape::spreading:
      tree.add_trunk(0.55, 0.09);
      tree.add_lump({{0.42, 0.1, 0.58}, 0.58, 0.24});
      tree.add_lump({{-0.38, 0.3, 0.63}, 0.58, 0.26});
      tree.add_lump({{-0.1, -0.42, 0.56}, 0.57, 0.24});
      tree.add_lump({{0.0, 0.0, 0.77}, 0.6, 0.21, 11});
      break;
    case TreeShape::birch:
      tree.add_trunk(0.7, 0.045, birch_bark);
      tree.add_lump({{0.12, -0.1, 0.42}, 0.78, 0.18, 11, small_leaves_box});
      tree.add_lump({{-0.15, 0.12, 0.6}, 0.75, 0.19, 11, small_leaves_box});
      tree.add_lump({{0.05, 0.0, 0.8}, 0.52, 0.18, 10, small_leaves_box});
      break;
    case TreeShape::spruce: {
      tree.add_trunk(0.9, 0.07);
      tree.add_body({{0.0, 0.05, 0.35}, {0.4, 0.14, 0.5}, {0.0, 0.97, 0.75}}, {.columns = 6});
      constexpr int rings = 9;
      for (int i = 0; i < rings; ++i) {
        const double share = static_cast<double>(i) / rings;
        tree.add_twigs(0.16 + 0.8 * share, 1.0 - 0.9 * share, 0.11 * (1.0 - 0.5 * share), 6);
      }
      break;
    }
    case TreeShape::pine:
      tree.add_trunk(0.8, 0.08);
      tree.add_lump({{0.12, -0.1, 0.82}, 0.78, 0.16, 13, small_leaves_box});
      tree.add_lump({{-0.22, 0.2, 0.68}, 0.7, 0.12, 11, small_leaves_box});
      tree.add_lump({{0.35, 0.1, 0.56}, 0.5, 0.09, 9, small_leaves_box});
      break;
    case TreeShape::cypress:
      tree.add_trunk(0.15, 0.1);
      tree.add_lump({{0.0, 0.0, 0.26}, 0.9, 0.22, 11, small_leaves_box});
      tree.add_lump({{0.05, 0.03, 0.48}, 0.82, 0.22, 11, small_leaves_box});
      tree.add_lump({{-0.03, 0.0, 0.68}, 0.6, 0.2, 10, small_leaves_box});
      tree.add_lump({{0.0, 0.0, 0.86}, 0.35, 0.14, 8, small_leaves_box});
      break;
    case TreeShape::shrub:
      tree.add_trunk(0.2, 0.06);
      tree.add_lump({{0.0, 0.0, 0.45}, 0.8, 0.45, 13, small_leaves_box});
      tree.add_lump({{0.35, 0.3, 0.32}, 0.55, 0.34, 9, small_leaves_box});
      tree.add_lump({{-0.35, -0.2, 0.3}, 0.5, 0.32, 9, small_leaves_box});
      break;
  }
  return tree.finish();
}

}  // namespace

const TriMesh& tree_mesh(TreeShape shape) {
  static const std::array<TriMesh, tree_shape_count> meshes = [] {
    std::array<TriMesh, tree_shape_count> made;
    for (std::size_t i = 0; i < made.size(); ++i) made[i] = make_tree(static_cast<TreeShape>(i));
    return made;
  }();
  return meshes[static_cast<std::size_t>(shape)];
}

}  // namespace orthodrive::scene
