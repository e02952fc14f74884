#include "orthodrive/scene/tree_shapes.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "orthodrive/core/random.hpp"
#include "orthodrive/scene/tile_materials.hpp"

namespace orthodrive::scene {
namespace {

constexpr LinearColor bark = {0.06F, 0.045F, 0.03F}, birch_bark = {0.42F, 0.41F, 0.38F};
// What a tree is meant to be like, for the size of its textures: shapes are drawn stretched.
constexpr double meant_radius_m = 3.0, meant_height_m = 10.0, texture_m = 2.0;

/// One ring of a body of revolution.
struct Row {
  double radius = 0.0, z = 0.0;
  double shade = 1.0;  ///< of its colour: foliage is dark inside and below
};

/// Where a body stands and how uneven it is.
struct Body {
  Vec2 at;
  int columns = 8;
  double bumps = 0.0;  ///< of the radius
  LinearColor color = mean_foliage;
};

class TreeBuilder {
 public:
  explicit TreeBuilder(std::uint64_t seed) : random_(seed) { mesh_.kind = MeshKind::tree; }

  /// A body of revolution, from its lowest row upwards.
  void add_body(const std::vector<Row>& rows, const Body& body) {
    const auto first = static_cast<std::uint32_t>(mesh_.positions.size());
    const auto columns = static_cast<std::uint32_t>(body.columns);
    const std::vector<Vec3> points = points_of(rows, body);
    for (std::size_t r = 0; r < rows.size(); ++r) {
      for (std::uint32_t c = 0; c <= columns; ++c) {
        const Vec3 p = points[r * columns + c % columns];
        add_vertex(p, normal_at(points, r, c, rows.size(), columns), shaded(body.color, rows[r].shade));
        const double around = 2.0 * std::numbers::pi * c / columns * meant_radius_m * 0.6;
        mesh_.tile_uv.push_back({static_cast<float>(std::round(around / texture_m * 2.0) / 2.0),
                                 static_cast<float>(-p.z * meant_height_m / texture_m)});
      }
    }
    for (std::uint32_t r = 0; r + 1 < rows.size(); ++r) {
      for (std::uint32_t c = 0; c < columns; ++c) {
        const std::uint32_t a = first + r * (columns + 1) + c, b = a + 1, d = a + columns + 1, e = d + 1;
        if (rows[r].radius > 0.0) mesh_.indices.insert(mesh_.indices.end(), {a, b, rows[r + 1].radius > 0.0 ? e : d});
        if (rows[r + 1].radius > 0.0) mesh_.indices.insert(mesh_.indices.end(), {a, e, d});
      }
    }
  }
  void add_trunk(double top_z, double radius, const LinearColor& color = bark) {
    add_body({{1.3 * radius, -0.06}, {radius, 0.03}, {0.6 * radius, top_z}}, {.columns = 5, .color = color});
  }
  /// A lump of foliage, dark below.
  void add_lump(Vec3 middle, double radius, double half_height, double bumps = 0.22) {
    std::vector<Row> rows;
    constexpr int bands = 5;
    for (int i = 0; i <= bands; ++i) {
      const double angle = std::numbers::pi * (static_cast<double>(i) / bands - 0.5);
      rows.push_back({i == 0 || i == bands ? 0.0 : radius * std::cos(angle), middle.z + half_height * std::sin(angle),
                      0.62 + 0.42 * static_cast<double>(i) / bands});
    }
    add_body(rows, {.at = {middle.x, middle.y}, .columns = 8, .bumps = bumps});
  }
  /// A skirt of branches: a cone that is open inwards, as spruces have.
  void add_skirt(double low_z, double high_z, double radius) {
    add_body({{0.0, low_z + 0.25 * (high_z - low_z), 0.45}, {radius, low_z, 0.8}, {0.0, high_z, 1.1}},
             {.columns = 9, .bumps = 0.12});
  }
  /// Of height 1 and crown radius 1, whatever the bumps have done.
  TriMesh finish() {
    float radius = 0.0F, top = 0.0F;
    for (const auto& p : mesh_.positions) radius = std::max(radius, std::hypot(p[0], p[1])), top = std::max(top, p[2]);
    for (auto& p : mesh_.positions) p = {p[0] / radius, p[1] / radius, p[2] / top};
    mesh_.parts = {{SurfaceMaterial::foliage, 0, mesh_.indices.size()}};
    return std::move(mesh_);
  }

