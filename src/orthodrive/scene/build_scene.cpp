// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/scene/build_scene.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <unordered_map>

#include "orthodrive/core/random.hpp"
#include "orthodrive/geo/polygon.hpp"
#include "orthodrive/geo/spatial_index.hpp"
#include "orthodrive/scene/look/mesh_materials.hpp"
#include "orthodrive/scene/plan/drape.hpp"
#include "orthodrive/scene/plan/triangulate.hpp"
#include "orthodrive/scene/roads/kerbs.hpp"
#include "orthodrive/scene/tiles/scene_layout.hpp"
#include "orthodrive/scene/tiles/tile_features.hpp"
#include "orthodrive/scene/tiles/tile_materials.hpp"
#include "orthodrive/scene/tiles/tile_texture.hpp"

namespace orthodrive {
namespace {

using namespace scene;

constexpr double border_clearance_m = 1.0;  // of raster points from lines that have points of their own
constexpr double point_distance_m = 2.0;    // of terrain points from each other
constexpr double row_distance_m = 4.0;      // of those in a row beside roads
constexpr double marking_lift_m = 0.006;
constexpr double mesh_tolerance = 0.75;  // of triangles at the places where they are tested, of what is asked
constexpr LinearColor deck_concrete = {0.33F, 0.32F, 0.30F};
constexpr double jitter = 0.3;  // of raster points, in steps: a square raster has no unique triangulation
constexpr std::uint32_t no_vertex = std::numeric_limits<std::uint32_t>::max();

/// Points of a tile relative to its centre, each once.
class TilePoints {
 public:
  explicit TilePoints(Vec2 center) : center_(center) {}
  std::uint32_t add(Vec2 p) {
    const Vec2 local = p - center_;  // exact: both are on the plan grid
    const auto [at, is_new] = index_.try_emplace(key(local), static_cast<std::uint32_t>(points_.size()));
    if (is_new) points_.push_back(local);
    return at->second;
  }
  [[nodiscard]] const std::vector<Vec2>& points() const { return points_; }

