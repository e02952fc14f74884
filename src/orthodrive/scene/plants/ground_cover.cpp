// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/scene/plants/ground_cover.hpp"

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
#include "orthodrive/scene/look/mesh_materials.hpp"
#include "orthodrive/scene/plan/drape.hpp"
#include "orthodrive/scene/plan/plan_grid.hpp"
#include "orthodrive/scene/plan/simplify_mesh.hpp"
#include "orthodrive/scene/plan/triangulate.hpp"

namespace orthodrive::scene {
namespace {

constexpr double cell_m = 96.0;  // a tile has whole ones: parts of large areas depend on what is near alone
constexpr double bay_width_m = 2.5, bay_depth_m = 5.0, aisle_m = 6.0, bay_line_m = 0.1, bay_line_gap_m = 0.15;
constexpr double gravel_lift_m = 0.01, path_lift_m = 0.02, parking_lift_m = 0.03;
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

/// Areas of one kind, or paths of one material. Those before others take their place.
struct Layer {
  SurfaceMaterial material = SurfaceMaterial::asphalt;
  double lift_m = 0.0, least_m2 = 0.0;  ///< smaller parts are left out
  bool has_bays = false;                ///< each area by itself; those of other layers are one
  std::vector<const Polygon*> areas;
  std::vector<const MapPath*> paths;
};

std::vector<Layer> layers_of(const MapSurroundings& surroundings) {
  std::vector<Layer> layers;
  const auto add_areas = [&](Layer layer, const MultiPolygon& areas) {
    for (const Polygon& area : areas)
      if (area.outer.size() >= 3) layer.areas.push_back(&area);
    layers.push_back(std::move(layer));
  };
  add_areas({SurfaceMaterial::asphalt, parking_lift_m, 20.0, true, {}, {}}, surroundings.parking);
  std::map<SurfaceMaterial, std::vector<const MapPath*>> paths;
  for (const MapPath& path : surroundings.paths)
    if (path.line.size() >= 2) paths[material_of(path.surface)].push_back(&path);
  for (auto& [material, of_material] : paths)
    layers.push_back({material, path_lift_m, 1.0, false, {}, std::move(of_material)});
  add_areas({SurfaceMaterial::gravel, gravel_lift_m, 1.0, false, {}, {}}, surroundings.gravel);
  return layers;
}

/// Lines between the bays of the whole area that lie on the part of it and on free ground; relative to `middle`.
std::vector<std::array<Vec2, 4>> lines_of(const Polygon& area, const Polygon& part, Vec2 middle,
                                          const CoverSite& site) {
  std::vector<std::array<Vec2, 4>> lines;
  Ring frame = narrowest_rectangle(area.outer);
  if (frame.size() != 4) return lines;
  if (distance(frame[0], frame[1]) < distance(frame[1], frame[2])) std::ranges::rotate(frame, frame.begin() + 1);
  const Vec2 along = normalized(frame[1] - frame[0]), across = left_normal(along);
  const double length_m = distance(frame[0], frame[1]), width_m = distance(frame[1], frame[2]);
  const auto is_on = [&](Vec2 p) {
    return contains(part, p) && site.waters.at(p + middle) == nullptr &&
           site.space.around(p + middle, bay_line_m) > 0.0;
  };
  for (const double row_m : rows_across(width_m)) {
    for (int k = 1; k * bay_width_m < length_m - 0.5 * bay_width_m; ++k) {
      const auto at = [&](double x_m, double y_m) {
        return frame[0] + along * (k * bay_width_m + x_m) + across * (row_m + y_m);
      };
      const double low_m = bay_line_gap_m, high_m = bay_depth_m - bay_line_gap_m;
      const std::array<Vec2, 4> line = {at(-0.5 * bay_line_m, low_m), at(0.5 * bay_line_m, low_m),
                                        at(0.5 * bay_line_m, high_m), at(-0.5 * bay_line_m, high_m)};
      const std::array<Vec2, 3> between = {at(0.0, 0.25 * bay_depth_m), at(0.0, 0.5 * bay_depth_m),
                                           at(0.0, 0.75 * bay_depth_m)};
      if (std::ranges::all_of(line, is_on) && std::ranges::all_of(between, is_on)) lines.push_back(line);
    }
  }
  return lines;
}

/// Parts of paths relative to the middle of a square, by half their width.
using Strips = std::map<double, std::vector<Polyline>>;

/// What of a layer touches a square.
struct Piece {
  std::size_t layer = 0;
  std::vector<const Polygon*> areas;
  Strips strips;
};

/// A square of the plan, and what touches it.
struct Cell {
  Vec2 middle;
  std::vector<Piece> pieces;
};

/// By the place of their squares.
class Cells {
 public:
  explicit Cells(const CoverSite& site) : site_(site) {}
  void add(const Layer& layer, std::size_t number) {
    for (const Polygon* area : layer.areas)
      for_each_cell(bounds_of(area->outer),
                    [&](Cell& cell) { piece_of(cell, number, layer.has_bays).areas.push_back(area); });
    for (const MapPath* path : layer.paths) add_path(*path, number);
  }
  [[nodiscard]] std::vector<Cell> take() {
    std::vector<Cell> result;
    result.reserve(cells_.size());
    for (auto& [unused, cell] : cells_) result.push_back(std::move(cell));
    return result;
  }