 private:
  static LinearColor shaded(LinearColor color, double shade) {
    for (float& v : color) v *= static_cast<float>(shade);
    return color;
  }
  /// `columns` points a row; rows of no radius have them all in one place.
  std::vector<Vec3> points_of(const std::vector<Row>& rows, const Body& body) {
    std::vector<Vec3> points;
    for (const Row& row : rows) {
      for (int c = 0; c < body.columns; ++c) {
        const double angle = 2.0 * std::numbers::pi * c / body.columns;
        const double r = row.radius * (1.0 + random_.uniform(-body.bumps, body.bumps));
        const double dz = row.radius > 0.0 ? 0.25 * body.bumps * random_.uniform(-row.radius, row.radius) : 0.0;
        points.push_back({body.at.x + r * std::cos(angle), body.at.y + r * std::sin(angle), row.z + dz});
      }
    }
    return points;
  }
  /// By differences to the neighbours, in the metres that are meant.
  static Vec3 normal_at(const std::vector<Vec3>& points, std::size_t row, std::uint32_t column, std::size_t rows,
                        std::uint32_t columns) {
    const auto at = [&](std::size_t r, std::uint32_t c) {
      const Vec3 p = points[r * columns + c % columns];
      return Vec3{p.x * meant_radius_m, p.y * meant_radius_m, p.z * meant_height_m};
    };
    const std::size_t low = row == 0 ? 0 : row - 1, high = std::min(rows - 1, row + 1);
    if (row == 0 || row + 1 == rows) {
      const Vec3 a = at(row, 0), b = at(row, columns / 2);
      if (std::hypot(a.x - b.x, a.y - b.y) < 1e-9) return {0.0, 0.0, row == 0 ? -1.0 : 1.0};
    }
    const Vec3 u = at(row, column + 1) - at(row, column + columns - 1), v = at(high, column) - at(low, column);
    const Vec3 n = {u.y * v.z - u.z * v.y, u.z * v.x - u.x * v.z, u.x * v.y - u.y * v.x};
    const double length = std::hypot(n.x, n.y, n.z);
    return length > 0.0 ? n * (1.0 / length) : Vec3{0.0, 0.0, 1.0};
  }
  void add_vertex(Vec3 p, Vec3 n, const LinearColor& color) {
    const auto f = [](double v) { return static_cast<float>(v); };
    mesh_.positions.push_back({f(p.x), f(p.y), f(p.z)});
    mesh_.normals.push_back({f(n.x), f(n.y), f(n.z)});
    mesh_.colors.push_back(mesh_color(color));
  }

  TriMesh mesh_;
  Random random_;
};

TriMesh make_tree(TreeShape shape) {
  TreeBuilder tree(derive_seed(17, static_cast<std::uint64_t>(shape)));
  switch (shape) {
    case TreeShape::round:
      tree.add_trunk(0.45, 0.07);
      tree.add_lump({0.1, -0.15, 0.7}, 0.75, 0.3);
      tree.add_lump({0.4, 0.25, 0.5}, 0.62, 0.25);
      tree.add_lump({-0.42, 0.12, 0.54}, 0.62, 0.26);
      tree.add_lump({0.0, -0.4, 0.46}, 0.6, 0.21);
      break;
    case TreeShape::oval:
      tree.add_trunk(0.3, 0.06);
      tree.add_lump({0.1, 0.05, 0.4}, 0.85, 0.22);
      tree.add_lump({-0.12, 0.1, 0.6}, 0.82, 0.24);
      tree.add_lump({0.05, -0.1, 0.8}, 0.6, 0.2);
      break;
    case TreeShape::spreading:
      tree.add_trunk(0.5, 0.09);
      tree.add_lump({0.42, 0.1, 0.58}, 0.58, 0.27);
      tree.add_lump({-0.38, 0.3, 0.63}, 0.58, 0.29);
      tree.add_lump({-0.1, -0.42, 0.55}, 0.57, 0.26);
      tree.add_lump({0.0, 0.0, 0.77}, 0.6, 0.23);
      break;
    case TreeShape::birch:
      tree.add_trunk(0.6, 0.045, birch_bark);
      tree.add_lump({0.12, -0.1, 0.42}, 0.82, 0.2);
      tree.add_lump({-0.15, 0.12, 0.6}, 0.78, 0.2);
      tree.add_lump({0.05, 0.0, 0.8}, 0.55, 0.2);
      break;
    case TreeShape::spruce:
      tree.add_trunk(0.3, 0.07);
      tree.add_skirt(0.07, 0.5, 0.97);
      tree.add_skirt(0.27, 0.68, 0.76);
      tree.add_skirt(0.46, 0.84, 0.55);
      tree.add_skirt(0.64, 1.0, 0.34);
      break;
    case TreeShape::pine:
      tree.add_trunk(0.75, 0.08);
      tree.add_lump({0.12, -0.1, 0.82}, 0.8, 0.18, 0.2);
      tree.add_lump({-0.22, 0.2, 0.68}, 0.72, 0.14, 0.2);
      tree.add_lump({0.35, 0.1, 0.56}, 0.5, 0.1, 0.2);
      break;
    case TreeShape::cypress:
      tree.add_trunk(0.15, 0.1);
      tree.add_body({{0.0, 0.05, 0.5},
                     {0.8, 0.12, 0.65},
                     {0.93, 0.3, 0.85},
                     {0.75, 0.6, 0.95},
                     {0.4, 0.85, 1.0},
                     {0.0, 1.0, 1.1}},
                    {.columns = 9, .bumps = 0.07});
      break;
    case TreeShape::shrub:
      tree.add_lump({0.0, 0.0, 0.5}, 0.85, 0.5);
      tree.add_lump({0.35, 0.3, 0.32}, 0.6, 0.36);
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
