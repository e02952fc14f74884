// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/scene/tiles/scene_layout.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <set>
#include <utility>

#include "orthodrive/core/error.hpp"
#include "orthodrive/core/parallel.hpp"
#include "orthodrive/scene/buildings/label_footprints.hpp"
#include "orthodrive/scene/objects/line_objects.hpp"
#include "orthodrive/scene/objects/map_objects.hpp"
#include "orthodrive/scene/plants/trees.hpp"
#include "orthodrive/scene/roads/crossing_roads.hpp"
#include "orthodrive/scene/roads/lane_cuts.hpp"
#include "orthodrive/scene/roads/road_paint.hpp"
#include "orthodrive/scene/roads/tile_crossings.hpp"
#include "roadquery/surface/road_surface.hpp"

namespace orthodrive {
namespace scene {
namespace {

/// Around a block: what lies further away changes nothing in it. Buildings that only the photo shows reach furthest.
constexpr double margin_m = 160.0;
constexpr double verge_point_step_m = 5.0;
constexpr double deck_gap_m = 0.3;  // between the underside of a deck and the terrain

/// The parts of the rings whose segments touch the box.
void append_rings(const MultiPolygon& polygons, const Box2& box, std::vector<Polyline>& lines) {
  const auto add = [&](const Ring& ring) {
    bool is_open = false;
    for (std::size_t i = 0; i < ring.size(); ++i) {
      const Vec2 a = ring[i], b = ring[(i + 1) % ring.size()];
      const bool touches = bounds_of({a, b}).overlaps(box);
      if (touches && !is_open) lines.push_back({a});
      if (touches) lines.back().push_back(b);
      is_open = touches;
    }
  };
  for (const Polygon& polygon : polygons) {
    add(polygon.outer);
    for (const Ring& hole : polygon.holes) add(hole);
  }
}

/// The lines along and across the roads of a level whose boxes touch the given one.
void append_lane_cuts(const RoadLevel& level, const roadquery::RoadQuery& query, const RoadJoints& joints,
                      const Box2& box, std::vector<Polyline>& lines) {
  for (std::size_t i = 0; i < level.roads().size(); ++i) {
    const roadquery::Road& road = *level.roads()[i];
    const auto index = static_cast<std::size_t>(&road - query.map().roads.data());
    for (Polyline& line : lane_cuts(road, level.strips()[i], joints.across(index)))
      if (bounds_of(line).overlaps(box)) lines.push_back(std::move(line));
  }
}

LevelLines cut_at_tiles(std::vector<Polyline> lines, const Box2& bounds) {
  const TileAddress first = tile_at({bounds.min_x, bounds.min_y}), last = tile_at({bounds.max_x, bounds.max_y});
  const Box2 all{tile_box(first).min_x, tile_box(first).min_y, tile_box(last).max_x, tile_box(last).max_y};
  for (int c = first.column; c <= last.column + 1; ++c)
    lines.push_back({{c * scene_tile_m, all.min_y}, {c * scene_tile_m, all.max_y}});
  for (int r = first.row; r <= last.row + 1; ++r)
    lines.push_back({{all.min_x, r * scene_tile_m}, {all.max_x, r * scene_tile_m}});

  LevelLines result;
  const auto on_line = [](double v) { return std::fmod(v, scene_tile_m) == 0.0; };  // exact: both are on the plan grid
  const auto before = [](Vec2 a, Vec2 b) { return std::pair(a.x, a.y) < std::pair(b.x, b.y); };
  for (LineSegment segment : node_lines(lines, plan_grid_m)) {
    if (before(segment.b, segment.a)) std::swap(segment.a, segment.b);
    for (const Vec2 p : {segment.a, segment.b}) {
      if (on_line(p.x)) result.on_west[static_cast<int>(p.x / scene_tile_m)].push_back(p.y);
      if (on_line(p.y)) result.on_south[static_cast<int>(p.y / scene_tile_m)].push_back(p.x);
    }
    const bool along_border =
        (segment.a.x == segment.b.x && on_line(segment.a.x)) || (segment.a.y == segment.b.y && on_line(segment.a.y));
    if (!along_border) result.inside[tile_at((segment.a + segment.b) * 0.5)].push_back(segment);
  }
  for (auto& [address, segments] : result.inside)  // not in the overlay's order, which others of its lines decide
    std::ranges::sort(segments, [&](const LineSegment& a, const LineSegment& b) {
      return before(a.a, b.a) || (!before(b.a, a.a) && before(a.b, b.b));
    });
  for (auto* side : {&result.on_west, &result.on_south}) {
    for (auto& [index, values] : *side) {
      std::sort(values.begin(), values.end());
      values.erase(std::unique(values.begin(), values.end()), values.end());
    }
  }
  return result;
}

/// Calls visit(address) for the tiles that a polygon's box touches.
template <typename Visit>
void visit_tiles(const std::array<Vec2, 4>& piece, const Visit& visit) {
  const auto [west, east] = std::minmax({piece[0].x, piece[1].x, piece[2].x, piece[3].x});
  const auto [south, north] = std::minmax({piece[0].y, piece[1].y, piece[2].y, piece[3].y});
  const TileAddress first = tile_at({west, south}), last = tile_at({east, north});
  for (int c = first.column; c <= last.column; ++c)
    for (int r = first.row; r <= last.row; ++r) visit(TileAddress{c, r});
}

/// `raised`: the map with the heights of lanes, which that of the level's query lacks.
void add_level_kerbs(const RoadLevel& level, const roadquery::RoadQuery& query, const roadquery::RoadMap& raised,
                     LevelLines& lines) {
  for (const roadquery::Road* road : level.roads())
    for (const KerbPiece& piece : kerb_pieces(raised.roads[static_cast<std::size_t>(road - query.map().roads.data())]))
      visit_tiles(piece.corners, [&](TileAddress address) { lines.kerbs[address].push_back(piece); });
}

void add_markings(const RoadLevel& level, LevelLines& lines) {
  for (const roadquery::Road* road : level.roads()) {
    std::vector<MarkingPiece> pieces = road_markings(*road);
    std::ranges::move(road_paint(*road), std::back_inserter(pieces));
    for (const MarkingPiece& piece : pieces)
      visit_tiles(piece.corners, [&](TileAddress address) { lines.markings[address].push_back(piece); });
  }
}

/// Calls visit(p, outwards) at least every `step_m` along the borders in the box, for each of their segments by itself.
template <typename Visit>
void walk_borders(const Outline& outline, const Box2& box, double step_m, const Visit& visit) {
  for (const BorderSegment& segment : outline.segments()) {
    if (!bounds_of({segment.a, segment.b}).overlaps(box)) continue;
    const Vec2 outwards = left_normal(normalized(segment.b - segment.a)) * -1.0;
    const int parts = static_cast<int>(std::ceil(distance(segment.a, segment.b) / step_m));
    for (int k = 0; k < parts; ++k) visit(segment.a + (segment.b - segment.a) * ((k + 0.5) / parts), outwards);
  }
}

}  // namespace

Box2 block_box(TileAddress block, int block_tiles) {
  const double size_m = block_tiles * scene_tile_m;
  return {block.column * size_m, block.row * size_m, (block.column + 1) * size_m, (block.row + 1) * size_m};
}

Box2 block_around(const std::vector<TileAddress>& tiles) {
  if (tiles.empty()) return {};
  Box2 box = tile_box(tiles.front());
  for (const TileAddress address : tiles) {
    const Box2 own = tile_box(address);
    box = {std::min(box.min_x, own.min_x), std::min(box.min_y, own.min_y), std::max(box.max_x, own.max_x),
           std::max(box.max_y, own.max_y)};
  }
  return box;
}

std::shared_ptr<const SceneLayout> lay_out_block(const std::shared_ptr<const SceneFrame>& frame,
                                                 const SceneWindows& windows, const Box2& block) {
  const auto layout = std::make_shared<SceneLayout>(frame, windows.window(block.grown(margin_m)), block);
  const Box2 all = block_around(frame->tiles);
  std::erase_if(layout->findings, [&](const Finding& finding) {
    // The last metre of the area belongs to the tile before its border.
    const auto inside = [](double v, double low, double high) {
      return std::isnan(v) ? low : std::clamp(v, low, high - 1.0);
    };
    const Vec2 p{inside(finding.x_m, all.min_x, all.max_x), inside(finding.y_m, all.min_y, all.max_y)};
    return !(p.x >= block.min_x && p.x < block.max_x && p.y >= block.min_y && p.y < block.max_y);
  });
  return layout;
}

}  // namespace scene

using namespace scene;

namespace {

template <typename Placed>
Vec2 foot_of(const Placed& placed) {
  return {placed.foot.x, placed.foot.y};
}

std::unique_ptr<const Family> of_faces(const std::vector<StructureFace>& faces, std::vector<FaceMesh> meshes) {
  return std::make_unique<const FaceFamily>(faces, std::move(meshes));
}

/// What runs along lines: walls and fences, ballast, hedges.
std::vector<FaceMesh> of_each_material(MeshKind kind) {
  return {{kind, {SurfaceMaterial::concrete}}, {kind, {SurfaceMaterial::gravel}}, {kind, {SurfaceMaterial::foliage}}};
}

struct SortedRoads {
  std::vector<const roadquery::Road*> ground;
  std::vector<std::vector<const roadquery::Road*>> decks, tunnels;
};

SortedRoads sort_roads(const roadquery::RoadQuery& query, const std::set<int>& over, Findings& findings) {
  SortedRoads sorted;
  std::map<int, std::vector<const roadquery::Road*>> decks, tunnels;  // by layer
  for (std::size_t i = 0; i < query.map().roads.size(); ++i) {
    const roadquery::Road& road = query.map().roads[i];
    if (!(road.length > 0.0)) continue;
    if (!has_sections(query, i)) {
      const auto at = roadquery::reference_point(road, 0.0);
      findings.push_back({Severity::warning, "scene.road_without_surface",
                          fmt::format("road {} has no lanes or no finite heights and is not drawn", road.id), at.x,
                          at.y});
      continue;
    }
    switch (structure_of(road, over.contains(road.id))) {
      case RoadStructure::tunnel:
        tunnels[std::min(-1, road.layer)].push_back(&road);
        break;
      case RoadStructure::deck:
        decks[std::max(1, road.layer)].push_back(&road);
        break;
      case RoadStructure::ground:
        sorted.ground.push_back(&road);
        break;
    }
  }
  const auto tell_apart = [](const auto& by_layer, auto& sets) {
    for (const auto& [layer, of_layer] : by_layer) std::ranges::move(told_apart(of_layer), std::back_inserter(sets));
  };
  tell_apart(decks, sorted.decks);
  tell_apart(tunnels, sorted.tunnels);
  return sorted;
}

}  // namespace

SceneLayout::SceneLayout(std::shared_ptr<const SceneFrame> scene_frame, SceneWindow scene_window, const Box2& block)
    : frame(std::move(scene_frame)),
      window(std::move(scene_window)),
      options(frame->options),
      area(frame->outline),
      origin(frame->origin),
      photo(&window.photo),
      labels(window.labels ? &*window.labels : nullptr) {
  for (const TileAddress address : frame->tiles)
    if (const Box2 box = tile_box(address);
        box.min_x >= block.min_x && box.min_y >= block.min_y && box.max_x <= block.max_x && box.max_y <= block.max_y)
      tiles.push_back(address);
  std::vector<Building> known = window.buildings;
  std::vector<TreeCrown> crowns;
  const auto read_labels = [&] {  // needs no roads
    if (labels == nullptr) return;
    std::ranges::move(footprints_of_labels(*labels, window.buildings), std::back_inserter(known));
    crowns = find_crowns(*labels, *photo);
  };
  parallel_for(2, options.threads, [&](std::size_t task) { task == 0 ? lay_roads() : read_labels(); });

  std::vector<const RoadLevel*> levels = {&roads};
  for (const RoadLevel& deck : decks) levels.push_back(&deck);
  buildings = place_buildings(known, {levels, area, *ground, *photo, options.threads}, findings);
  for (const PlacedBuilding& building : buildings) buildings_in[tile_at(building.middle)].push_back(&building);
  const FreeSpace space({levels, buildings, area, openings});
  families.push_back(std::make_unique<const BuildingFamily>(buildings_in));
  families.push_back(std::make_unique<const CopiedFamily<PlacedTree>>(
      plant_trees(crowns, window.trees, space, *ground, *photo, options.threads), foot_of<PlacedTree>, tree_instances));
  if (window.surroundings) add_surroundings(*window.surroundings, space, block);
  add_terrain_points();
}

void SceneLayout::add_surroundings(const MapSurroundings& surroundings, const FreeSpace& space, const Box2& block) {
  ObjectFaces standing = object_faces(surroundings, {roads, *query, space, *ground, window.power_ground_m});
  std::vector<StructureFace> lasting = barrier_faces(surroundings.barriers, space, *ground);
  std::ranges::move(standing.large, std::back_inserter(lasting));
  families.push_back(of_faces(lasting, of_each_material(MeshKind::barrier)));
  families.push_back(of_faces(track_faces(surroundings.tracks, space, *ground), of_each_material(MeshKind::track)));
  families.push_back(of_faces(standing.small, {{MeshKind::object, {SurfaceMaterial::concrete}}}));
  families.push_back(std::make_unique<const CopiedFamily<PlacedLamp>>(
      place_lamps(surroundings.lamps, roads, space, *ground), foot_of<PlacedLamp>,
      [](const std::vector<const PlacedLamp*>& lamps, Vec3 origin) {
        return std::vector<InstancedMesh>{lamp_instances(lamps, origin)};
      }));
  covers = place_covers(surroundings, {space, waters, *photo, labels, block, options.threads});
  for (const PlacedCover& cover : covers) covers_in[tile_at(cover.middle)].push_back(&cover);
}

const RoadLevel& SceneLayout::level(int number) const {
  if (number == 0) return roads;
  const auto above = static_cast<std::size_t>(number) - 1;
  return above < decks.size() ? decks[above] : tunnels[above - decks.size()];
}

void SceneLayout::lay_levels() {
  roadquery::RoadMap flat = window.roads;
  roadquery::remove_lane_heights(flat);
  query = std::make_shared<const roadquery::RoadQuery>(std::move(flat));
  const SortedRoads sorted = sort_roads(*query, frame->roads_over, findings);
  std::vector<int> level_of(query->map().roads.size(), -1);
  int levels = 0;
  const auto number = [&](const std::vector<const roadquery::Road*>& of_level) {
    for (const roadquery::Road* road : of_level)
      level_of[static_cast<std::size_t>(road - query->map().roads.data())] = levels;
    ++levels;
  };
  number(sorted.ground);
  for (const auto* sets : {&sorted.decks, &sorted.tunnels})
    for (const auto& of_level : *sets) number(of_level);
  joints = RoadJoints(*query, level_of);
  const RoadLevelOptions level_options{
      .strip = {.tolerance_m = options.road_tolerance_m, .max_step_m = options.terrain_step_m},
      .reach_m = std::max({options.verge_m + 1.0, tree_reach_m, track_reach_m}),
      .threads = options.threads,
      .query = query,
      .joints = &joints};
  roads = RoadLevel(sorted.ground, frame->area, level_options);
  for (const auto& of_level : sorted.decks) decks.emplace_back(of_level, frame->area, level_options);
  for (const auto& of_level : sorted.tunnels) tunnels.emplace_back(of_level, frame->area, level_options);
}

/// Adds the openings' borders to the lines of the ground.
void SceneLayout::lay_tunnels(std::vector<Polyline>& lines) {
  Tunnels built = build_tunnels({roads, tunnels, *ground, *query, joints, area}, frame->dense_area);
  append_rings(built.openings, window.box, lines);
  openings = Outline(built.openings, tree_reach_m);
  families.push_back(of_faces(built.faces, {{MeshKind::tunnel, {SurfaceMaterial::concrete}}}));
  constexpr std::size_t over_tunnels = 4;
  for (const Vec2 p : built.ground_points) terrain_points[tile_at(p)][over_tunnels].push_back(snap_to_grid(p));
  std::ranges::move(built.findings, std::back_inserter(findings));
}

void SceneLayout::lay_roads() {
  lay_levels();
  if (window.surroundings)
    waters = Waters(window.surroundings->water, window.water_levels, {roads, frame->area, window.box, options.verge_m});
  ground = std::make_unique<const Ground>(
      std::move(window.terrain), roads, decks, waters,
      GroundOptions{.verge_m = options.verge_m, .deck_clearance_m = options.deck_thickness_m + deck_gap_m});

  std::vector<Polyline> lines;
  append_rings(frame->dense_area, window.box, lines);
  append_rings(roads.polygons(), window.box, lines);
  append_lane_cuts(roads, *query, joints, window.box, lines);
  for (const WaterBody& body : waters.bodies()) append_rings(body.shores, window.box, lines);
  lay_tunnels(lines);
  ground_lines = cut_at_tiles(std::move(lines), window.box);
  const double chord_m = 0.5 * options.road_tolerance_m;
  add_road_crossings(roads, chord_m, ground_lines.on_west, ground_lines.on_south);
  add_markings(roads, ground_lines);
  add_level_kerbs(roads, *query, window.roads, ground_lines);
  const auto add_lines = [&](const RoadLevel& level, std::vector<LevelLines>& of_levels) {
    std::vector<Polyline> borders;
    append_rings(level.polygons(), window.box, borders);
    append_lane_cuts(level, *query, joints, window.box, borders);
    LevelLines& own = of_levels.emplace_back(cut_at_tiles(std::move(borders), window.box));
    add_road_crossings(level, chord_m, own.on_west, own.on_south);
    add_markings(level, own);
    add_level_kerbs(level, *query, window.roads, own);
  };
  for (const RoadLevel& deck : decks) add_lines(deck, deck_lines);
  for (const RoadLevel& tunnel : tunnels) add_lines(tunnel, tunnel_lines);
  families.push_back(of_faces(
      build_structures({roads, decks, *ground, *query, options.deck_thickness_m}),
      {{MeshKind::structure, {SurfaceMaterial::concrete}}, {MeshKind::rails, {SurfaceMaterial::concrete, true}}}));
  std::vector<const RoadLevel*> levels = {&roads};
  for (const RoadLevel& deck : decks) levels.push_back(&deck);
  tint = RoadTint(levels, *photo);
}

/// Terrain vertices beside roads and below decks.
void SceneLayout::add_terrain_points() {
  const auto add_point = [&](std::size_t row, Vec2 p) { terrain_points[tile_at(p)][row].push_back(snap_to_grid(p)); };
  walk_borders(roads.outline(), window.box, verge_point_step_m, [&](Vec2 p, Vec2 outwards) {
    constexpr std::array<double, 3> shares = {0.25, 0.6, 1.0};
    for (std::size_t row = 0; row < shares.size(); ++row) {
      const Vec2 q = p + outwards * (shares[row] * options.verge_m);
      if (roads.outline().nearest(q).distance_m > 0.95 * shares[row] * options.verge_m) add_point(row, q);
    }
  });
  constexpr std::size_t below_decks = 3;
  for (std::size_t d = 0; d < decks.size(); ++d) {
    walk_borders(decks[d].outline(), window.box, 0.5 * verge_point_step_m, [&](Vec2 p, Vec2 outwards) {
      add_point(below_decks, p);
      add_point(below_decks, p + outwards * options.verge_m);
    });
    for (const std::vector<CrossSection>& strip : decks[d].strips())
      for (const CrossSection& section : strip) add_point(below_decks, {section.reference.x, section.reference.y});
  }
}

}  // namespace orthodrive