 private:
  static std::int64_t key(Vec2 local) {
    return std::llround(local.x / plan_grid_m) * (std::int64_t{1} << 32) + std::llround(local.y / plan_grid_m);
  }
  Vec2 center_;
  std::vector<Vec2> points_;
  std::unordered_map<std::int64_t, std::uint32_t> index_;
};

/// The points without those nearer than the distance to one that is kept and comes before them.
std::vector<Vec2> thinned(const std::vector<Vec2>& points, double distance_m) {
  std::vector<Box2> boxes;
  boxes.reserve(points.size());
  for (const Vec2 p : points) boxes.push_back({p.x, p.y, p.x, p.y});
  const SpatialIndex index(boxes);
  std::vector<bool> kept(points.size(), false);
  std::vector<Vec2> result;
  for (std::size_t i = 0; i < points.size(); ++i) {
    kept[i] = std::ranges::none_of(index.near(points[i], distance_m), [&](std::uint32_t k) {
      return kept[k] && distance(points[i], points[k]) < distance_m;
    });
    if (kept[i]) result.push_back(points[i]);
  }
  return result;
}

/// Positions along a tile side: its ends, where lines meet it, and between them multiples of the step (0: none) that
/// are not too close. Depends on the side only, not on the tile to the left or right of it.
std::vector<double> side_positions(const std::map<int, std::vector<double>>& crossings, int line, double low,
                                   double step_m) {
  const double high = low + scene_tile_m;
  std::vector<double> fixed = {low, high};
  if (const auto found = crossings.find(line); found != crossings.end()) {
    const auto first = std::lower_bound(found->second.begin(), found->second.end(), low);
    fixed.insert(fixed.end(), first, std::upper_bound(first, found->second.end(), high));
  }
  std::sort(fixed.begin(), fixed.end());
  fixed.erase(std::unique(fixed.begin(), fixed.end()), fixed.end());
  std::vector<double> result = {low};
  for (std::size_t i = 1; i < fixed.size(); ++i) {
    if (step_m > 0.0) {
      for (double v = (std::floor(fixed[i - 1] / step_m) + 1.0) * step_m; v < fixed[i] - border_clearance_m;
           v += step_m) {
        const double on_grid = std::round(v / plan_grid_m) * plan_grid_m;
        if (on_grid > fixed[i - 1] + border_clearance_m) result.push_back(on_grid);
      }
    }
    result.push_back(fixed[i]);
  }
  return result;
}

using Constraints = std::vector<std::array<std::uint32_t, 2>>;

/// The lines of a level in a tile, and the tile's border, as constraints.
Constraints add_lines(const LevelLines& lines, TileAddress address, double border_step_m, TilePoints& points) {
  Constraints constraints;
  const Box2 box = tile_box(address);
  const auto add_side = [&](const std::vector<double>& positions, const auto& point_at) {
    for (std::size_t i = 1; i < positions.size(); ++i)
      constraints.push_back({points.add(point_at(positions[i - 1])), points.add(point_at(positions[i]))});
  };
  for (const int side : {0, 1}) {
    const double x = side == 0 ? box.min_x : box.max_x, y = side == 0 ? box.min_y : box.max_y;
    add_side(side_positions(lines.on_west, address.column + side, box.min_y, border_step_m), [&](double v) {
      return Vec2{x, v};
    });
    add_side(side_positions(lines.on_south, address.row + side, box.min_x, border_step_m), [&](double v) {
      return Vec2{v, y};
    });
  }
  if (const auto found = lines.inside.find(address); found != lines.inside.end())
    for (const LineSegment& segment : found->second)
      constraints.push_back({points.add(segment.a), points.add(segment.b)});
  return constraints;
}

void add_terrain_points(const SceneLayout& layout, TileAddress address, TilePoints& points) {
  const Box2 inner = tile_box(address).grown(-border_clearance_m);
  std::vector<Vec2> inside;
  const auto add = [&](Vec2 p, std::vector<Vec2>& inside) {
    if (inner.contains(p) && layout.area.contains(p) && layout.area.nearest(p).distance_m > border_clearance_m &&
        layout.roads.outline().nearest(p).distance_m > border_clearance_m && !layout.roads.outline().contains(p) &&
        layout.openings.nearest(p).distance_m > border_clearance_m &&
        layout.waters.shore_distance_m(p) > border_clearance_m)
      inside.push_back(p);
  };
  if (const auto found = layout.terrain_points.find(address); found != layout.terrain_points.end()) {
    for (const std::vector<Vec2>& points_of_row : found->second) {
      std::vector<Vec2> row;
      for (const Vec2 p : points_of_row) add(p, row);
      // By place: the borders' own order depends on where their rings begin.
      std::ranges::sort(row, {}, [](Vec2 p) { return std::pair(p.x, p.y); });
      std::ranges::copy(thinned(row, row_distance_m), std::back_inserter(inside));
    }
  }
  const double step_m = layout.options.terrain_step_m;
  for (auto r = static_cast<std::int64_t>(std::floor(inner.min_y / step_m)); r * step_m <= inner.max_y; ++r) {
    for (auto c = static_cast<std::int64_t>(std::floor(inner.min_x / step_m)); c * step_m <= inner.max_x; ++c) {
      Random random(derive_seed(static_cast<std::uint64_t>(c), static_cast<std::uint64_t>(r)));
      const double dx = random.uniform(-jitter, jitter), dy = random.uniform(-jitter, jitter);
      add(snap_to_grid({(static_cast<double>(c) + 0.5 + dx) * step_m, (static_cast<double>(r) + 0.5 + dy) * step_m}),
          inside);
    }
  }
  for (const Vec2 p : thinned(inside, point_distance_m)) points.add(p);
}

struct Vertex {
  double z_m = 0.0;
  Vec3 normal;
};

/// A mesh of a tile under construction; vertices are shared by a key of the caller's.
class MeshBuilder {
 public:
  MeshBuilder(MeshKind kind, Vec2 center, double origin_z_m) : center_(center), origin_z_m_(origin_z_m) {
    mesh.kind = kind;
  }
  std::uint32_t add(Vec2 local, const Vertex& vertex) {
    const auto f = [](double v) { return static_cast<float>(v); };
    mesh.positions.push_back({f(local.x), f(local.y), f(vertex.z_m - origin_z_m_)});
    mesh.normals.push_back({f(vertex.normal.x), f(vertex.normal.y), f(vertex.normal.z)});
    mesh.uv.push_back({f(local.x / scene_tile_m + 0.5), f(0.5 - local.y / scene_tile_m)});
    return static_cast<std::uint32_t>(mesh.positions.size() - 1);
  }
  void triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    mesh.indices.insert(mesh.indices.end(), {a, b, c});
  }
  [[nodiscard]] Vec2 world(Vec2 local) const { return center_ + local; }

