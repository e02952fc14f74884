#include "orthodrive/scene/ground_cover.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <map>
#include <optional>

#include "orthodrive/core/parallel.hpp"
#include "orthodrive/geo/narrowest_rectangle.hpp"
#include "orthodrive/geo/overlay.hpp"
#include "orthodrive/geo/spatial_index.hpp"
#include "orthodrive/scene/drape.hpp"
#include "orthodrive/scene/plan_grid.hpp"
#include "orthodrive/scene/simplify_mesh.hpp"
#include "orthodrive/scene/tile_materials.hpp"
#include "orthodrive/scene/triangulate.hpp"

namespace orthodrive::scene {
namespace {

constexpr double cell_m = 96.0;  // a tile has whole ones: parts of large areas depend on what is near alone
constexpr double clearance_m = 0.05;
constexpr double bay_width_m = 2.5, bay_depth_m = 5.0, aisle_m = 6.0, line_m = 0.1, line_gap_m = 0.15;
constexpr double flat_m = 0.008;       // a cover may leave the terrain's triangles by that: less than it lies over them
constexpr double line_over_m = 0.006;  // of what it is painted on

/// Where rows of bays begin across an area of that width.
std::vector<double> rows_across(double width_m) {
  std::vector<double> rows;
  if (width_m < bay_depth_m - 0.5) return rows;
  for (double at_m = 0.0; at_m + bay_depth_m <= width_m + 0.5; at_m += 2.0 * bay_depth_m + aisle_m) {
    rows.push_back(at_m);
    if (at_m + 2.0 * bay_depth_m + aisle_m <= width_m + 0.5) rows.push_back(at_m + bay_depth_m + aisle_m);
  }
  return rows;
}

/// Lines between the bays of the whole area that lie on the ground.
std::vector<std::array<Vec2, 4>> lines_of(const Polygon& area, const Polygon& ground) {
  std::vector<std::array<Vec2, 4>> lines;
  Ring frame = narrowest_rectangle(area.outer);
  if (frame.size() != 4) return lines;
  if (distance(frame[0], frame[1]) < distance(frame[1], frame[2])) std::ranges::rotate(frame, frame.begin() + 1);
  const Vec2 along = normalized(frame[1] - frame[0]), across = left_normal(along);
  const double length_m = distance(frame[0], frame[1]), width_m = distance(frame[1], frame[2]);
  for (const double row_m : rows_across(width_m)) {
    for (int k = 1; k * bay_width_m < length_m - 0.5 * bay_width_m; ++k) {
      const auto at = [&](double x_m, double y_m) {
        return frame[0] + along * (k * bay_width_m + x_m) + across * (row_m + y_m);
      };
      const double low_m = line_gap_m, high_m = bay_depth_m - line_gap_m;
      const std::array<Vec2, 4> line = {at(-0.5 * line_m, low_m), at(0.5 * line_m, low_m), at(0.5 * line_m, high_m),
                                        at(-0.5 * line_m, high_m)};
      const std::array<Vec2, 3> middle = {at(0.0, 0.25 * bay_depth_m), at(0.0, 0.5 * bay_depth_m),
                                          at(0.0, 0.75 * bay_depth_m)};
      const auto is_on = [&](Vec2 p) { return contains(ground, p); };
      if (std::ranges::all_of(line, is_on) && std::ranges::all_of(middle, is_on)) lines.push_back(line);
    }
  }
  return lines;
}

/// Areas of one kind. Those before others take their place.
struct Layer {
  SurfaceMaterial material = SurfaceMaterial::asphalt;
  double lift_m = 0.0, least_m2 = 0.0;  ///< smaller parts are left out
  bool has_bays = false;                ///< each area by itself; those of other layers are one
  MultiPolygon areas;
};

Polygon octagon_at(Vec2 p, double radius_m) {
  constexpr double share = 0.41421356;  // tan(pi / 8): half a side over the inner radius
  const double r = radius_m, c = share * radius_m;
  Polygon octagon;
  for (const Vec2 corner : {Vec2{r, -c}, {r, c}, {c, r}, {-c, r}, {-r, c}, {-r, -c}, {-c, -r}, {c, -r}})
    octagon.outer.push_back(p + corner);
  return octagon;
}

/// The ground within half the width of a line, in pieces of up to 50 m: sides meet in mitres, in octagons where the
/// line bends by more than 60 degrees.
MultiPolygon strip_of(const MapPath& path) {
  constexpr double longest_m = 50.0, least_cos = 0.5;
  const double half_m = 0.5 * path.width_m;
  Polyline line;
  for (const Vec2 p : path.line)
    if (line.empty() || distance(line.back(), p) > plan_grid_m) line.push_back(p);
  MultiPolygon pieces;
  if (line.size() < 2) return pieces;
  const auto normal_after = [&](std::size_t i) { return left_normal(normalized(line[i + 1] - line[i])); };
  Ring left, right;  // of the piece that is being made
  const auto add = [&](Vec2 p, Vec2 offset) { left.push_back(p + offset), right.push_back(p - offset); };
  const auto finish = [&] {
    std::ranges::reverse(left);
    right.insert(right.end(), left.begin(), left.end());
    pieces.push_back({std::move(right), {}});
    left.clear(), right.clear();
  };
  add(line[0], normal_after(0) * half_m);
  double length_m = 0.0;
  for (std::size_t i = 1; i < line.size(); ++i) {
    const Vec2 before = normal_after(i - 1);
    length_m += distance(line[i - 1], line[i]);
    const bool is_last = i + 1 == line.size();
    const Vec2 after = is_last ? before : normal_after(i);
    if (dot(before, after) < least_cos) {
      add(line[i], before * half_m);
      finish();
      pieces.push_back(octagon_at(line[i], half_m));
      add(line[i], after * half_m);
      length_m = 0.0;
      continue;
    }
    const Vec2 mitre = (before + after) * (half_m / (1.0 + dot(before, after)));
    add(line[i], mitre);
    if (!is_last && length_m < longest_m) continue;
    finish();
    add(line[i], mitre);
    length_m = 0.0;
  }
  return pieces;
}

std::vector<Layer> layers_of(const MapSurroundings& surroundings) {
  constexpr double gravel_lift_m = 0.01, path_lift_m = 0.02, parking_lift_m = 0.03;
  std::vector<Layer> layers;
  layers.push_back({SurfaceMaterial::asphalt, parking_lift_m, 20.0, true, surroundings.parking});
  std::map<SurfaceMaterial, MultiPolygon> paths;
  for (const MapPath& path : surroundings.paths) {
    MultiPolygon& strips = paths[material_of(path.surface)];
    std::ranges::move(strip_of(path), std::back_inserter(strips));
  }
  for (auto& [material, strips] : paths) layers.push_back({material, path_lift_m, 1.0, false, std::move(strips)});
  layers.push_back({SurfaceMaterial::gravel, gravel_lift_m, 1.0, false, surroundings.gravel});
  for (Layer& layer : layers) std::erase_if(layer.areas, [](const Polygon& area) { return area.outer.size() < 3; });
  return layers;
}

/// All that takes the place of a cover.
class Taken {
 public:
  explicit Taken(const CoverSite& site) : site_(site) {
    std::vector<Box2> boxes;
    for (const PlacedBuilding& building : site.buildings)
      boxes.push_back(bounds_of(moved(building.footprint, building.middle).outer));
    buildings_ = SpatialIndex(boxes);
  }
  [[nodiscard]] MultiPolygon near(const Box2& box, Vec2 from) const {
    MultiPolygon taken;
    for (const RoadLevel* level : site_.levels)
      for (Polygon& piece : level->driven_near(box, from)) taken.push_back(std::move(piece));
    for (const std::uint32_t i : buildings_.touching(box)) {
      const PlacedBuilding& building = site_.buildings[i];
      if (!building.hovers) taken.push_back(moved(building.footprint, building.middle - from));
    }
    for (const WaterBody& body : site_.waters.bodies())
      if (body.box.overlaps(box))
        for (const Polygon& shore : body.shores) taken.push_back(moved(shore, from * -1.0));
    return taken;
  }