 private:
  template <typename Visit>
  void for_each_cell(const Box2& own, const Visit& visit) {
    const Box2 box{std::max(own.min_x, site_.box.min_x), std::max(own.min_y, site_.box.min_y),
                   std::min(own.max_x, site_.box.max_x), std::min(own.max_y, site_.box.max_y)};
    for (double x = std::floor(box.min_x / cell_m); x * cell_m <= box.max_x; ++x) {
      for (double y = std::floor(box.min_y / cell_m); y * cell_m <= box.max_y; ++y) {
        const Vec2 middle{(x + 0.5) * cell_m, (y + 0.5) * cell_m};
        if (!site_.box.contains(middle) || !site_.space.is_in_area(middle)) continue;
        Cell& cell = cells_[{x, y}];
        cell.middle = middle;
        visit(cell);
      }
    }
  }
  static Piece& piece_of(Cell& cell, std::size_t layer, bool alone) {
    if (alone || cell.pieces.empty() || cell.pieces.back().layer != layer) cell.pieces.push_back({layer, {}, {}});
    return cell.pieces.back();
  }
  /// Its whole segments, those that follow each other as one line. One more at each end: corners are mitred by it.
  void add_path(const MapPath& path, std::size_t number) {
    const double half_m = 0.5 * path.width_m;
    Polyline line;
    for (const Vec2 p : path.line)
      if (line.empty() || distance(line.back(), p) > plan_grid_m) line.push_back(p);
    std::map<std::array<double, 2>, std::size_t> last;  // segment that a cell has got, by its middle
    for (std::size_t i = 1; i < line.size(); ++i) {
      const Box2 box{std::min(line[i - 1].x, line[i].x), std::min(line[i - 1].y, line[i].y),
                     std::max(line[i - 1].x, line[i].x), std::max(line[i - 1].y, line[i].y)};
      for_each_cell(box.grown(2.0 * half_m), [&](Cell& cell) {
        std::vector<Polyline>& parts = piece_of(cell, number, false).strips[half_m];
        const auto [found, is_new] = last.try_emplace({cell.middle.x, cell.middle.y}, i);
        if (is_new || found->second + 1 != i) {
          parts.emplace_back();
          if (i >= 2) parts.back().push_back(line[i - 2] - cell.middle);
          parts.back().push_back(line[i - 1] - cell.middle);
        }
        parts.back().push_back(line[i] - cell.middle);
        found->second = i;
      });
    }
  }