  TriMesh mesh;

 private:
  Vec2 center_;
  double origin_z_m_;
};

/// Adds the triangles of the chosen regions; heights and normals come from vertex_at(world point).
template <typename VertexAt>
void add_regions(const Triangulation& t, const std::vector<bool>& chosen, const VertexAt& vertex_at,
                 MeshBuilder& builder) {
  std::vector<std::uint32_t> slots(t.points.size(), no_vertex);
  for (std::size_t i = 0; i < t.triangles.size(); ++i) {
    if (!chosen[t.regions[i]]) continue;
    std::array<std::uint32_t, 3> corners{};
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t p = t.triangles[i][k];
      if (slots[p] == no_vertex) slots[p] = builder.add(t.points[p], vertex_at(builder.world(t.points[p])));
      corners[k] = slots[p];
    }
    builder.triangle(corners[0], corners[1], corners[2]);
  }
}

Vertex ground_vertex(const SceneLayout& layout, Vec2 p) {
  return {layout.ground->height_m(p), layout.ground->normal(p)};
}

/// Where the road goes on as a deck, the ground below and the deck's end wall meet a little lower: at the height of the
/// road four surfaces would have one edge in common.
double below_joint_m(const SceneLayout& layout, Vec2 p) {
  constexpr double drop_m = 0.05;
  const auto levels = layout.joints.inside_at(p);
  return levels && levels->lowest == 0 && layout.is_deck(levels->highest) ? drop_m : 0.0;
}

Vertex terrain_vertex(const SceneLayout& layout, Vec2 p) {
  Vertex vertex = ground_vertex(layout, p);
  vertex.z_m -= below_joint_m(layout, p);
  return vertex;
}

/// On roads of the ground, on decks and in tunnels; where no road is near (corners that the plan grid moved) the ground
/// itself. Where levels join, that of the lower one: both have the same vertex.
Vertex road_vertex(const SceneLayout& layout, const RoadLevel& roads, Vec2 p) {
  const auto joint = layout.joints.level_at(p);
  const auto on = (joint ? layout.level(*joint) : roads).sample(p);
  return on ? Vertex{on->z_m, on->normal} : ground_vertex(layout, p);
}

/// The surface of a level's roads around the tile's centre. Borders of tiles have their points already.
SurfaceToKeep surface_of(const SceneLayout& layout, const RoadLevel& roads, Vec2 center) {
  return {.is_kept =
              [&, center](Vec2 local) {
                return roads.outline().contains(center + local) && layout.area.contains(center + local);
              },
          .height_m = [&, center](Vec2 local) -> std::optional<double> {
            const Vec2 p = center + local;
            const auto joint = layout.joints.level_at(p);
            const auto on = (joint ? layout.level(*joint) : roads).sample(p);
            return on ? std::optional(on->z_m) : std::nullopt;
          },
          .may_split =
              [](Vec2 a, Vec2 b) {
                constexpr double half = 0.5 * scene_tile_m;
                return !(a.x == b.x && std::abs(a.x) == half) && !(a.y == b.y && std::abs(a.y) == half);
              },
          .tolerance_m = mesh_tolerance* layout.options.road_tolerance_m};
}

/// The parts of a tile's ground.
struct GroundMeshes {
  MeshBuilder &terrain, &water, &road, &lids;
};