 private:
  const CoverSite& site_;
  SpatialIndex buildings_;
};

/// Areas of a layer that touch a square.
struct Piece {
  std::size_t layer = 0;
  std::vector<const Polygon*> areas;
};

/// A square of the plan, and what touches it.
struct Cell {
  Vec2 middle;
  std::vector<Piece> pieces;
};

std::vector<Cell> cells_of(const std::vector<Layer>& layers) {
  std::map<std::array<double, 2>, Cell> cells;
  for (std::size_t k = 0; k < layers.size(); ++k) {
    for (const Polygon& area : layers[k].areas) {
      const Box2 box = bounds_of(area.outer);
      for (double x = std::floor(box.min_x / cell_m); x * cell_m < box.max_x; ++x) {
        for (double y = std::floor(box.min_y / cell_m); y * cell_m < box.max_y; ++y) {
          Cell& cell = cells[{x, y}];
          cell.middle = {(x + 0.5) * cell_m, (y + 0.5) * cell_m};
          if (layers[k].has_bays || cell.pieces.empty() || cell.pieces.back().layer != k)
            cell.pieces.push_back({k, {}});
          cell.pieces.back().areas.push_back(&area);
        }
      }
    }
  }
  std::vector<Cell> result;
  for (auto& [unused, cell] : cells) result.push_back(std::move(cell));
  return result;
}

/// As polygons of three different corners.
void add_triangles(const Polygon& polygon, Vec2 shift, std::vector<std::array<Vec2, 4>>& triangles) {
  std::vector<Vec2> points;
  std::vector<std::array<std::uint32_t, 2>> constraints;
  std::map<std::array<double, 2>, std::uint32_t> numbers;  // rings may touch in a point, which has one number
  const auto number_of = [&](Vec2 p) {
    const auto [found, is_new] = numbers.try_emplace({p.x, p.y}, static_cast<std::uint32_t>(points.size()));
    if (is_new) points.push_back(p);
    return found->second;
  };
  const auto add_ring = [&](const Ring& ring) {
    for (std::size_t i = 0; i < ring.size(); ++i)
      constraints.push_back({number_of(ring[i]), number_of(ring[(i + 1) % ring.size()])});
  };
  add_ring(polygon.outer);
  for (const Ring& hole : polygon.holes) add_ring(hole);
  const Triangulation t = triangulate(points, constraints);
  std::vector<bool> inside;
  for (const Vec2 p : t.region_points) inside.push_back(contains(polygon, p));
  for (std::size_t i = 0; i < t.triangles.size(); ++i) {
    if (!inside[t.regions[i]]) continue;
    const auto corner = [&](std::size_t k) { return t.points[t.triangles[i][k]] + shift; };
    triangles.push_back({corner(0), corner(1), corner(2), corner(2)});
  }
}

/// The pixel of median brightness of those at points 1 m apart inside the polygon that no tree covers; empty where
/// there is none.
std::optional<LinearColor> color_of(const CoverSite& site, const Polygon& polygon) {
  constexpr double step_m = 1.0;
  const auto is_open = [&](Vec2 p) {
    if (site.labels == nullptr) return true;
    const Vec2 at = site.labels->frame.pixel_from_world(p);
    const int col = static_cast<int>(std::floor(at.x)), row = static_cast<int>(std::floor(at.y));
    if (!site.labels->labels.inside(col, row)) return true;
    const std::uint8_t label = site.labels->labels.at(col, row);
    const auto& classes = site.labels->classes.classes;
    return label >= classes.size() || classes[label].role != Role::vegetation;
  };
  std::vector<Rgb> pixels;
  const GridFrame frame = covering_grid(bounds_of(polygon.outer), step_m);
  rasterize(polygon, frame, [&](int row, int begin, int end) {
    for (int col = begin; col < end; ++col)
      if (const Vec2 p = frame.center_of(col, row); is_open(p))
        if (const auto pixel = pixel_at(site.photo, p)) pixels.push_back(*pixel);
  });
  if (pixels.empty()) return std::nullopt;
  return median_color(pixels);
}

/// Around the middle of a cell: a square, what is taken of it, and what those before have of it.
struct Room {
  Vec2 middle;
  Polygon square;
  MultiPolygon taken, before;
};

PlacedCover place(const Piece& piece, const Layer& layer, Room& room, const CoverSite& site) {
  constexpr LinearColor under_trees = {0.2F, 0.2F, 0.19F};
  PlacedCover cover{.middle = room.middle, .material = layer.material, .lift_m = layer.lift_m, .color = under_trees};
  MultiPolygon local;
  for (const Polygon* area : piece.areas) local.push_back(moved(*area, room.middle * -1.0));
  const MultiPolygon whole = intersection_of(union_of(local, plan_grid_m), {room.square}, plan_grid_m);
  MultiPolygon ground = whole;
  for (const MultiPolygon* others : {&room.taken, &room.before})
    if (!ground.empty() && !others->empty()) ground = difference_of(ground, *others, plan_grid_m);
  if (!whole.empty()) {
    room.before.insert(room.before.end(), whole.begin(), whole.end());
    room.before = union_of(room.before, plan_grid_m);
  }
  double largest_m2 = 0.0;
  for (const Polygon& part : ground) {
    const double part_m2 = area_m2(part);
    if (part_m2 < layer.least_m2) continue;
    add_triangles(part, room.middle, cover.faces);
    if (layer.has_bays) {
      for (std::array<Vec2, 4> line : lines_of(local.front(), part)) {
        for (Vec2& p : line) p = p + room.middle;
        cover.lines.push_back(line);
      }
    }
    if (part_m2 <= largest_m2) continue;
    largest_m2 = part_m2;
    if (const auto color = color_of(site, moved(part, room.middle))) cover.color = *color;
  }
  return cover;
}

std::vector<PlacedCover> place(const Cell& cell, const std::vector<Layer>& layers, const Taken& taken,
                               const CoverSite& site) {
  std::vector<PlacedCover> covers;
  if (!site.area.contains(cell.middle)) return covers;
  constexpr double half_m = 0.5 * cell_m;
  Room room{.middle = cell.middle,
            .square = {{{-half_m, -half_m}, {half_m, -half_m}, {half_m, half_m}, {-half_m, half_m}}, {}}};
  const Box2 box{cell.middle.x - half_m, cell.middle.y - half_m, cell.middle.x + half_m, cell.middle.y + half_m};
  if (const MultiPolygon others = taken.near(box.grown(clearance_m), cell.middle); !others.empty())
    room.taken = buffer_of(union_of(others, plan_grid_m), clearance_m, 2);
  for (const Piece& piece : cell.pieces) {
    PlacedCover cover = place(piece, layers[piece.layer], room, site);
    if (!cover.faces.empty()) covers.push_back(std::move(cover));
  }
  return covers;
}

}  // namespace

std::vector<PlacedCover> place_covers(const MapSurroundings& surroundings, const CoverSite& site) {
  const Taken taken(site);
  const std::vector<Layer> layers = layers_of(surroundings);
  const std::vector<Cell> cells = cells_of(layers);
  std::vector<std::vector<PlacedCover>> by_cell(cells.size());
  parallel_for(cells.size(), site.threads, [&](std::size_t i) { by_cell[i] = place(cells[i], layers, taken, site); });
  std::vector<PlacedCover> placed;
  for (std::vector<PlacedCover>& covers : by_cell) std::ranges::move(covers, std::back_inserter(placed));
  return placed;
}

namespace {

/// Covers of one material and height.
void add_covers(const TriMesh& terrain, std::span<const PlacedCover* const> covers, Vec2 center, TriMesh& mesh) {
  std::vector<std::array<Vec2, 4>> pieces;
  std::vector<std::size_t> owner;  // of a piece
  for (std::size_t i = 0; i < covers.size(); ++i) {
    for (std::array<Vec2, 4> piece : covers[i]->faces) {
      for (Vec2& p : piece) p = p - center;
      pieces.push_back(piece);
    }
    owner.resize(pieces.size(), i);
  }
  using Place = std::array<std::int64_t, 2>;
  const auto f = [](double v) { return static_cast<float>(v); };
  std::vector<std::map<Place, std::uint32_t>> known(covers.size());  // parts of one area share their corners
  cut_at_mesh(terrain, 0, pieces, [&](std::size_t number, std::span<const DrapedCorner> part) {
    const PlacedCover& cover = *covers[owner[number]];
    std::vector<std::uint32_t> corners;
    for (const DrapedCorner& c : part) {
      const Place key = {std::llround(c.p.x / plan_grid_m), std::llround(c.p.y / plan_grid_m)};
      const auto [found, is_new] =
          known[owner[number]].try_emplace(key, static_cast<std::uint32_t>(mesh.positions.size()));
      if (is_new) {
        mesh.positions.push_back({f(c.p.x), f(c.p.y), f(c.z + cover.lift_m)});
        mesh.normals.push_back({f(c.normal[0]), f(c.normal[1]), f(c.normal[2])});
        mesh.colors.push_back(mesh_color(cover.color));
      }
      if (corners.empty() || (corners.back() != found->second && corners.front() != found->second))
        corners.push_back(found->second);
    }
    const auto at = [&](std::size_t k) {
      const auto& p = mesh.positions[corners[k]];
      return Vec2{double{p[0]}, double{p[1]}};
    };
    for (std::size_t k = 2; k < corners.size(); ++k)
      if (cross(at(k - 1) - at(0), at(k) - at(0)) > 0.0)
        mesh.indices.insert(mesh.indices.end(), {corners[0], corners[k - 1], corners[k]});
  });
}

/// Triangles without area in plan, which simplifying leaves.
void leave_out_empty(TriMesh& mesh) {
  const auto at = [&](std::size_t i) {
    const auto& p = mesh.positions[mesh.indices[i]];
    return Vec2{double{p[0]}, double{p[1]}};
  };
  std::vector<std::uint32_t> kept;
  for (std::size_t i = 0; i < mesh.indices.size(); i += 3)
    if (cross(at(i + 1) - at(i), at(i + 2) - at(i)) > 0.0)
      kept.insert(kept.end(), &mesh.indices[i], &mesh.indices[i] + 3);
  mesh.indices = std::move(kept);
  mesh.parts.front().index_count = mesh.indices.size();
}

}  // namespace

std::vector<TriMesh> cover_meshes(const TriMesh& terrain, std::span<const PlacedCover* const> covers, Vec2 center,
                                  TriMesh& marking) {
  std::map<SurfaceMaterial, std::vector<const PlacedCover*>> by_material;
  std::vector<std::array<Vec2, 4>> lines;
  double lift_m = 0.0;
  for (const PlacedCover* cover : covers) {
    by_material[cover->material].push_back(cover);
    for (std::array<Vec2, 4> line : cover->lines) {
      for (Vec2& p : line) p = p - center;
      lines.push_back(line);
      lift_m = cover->lift_m + line_over_m;
    }
  }
  drape(terrain, 0, lines, lift_m, marking);
  std::vector<TriMesh> meshes;
  for (const auto& [material, of_material] : by_material) {
    TriMesh mesh{.kind = MeshKind::verge};
    add_covers(terrain, of_material, center, mesh);
    if (mesh.indices.empty()) continue;
    add_material(material, mesh);
    simplify(mesh, flat_m);
    leave_out_empty(mesh);
    meshes.push_back(std::move(mesh));
  }
  return meshes;
}

}  // namespace orthodrive::scene