  const CoverSite& site_;
  std::map<std::array<double, 2>, Cell> cells_;
};

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
  inside.reserve(t.region_points.size());
  for (const Vec2 p : t.region_points) inside.push_back(contains(polygon, p));
  for (std::size_t i = 0; i < t.triangles.size(); ++i) {
    if (!inside[t.regions[i]]) continue;
    const auto corner = [&](std::size_t k) { return t.points[t.triangles[i][k]] + shift; };
    triangles.push_back({corner(0), corner(1), corner(2), corner(2)});
  }
}

/// The photo's median where the labels show no trees; empty where they are everywhere.
std::optional<LinearColor> color_of(const CoverSite& site, const Polygon& polygon) {
  return photo_median(site.photo, polygon, [&](Vec2 p) {
    if (site.labels == nullptr) return true;
    const Vec2 at = site.labels->frame.pixel_from_world(p);
    const int col = static_cast<int>(std::floor(at.x)), row = static_cast<int>(std::floor(at.y));
    if (!site.labels->labels.inside(col, row)) return true;
    const std::uint8_t label = site.labels->labels.at(col, row);
    const auto& classes = site.labels->classes.classes;
    return label >= classes.size() || classes[label].role != Role::vegetation;
  });
}

/// Around the middle of a cell: a square, and what the covers before have of it.
struct Room {
  Vec2 middle;
  Polygon square;
  MultiPolygon before;
};

PlacedCover place(const Piece& piece, const Layer& layer, Room& room, const CoverSite& site) {
  constexpr LinearColor under_trees = {0.2F, 0.2F, 0.19F};
  PlacedCover cover{.middle = room.middle, .material = layer.material, .lift_m = layer.lift_m, .color = under_trees};
  MultiPolygon local;
  for (const Polygon* area : piece.areas) local.push_back(moved(*area, room.middle * -1.0));
  for (const auto& [half_m, lines] : piece.strips) {
    const MultiPolygon strips = buffer_of_lines(lines, half_m);  // free of overlaps
    local.insert(local.end(), strips.begin(), strips.end());
  }
  const bool is_clean = piece.areas.empty() && piece.strips.size() == 1;
  if (!is_clean) local = union_of(local, plan_grid_m);
  MultiPolygon ground = intersection_of(local, {room.square}, plan_grid_m);
  const MultiPolygon whole = ground;
  if (!ground.empty() && !room.before.empty())
    ground = difference_of(ground, union_of(room.before, plan_grid_m), plan_grid_m);
  room.before.insert(room.before.end(), whole.begin(), whole.end());
  double largest_m2 = 0.0;
  for (const Polygon& part : ground) {
    const double part_m2 = area_m2(part);
    if (part_m2 < layer.least_m2) continue;
    add_triangles(part, room.middle, cover.faces);
    if (layer.has_bays) {
      const Polygon area = moved(*piece.areas.front(), room.middle * -1.0);
      for (std::array<Vec2, 4> line : lines_of(area, part, room.middle, site)) {
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

std::vector<PlacedCover> place(const Cell& cell, const std::vector<Layer>& layers, const CoverSite& site) {
  std::vector<PlacedCover> covers;
  constexpr double half_m = 0.5 * cell_m;
  Room room{.middle = cell.middle,
            .square = {{{-half_m, -half_m}, {half_m, -half_m}, {half_m, half_m}, {-half_m, half_m}}, {}}};
  for (const Piece& piece : cell.pieces) {
    PlacedCover cover = place(piece, layers[piece.layer], room, site);
    if (!cover.faces.empty()) covers.push_back(std::move(cover));
  }
  return covers;
}

}  // namespace

std::vector<PlacedCover> place_covers(const MapSurroundings& surroundings, const CoverSite& site) {
  const std::vector<Layer> layers = layers_of(surroundings);
  Cells found(site);
  for (std::size_t i = 0; i < layers.size(); ++i) found.add(layers[i], i);
  const std::vector<Cell> cells = found.take();
  std::vector<std::vector<PlacedCover>> by_cell(cells.size());
  parallel_for(cells.size(), site.threads, [&](std::size_t i) { by_cell[i] = place(cells[i], layers, site); });
  std::vector<PlacedCover> placed;
  for (std::vector<PlacedCover>& covers : by_cell) std::ranges::move(covers, std::back_inserter(placed));
  return placed;
}

namespace {

/// Covers of one material.
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
  for (const PlacedCover* cover : covers) {
    by_material[cover->material].push_back(cover);
    for (std::array<Vec2, 4> line : cover->lines) {
      for (Vec2& p : line) p = p - center;
      lines.push_back(line);
    }
  }
  drape(terrain, 0, lines, parking_lift_m + line_over_m, marking);
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