void add_ground(const SceneLayout& layout, TileAddress address, const GroundMeshes& meshes) {
  auto& [terrain, water, road, lids] = meshes;
  TilePoints points(terrain.world({}));
  const Constraints constraints = add_lines(layout.ground_lines, address, layout.options.terrain_step_m, points);
  add_terrain_points(layout, address, points);
  const Triangulation t =
      triangulate(points.points(), constraints, surface_of(layout, layout.roads, terrain.world({})));
  std::vector<bool> is_terrain, is_water, is_road, is_lid;
  for (const Vec2 local : t.region_points) {
    const Vec2 p = terrain.world(local);
    const bool inside = layout.area.contains(p), on_road = layout.roads.outline().contains(p);
    const bool opened = inside && !on_road && layout.openings.contains(p);
    const bool on_water = inside && !on_road && !opened && layout.waters.at(p) != nullptr;
    is_terrain.push_back(inside && !on_road && !on_water && !opened);
    is_lid.push_back(opened);
    is_water.push_back(on_water);
    is_road.push_back(inside && on_road);
  }
  add_regions(
      t, is_terrain, [&](Vec2 p) { return terrain_vertex(layout, p); }, terrain);
  add_regions(
      t, is_lid, [&](Vec2 p) { return ground_vertex(layout, p); }, lids);
  add_regions(
      t, is_water,
      [&](Vec2 p) {
        return Vertex{layout.ground->height_m(p) - below_joint_m(layout, p), {0.0, 0.0, 1.0}};
      },
      water);
  // On the road's border the ground has the same height.
  add_regions(
      t, is_road, [&](Vec2 p) { return road_vertex(layout, layout.roads, p); }, road);
}

/// Underside and sides of the deck triangles from `first_index` on of the road mesh. No sides where the deck goes on:
/// on the tile's border, and where a deck of another level begins.
void add_deck_body(const SceneLayout& layout, const TriMesh& deck, std::size_t first_index, MeshBuilder& body) {
  const double thickness_m = layout.options.deck_thickness_m;
  const auto local = [&](std::uint32_t v) { return Vec2{deck.positions[v][0], deck.positions[v][1]}; };
  const auto vertex = [&](std::uint32_t v, double drop_m, Vec3 normal) {
    return body.add(local(v), {static_cast<double>(deck.positions[v][2]) - drop_m, normal});
  };
  std::map<std::array<std::uint32_t, 2>, bool> edges;
  std::unordered_map<std::uint32_t, std::uint32_t> below;
  for (std::size_t i = first_index; i < deck.indices.size(); i += 3) {
    std::array<std::uint32_t, 3> bottom{};
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t v = deck.indices[i + k];
      edges[{v, deck.indices[i + (k + 1) % 3]}] = true;
      const auto [at, is_new] = below.try_emplace(v, 0);
      if (is_new) at->second = vertex(v, thickness_m, {0.0, 0.0, -1.0});
      bottom[k] = at->second;
    }
    body.triangle(bottom[0], bottom[2], bottom[1]);
  }
  constexpr double half = 0.5 * scene_tile_m;
  for (const auto& [edge, unused] : edges) {
    const auto [a, b] = edge;
    if (edges.contains({b, a})) continue;
    const Vec2 pa = local(a), pb = local(b);
    if ((pa.x == pb.x && std::abs(pa.x) == half) || (pa.y == pb.y && std::abs(pa.y) == half)) continue;
    const auto joint = layout.joints.inside_at(body.world((pa + pb) * 0.5));
    if (joint && layout.is_deck(joint->lowest) && layout.is_deck(joint->highest)) continue;
    const Vec2 outwards = left_normal(normalized(pb - pa)) * -1.0;
    const Vec3 normal{outwards.x, outwards.y, 0.0};
    const std::uint32_t a0 = vertex(a, below_joint_m(layout, body.world(pa)), normal);
    const std::uint32_t b0 = vertex(b, below_joint_m(layout, body.world(pb)), normal);
    const std::uint32_t a1 = vertex(a, thickness_m, normal), b1 = vertex(b, thickness_m, normal);
    body.triangle(a0, a1, b1);
    body.triangle(a0, b1, b0);
  }
}

/// Triangulated alone.
void add_level(const SceneLayout& layout, const RoadLevel& level, const LevelLines& lines, TileAddress address,
               MeshBuilder& road) {
  TilePoints points(road.world({}));
  const Constraints constraints = add_lines(lines, address, 0.0, points);
  const Triangulation t = triangulate(points.points(), constraints, surface_of(layout, level, road.world({})));
  std::vector<bool> is_road;
  is_road.reserve(t.region_points.size());
  for (const Vec2 local : t.region_points) is_road.push_back(level.outline().contains(road.world(local)));
  add_regions(
      t, is_road, [&](Vec2 p) { return road_vertex(layout, level, p); }, road);
}

std::vector<MarkingPiece> markings_of(const LevelLines& lines, TileAddress address, Vec2 center) {
  const auto found = lines.markings.find(address);
  if (found == lines.markings.end()) return {};
  std::vector<MarkingPiece> local = found->second;
  for (MarkingPiece& piece : local)
    for (Vec2& p : piece.corners) p = p - center;
  return local;
}

/// With the colour of each.
void drape_markings(const TriMesh& road, std::size_t first_index, const std::vector<MarkingPiece>& pieces,
                    TriMesh& marking) {
  std::map<LinearColor, std::vector<std::array<Vec2, 4>>> by_color;
  for (const MarkingPiece& piece : pieces) by_color[piece.color].push_back(piece.corners);
  for (const auto& [color, polygons] : by_color) {
    drape(road, first_index, polygons, marking_lift_m, marking);
    marking.colors.resize(marking.positions.size(), mesh_color(color));
  }
}

std::vector<KerbPiece> kerbs_of(const LevelLines& lines, TileAddress address, Vec2 center) {
  const auto found = lines.kerbs.find(address);
  if (found == lines.kerbs.end()) return {};
  std::vector<KerbPiece> local = found->second;
  for (KerbPiece& piece : local)
    for (Vec2& p : piece.corners) p = p - center;
  return local;
}

}  // namespace

SceneSource source_of(const SceneInput& input) {
  SceneSource source{.roads = input.roads,
                     .terrain = source_of(input.terrain),
                     .photo = source_of(input.photo),
                     .area = input.area,
                     .buildings = input.buildings,
                     .trees = input.trees,
                     .surroundings = input.surroundings};
  if (input.labels) source.labels = source_of(*input.labels);
  return source;
}

std::shared_ptr<const SceneLayout> lay_out_scene(const SceneInput& input, const SceneOptions& options) {
  const SceneSource source = source_of(input);
  const auto frame = std::make_shared<const SceneFrame>(source, options);
  return lay_out_block(frame, SceneWindows(source, *frame), block_around(frame->tiles));
}

Polygon photo_outline(const PhotoSource& photo) {
  constexpr int rows_at_a_time = 256;
  std::vector<Vec2> corners;
  for (int top = 0; top < photo.frame.height; top += rows_at_a_time) {
    const PhotoWindow strip =
        photo.read({0, top, photo.frame.width, std::min(rows_at_a_time, photo.frame.height - top)});
    for (int row = 0; row < strip.valid.height; ++row) {
      int first = 0, end = photo.frame.width;
      while (first < end && !strip.valid.at(first, row)) ++first;
      while (end > first && !strip.valid.at(end - 1, row)) --end;
      if (first == end) continue;
      for (const int r : {top + row, top + row + 1})
        for (const int c : {first, end}) corners.push_back(photo.frame.world_from_pixel(c, r));
    }
  }
  return {convex_hull(std::move(corners)), {}};
}

const std::vector<TileAddress>& scene_tiles(const SceneLayout& layout) { return layout.tiles; }
Findings scene_findings(const SceneLayout& layout) {
  Findings all = layout.frame->findings;
  all.insert(all.end(), layout.findings.begin(), layout.findings.end());
  return all;
}

namespace {

/// The meshes of a tile while they grow.
struct TileMeshes {
  TileMeshes(Vec2 center, double origin_z)
      : terrain(MeshKind::terrain, center, origin_z),
        road(MeshKind::road, center, origin_z),
        water(MeshKind::water, center, origin_z),
        lids(MeshKind::terrain, center, origin_z),
        tunnel_road(MeshKind::tunnel_road, center, origin_z),
        body(MeshKind::road_body, center, 0.0) {}
  MeshBuilder terrain, road, water, lids, tunnel_road;
  MeshBuilder body;  // takes heights that are relative already
  TriMesh verge{.kind = MeshKind::verge}, marking{.kind = MeshKind::marking}, kerb{.kind = MeshKind::kerb};
  std::vector<TriMesh> covers;
};

/// Ground, roads on it, decks and tunnels, with their markings and kerbs.
void add_surfaces(const SceneLayout& layout, TileAddress address, Vec2 center, TileMeshes& m) {
  add_ground(layout, address, {m.terrain, m.water, m.road, m.lids});
  add_water_material(layout, center, m.water.mesh);
  add_verge(layout, m.terrain.mesh, center, m.verge);
  const auto add_level_lines = [&](TriMesh& road, std::size_t first_index, const LevelLines& lines) {
    drape_markings(road, first_index, markings_of(lines, address, center), m.marking);
    add_kerbs(road, first_index, kerbs_of(lines, address, center), m.kerb);
  };
  add_level_lines(m.road.mesh, 0, layout.ground_lines);
  for (std::size_t deck = 0; deck < layout.decks.size(); ++deck) {
    const std::size_t first_index = m.road.mesh.indices.size();
    add_level(layout, layout.decks[deck], layout.deck_lines[deck], address, m.road);
    add_deck_body(layout, m.road.mesh, first_index, m.body);
    add_level_lines(m.road.mesh, first_index, layout.deck_lines[deck]);
  }
  for (std::size_t i = 0; i < layout.tunnels.size(); ++i) {
    const std::size_t first_index = m.tunnel_road.mesh.indices.size();
    add_level(layout, layout.tunnels[i], layout.tunnel_lines[i], address, m.tunnel_road);
    add_level_lines(m.tunnel_road.mesh, first_index, layout.tunnel_lines[i]);
  }
  if (const auto found = layout.covers_in.find(address); found != layout.covers_in.end())
    m.covers = cover_meshes(m.terrain.mesh, found->second, center, m.marking);
}

/// What the roads, their paint and kerbs are made of.
void add_materials(const SceneLayout& layout, Vec2 center, SceneTile& tile, TileMeshes& m) {
  add_road_materials(layout, center, name_lanes(*layout.query, tile, m.road.mesh), m.road.mesh);
  add_road_materials(layout, center, name_lanes(*layout.query, tile, m.tunnel_road.mesh), m.tunnel_road.mesh);
  add_plain_material(SurfaceMaterial::concrete, deck_concrete, m.body.mesh);
  m.marking.colors.resize(m.marking.positions.size(), mesh_color(white_paint));  // those of parking lots
  add_material(SurfaceMaterial::paint, m.marking);
  add_material(SurfaceMaterial::concrete, m.kerb);
}

void move_into(SceneTile& tile, TileMeshes& m) {
  std::vector<TriMesh*> all = {&m.terrain.mesh, &m.water.mesh, &m.road.mesh, &m.body.mesh,
                               &m.verge,        &m.marking,    &m.kerb,      &m.tunnel_road.mesh};
  for (TriMesh& mesh : m.covers) all.push_back(&mesh);
  for (TriMesh* mesh : all)
    if (!mesh->indices.empty()) tile.meshes.push_back(std::move(*mesh));
}

/// Least and greatest height of all that is in the tile.
void measure_heights(SceneTile& tile) {
  float low = std::numeric_limits<float>::infinity(), high = -low;
  for (const TriMesh& mesh : tile.meshes)
    for (const auto& p : mesh.positions) low = std::min(low, p[2]), high = std::max(high, p[2]);
  for (const InstancedMesh& copied : tile.instanced) {
    float top = 0.0F;
    for (const auto& p : copied.mesh.positions) top = std::max(top, p[2]);
    for (const MeshInstance& copy : copied.instances) high = std::max(high, copy.position[2] + top * copy.scale[2]);
  }
  tile.min_z_m = tile.origin.z + static_cast<double>(low);
  tile.max_z_m = tile.origin.z + static_cast<double>(high);
}

}  // namespace

SceneTile build_scene_tile(const SceneLayout& layout, TileAddress address) {
  const Box2 box = tile_box(address);
  const Vec2 center{0.5 * (box.min_x + box.max_x), 0.5 * (box.min_y + box.max_y)};
  SceneTile tile{.column = address.column, .row = address.row, .origin = {center.x, center.y, layout.origin.z}};
  TileMeshes meshes(center, layout.origin.z);
  add_surfaces(layout, address, center, meshes);
  tile.lids = std::move(meshes.lids.mesh);
  add_materials(layout, center, tile, meshes);
  move_into(tile, meshes);
  for (const auto& family : layout.families) family->add_to(tile);
  if (tile.meshes.empty()) return tile;
  measure_heights(tile);
  tile.texture_rgb = tile_texture(*layout.photo, box, layout.options.max_texture_px);
  if (layout.labels != nullptr) {
    tile.labels = tile_labels(*layout.labels, box, layout.options.max_texture_px);
    tile.classes = layout.labels->classes;
  }
  return tile;
}

}  // namespace orthodrive
