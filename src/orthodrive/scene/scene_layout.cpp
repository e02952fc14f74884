#include "orthodrive/scene/scene_layout.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <set>

#include "orthodrive/core/error.hpp"
#include "orthodrive/core/parallel.hpp"
#include "orthodrive/scene/crossing_roads.hpp"
#include "orthodrive/scene/label_footprints.hpp"
#include "orthodrive/scene/road_paint.hpp"
#include "roadquery/road_surface.hpp"

namespace orthodrive {
namespace scene {
namespace {

constexpr double area_reach_m = 2.0;
constexpr double verge_point_step_m = 5.0;
constexpr double deck_gap_m = 0.3;        // between the underside of a deck and the terrain
constexpr double min_ridge_edge_m = 1.0;  // shorter edges of a crown's ridge are not worth their triangles

Polygon on_grid(Polygon polygon) {
  const auto snap = [](Ring& ring) {
    for (Vec2& p : ring) p = snap_to_grid(p);
  };
  snap(polygon.outer);
  for (Ring& hole : polygon.holes) snap(hole);
  return polygon;
}

/// The area's rings with points at most `step_m` apart, oriented and clean.
MultiPolygon dense_area(const Polygon& area, double step_m) {
  MultiPolygon result = union_of(std::span(&area, 1), plan_grid_m);
  const auto densify = [&](Ring& ring) {
    Ring dense;
    for (std::size_t i = 0; i < ring.size(); ++i) {
      const Vec2 a = ring[i], b = ring[(i + 1) % ring.size()];
      const int parts = std::max(1, static_cast<int>(std::ceil(distance(a, b) / step_m)));
      for (int k = 0; k < parts; ++k) dense.push_back(snap_to_grid(a + (b - a) * (static_cast<double>(k) / parts)));
    }
    ring = std::move(dense);
  };
  for (Polygon& polygon : result) {
    densify(polygon.outer);
    for (Ring& hole : polygon.holes) densify(hole);
  }
  return result;
}

void append_rings(const MultiPolygon& polygons, std::vector<Polyline>& lines) {
  const auto add = [&](const Ring& ring) {
    lines.push_back(ring);
    lines.back().push_back(ring.front());
  };
  for (const Polygon& polygon : polygons) {
    add(polygon.outer);
    for (const Ring& hole : polygon.holes) add(hole);
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
  for (const LineSegment& segment : node_lines(lines, plan_grid_m)) {
    for (const Vec2 p : {segment.a, segment.b}) {
      if (on_line(p.x)) result.on_west[static_cast<int>(p.x / scene_tile_m)].push_back(p.y);
      if (on_line(p.y)) result.on_south[static_cast<int>(p.y / scene_tile_m)].push_back(p.x);
    }
    const bool along_border =
        (segment.a.x == segment.b.x && on_line(segment.a.x)) || (segment.a.y == segment.b.y && on_line(segment.a.y));
    if (!along_border) result.inside[tile_at((segment.a + segment.b) * 0.5)].push_back(segment);
  }
  for (auto* side : {&result.on_west, &result.on_south}) {
    for (auto& [index, values] : *side) {
      std::sort(values.begin(), values.end());
      values.erase(std::unique(values.begin(), values.end()), values.end());
    }
  }
  return result;
}

/// From the reference line to the nearer edge.
double free_beside_m(const CrossSection& section) {
  const Vec2 middle{section.reference.x, section.reference.y};
  return std::min(distance(middle, {section.left.x, section.left.y}),
                  distance(middle, {section.right.x, section.right.y}));
}

void add_axis_points(const RoadLevel& level, LevelLines& lines) {
  const auto add = [&](Vec2 p) {
    p = snap_to_grid(p);
    lines.axis_points[tile_at(p)].push_back(p);
  };
  for (std::size_t i = 0; i < level.strips().size(); ++i) {
    const roadquery::Road& road = *level.roads()[i];
    const std::vector<CrossSection>& strip = level.strips()[i];
    for (std::size_t k = 0; k < strip.size(); ++k) {
      if (k > 0 && !road.shape.empty()) {
        // A crown has its ridge on the reference line, which must be edges of the mesh: they are in any Delaunay
        // triangulation when the circles over them are empty (Gabriel and Sokal 1969), so they are no longer than the
        // way to the road's edges.
        const double free_m = std::min(free_beside_m(strip[k - 1]), free_beside_m(strip[k]));
        const double length_m = strip[k].s_m - strip[k - 1].s_m;
        const int parts = free_m > min_ridge_edge_m ? static_cast<int>(std::ceil(length_m / free_m)) : 1;
        for (int j = 1; j < parts; ++j) {
          const auto q = roadquery::reference_point(road, strip[k - 1].s_m + length_m * j / parts);
          add({q.x, q.y});
        }
      }
      add({strip[k].reference.x, strip[k].reference.y});
    }
  }
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
void add_kerbs(const RoadLevel& level, const roadquery::RoadQuery& query, const roadquery::RoadMap& raised,
               LevelLines& lines) {
  for (const roadquery::Road* road : level.roads())
    for (const KerbPiece& piece : kerb_pieces(raised.roads[static_cast<std::size_t>(road - query.map().roads.data())]))
      visit_tiles(piece.corners, [&](TileAddress address) { lines.kerbs[address].push_back(piece); });
}

roadquery::RoadMap without_heights(roadquery::RoadMap map) {
  for (roadquery::Road& road : map.roads)
    for (roadquery::LaneSection& section : road.sections)
      for (auto* side : {&section.left, &section.right})
        for (roadquery::Lane& lane : *side) lane.heights.clear();
  return map;
}

void add_markings(const RoadLevel& level, LevelLines& lines) {
  for (const roadquery::Road* road : level.roads()) {
    std::vector<MarkingPiece> pieces = road_markings(*road);
    std::ranges::move(road_paint(*road), std::back_inserter(pieces));
    for (const MarkingPiece& piece : pieces)
      visit_tiles(piece, [&](TileAddress address) { lines.markings[address].push_back(piece); });
  }
}

/// Calls visit(p, outwards) every `step_m` along the borders.
template <typename Visit>
void walk_borders(const Outline& outline, double step_m, const Visit& visit) {
  double to_next_m = 0.0;
  for (const BorderSegment& segment : outline.segments()) {
    const double length_m = distance(segment.a, segment.b);
    const Vec2 along = normalized(segment.b - segment.a);
    for (; to_next_m < length_m; to_next_m += step_m) visit(segment.a + along * to_next_m, left_normal(along) * -1.0);
    to_next_m -= length_m;
  }
}

}  // namespace

Box2 tile_box(TileAddress a) {
  return {a.column * scene_tile_m, a.row * scene_tile_m, (a.column + 1) * scene_tile_m, (a.row + 1) * scene_tile_m};
}

TileAddress tile_at(Vec2 p) {
  return {static_cast<int>(std::floor(p.x / scene_tile_m)), static_cast<int>(std::floor(p.y / scene_tile_m))};
}

}  // namespace scene

using namespace scene;

namespace {

struct SortedRoads {
  std::vector<const roadquery::Road*> ground;
  std::vector<std::vector<const roadquery::Road*>> decks, tunnels;
};

SortedRoads sort_roads(const roadquery::RoadQuery& query, Findings& findings) {
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
    if (road.tunnel) {
      tunnels[std::min(-1, road.layer)].push_back(&road);
    } else {
      const bool is_deck = road.bridge || road.layer > 0;
      (is_deck ? decks[std::max(1, road.layer)] : sorted.ground).push_back(&road);
    }
  }
  const auto tell_apart = [](const auto& by_layer, auto& sets) {
    for (const auto& [layer, of_layer] : by_layer) std::ranges::move(told_apart(of_layer), std::back_inserter(sets));
  };
  tell_apart(decks, sorted.decks);
  tell_apart(tunnels, sorted.tunnels);
  return sorted;
}

/// Holes outside the area (terrain models end somewhere) are nobody's business.
HeightGrid filled_terrain(const HeightGrid& terrain, const Outline& area, Findings& findings) {
  std::size_t holes = 0;
  Vec2 sum;
  for (int row = 0; row < terrain.frame.height; ++row) {
    for (int col = 0; col < terrain.frame.width; ++col) {
      const Vec2 p = terrain.frame.center_of(col, row);
      if (!std::isnan(terrain.height_m.at(col, row)) || !area.contains(p)) continue;
      ++holes, sum = sum + p;
    }
  }
  if (holes > 0) {
    const double n = static_cast<double>(holes), hole_m2 = n * terrain.frame.gsd_m * terrain.frame.gsd_m;
    findings.push_back(
        {Severity::warning, "scene.terrain_hole",
         fmt::format("{:.0f} m2 of the terrain model have no height and were filled from around", hole_m2), sum.x / n,
         sum.y / n});
  }
  HeightGrid filled = terrain;
  fill_holes(filled.height_m);
  if (filled.height_m.empty() || std::isnan(filled.height_m.data.front()))
    throw InputError("terrain model", "has no height anywhere, give a DTM that covers the area");
  return filled;
}

}  // namespace

SceneLayout::SceneLayout(const SceneInput& input, const SceneOptions& scene_options)
    : options(scene_options), photo(&input.photo), labels(input.labels) {
  std::vector<Building> known(input.buildings.begin(), input.buildings.end());
  std::vector<TreeCrown> crowns;
  const auto read_labels = [&] {  // needs no roads
    if (labels == nullptr) return;
    std::ranges::move(footprints_of_labels(*labels, input.buildings), std::back_inserter(known));
    crowns = find_crowns(*labels, input.photo);
  };
  parallel_for(2, options.threads, [&](std::size_t task) { task == 0 ? lay_roads(input) : read_labels(); });

  std::vector<const RoadLevel*> levels = {&roads};
  for (const RoadLevel& deck : decks) levels.push_back(&deck);
  buildings = place_buildings(known, levels, area, *ground, input.photo, options.threads, findings);
  for (const PlacedBuilding& building : buildings) buildings_in[tile_at(building.middle)].push_back(&building);
  const FreeSpace space({levels, buildings, area, openings});
  trees = plant_trees(crowns, input.trees, space, *ground, input.photo, options.threads);
  for (const PlacedTree& tree : trees) trees_in[tile_at({tree.foot.x, tree.foot.y})].push_back(&tree);
  if (input.surroundings) add_surroundings(*input.surroundings, space);
  choose_tiles(bounds_of(input.area.outer));
  add_terrain_points();
}

void SceneLayout::add_surroundings(const MapSurroundings& surroundings, const FreeSpace& space) {
  ObjectFaces standing = object_faces(surroundings, {roads, *query, space, *ground});
  std::vector<StructureFace> lasting = barrier_faces(surroundings.barriers, space, *ground);
  std::ranges::move(standing.large, std::back_inserter(lasting));
  barriers = by_tile(std::move(lasting));
  objects = by_tile(std::move(standing.small));
  tracks = by_tile(track_faces(surroundings.tracks, space, *ground));
  lamps = place_lamps(surroundings.lamps, roads, space, *ground);
  for (const PlacedLamp& lamp : lamps) lamps_in[tile_at({lamp.foot.x, lamp.foot.y})].push_back(&lamp);
}

const RoadLevel& SceneLayout::level(int number) const {
  if (number == 0) return roads;
  const auto above = static_cast<std::size_t>(number) - 1;
  return above < decks.size() ? decks[above] : tunnels[above - decks.size()];
}

void SceneLayout::lay_levels(const SceneInput& input, const Polygon& site_area) {
  query = std::make_shared<const roadquery::RoadQuery>(without_heights(input.roads));
  const SortedRoads sorted = sort_roads(*query, findings);
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
  roads = RoadLevel(sorted.ground, site_area, level_options);
  for (const auto& of_level : sorted.decks) decks.emplace_back(of_level, site_area, level_options);
  for (const auto& of_level : sorted.tunnels) tunnels.emplace_back(of_level, site_area, level_options);
}

/// Adds the openings' borders to the lines of the ground.
void SceneLayout::lay_tunnels(const MultiPolygon& area_polygons, std::vector<Polyline>& lines) {
  Tunnels built = build_tunnels({roads, tunnels, *ground, *query, joints, area}, area_polygons);
  append_rings(built.openings, lines);
  openings = Outline(built.openings, tree_reach_m);
  tubes = by_tile(std::move(built.faces));
  for (const Vec2 p : built.ground_points) terrain_points[tile_at(p)].push_back(snap_to_grid(p));
  std::ranges::move(built.findings, std::back_inserter(findings));
}

void SceneLayout::lay_roads(const SceneInput& input) {
  const Polygon site_area = on_grid(input.area);
  const MultiPolygon area_polygons = dense_area(site_area, options.terrain_step_m);
  area = Outline(area_polygons, area_reach_m);
  const Box2 bounds = bounds_of(input.area.outer);

  lay_levels(input, site_area);
  HeightGrid terrain = filled_terrain(input.terrain, area, findings);
  if (input.surroundings)
    waters = Waters(input.surroundings->water, {roads, terrain, input.photo, site_area, options.verge_m}, findings);
  ground.emplace(std::move(terrain), roads, decks, waters,
                 GroundOptions{.verge_m = options.verge_m, .deck_clearance_m = options.deck_thickness_m + deck_gap_m});
  const Vec2 middle{std::round(0.5 * (bounds.min_x + bounds.max_x)), std::round(0.5 * (bounds.min_y + bounds.max_y))};
  origin = {middle.x, middle.y, std::floor(ground->terrain_m(middle))};

  std::vector<Polyline> lines;
  append_rings(area_polygons, lines);
  append_rings(roads.polygons(), lines);
  for (const WaterBody& body : waters.bodies()) append_rings(body.shores, lines);
  lay_tunnels(area_polygons, lines);
  ground_lines = cut_at_tiles(std::move(lines), bounds);
  add_axis_points(roads, ground_lines);
  add_markings(roads, ground_lines);
  add_kerbs(roads, *query, input.roads, ground_lines);
  const auto add_lines = [&](const RoadLevel& level, std::vector<LevelLines>& of_levels) {
    lines.clear();
    append_rings(level.polygons(), lines);
    LevelLines& own = of_levels.emplace_back(cut_at_tiles(std::move(lines), bounds));
    add_axis_points(level, own);
    add_markings(level, own);
    add_kerbs(level, *query, input.roads, own);
  };
  for (const RoadLevel& deck : decks) add_lines(deck, deck_lines);
  for (const RoadLevel& tunnel : tunnels) add_lines(tunnel, tunnel_lines);
  structures = by_tile(build_structures({roads, decks, *ground, *query, options.deck_thickness_m}));
  std::vector<const RoadLevel*> levels = {&roads};
  for (const RoadLevel& deck : decks) levels.push_back(&deck);
  tint = RoadTint(levels, input.photo);
}

/// Those that the area's border passes through, and those whose middle lies inside.
void SceneLayout::choose_tiles(const Box2& bounds) {
  std::set<TileAddress> inside;
  for (const auto& [address, segments] : ground_lines.inside) inside.insert(address);
  const TileAddress first = tile_at({bounds.min_x, bounds.min_y}), last = tile_at({bounds.max_x, bounds.max_y});
  for (int c = first.column; c <= last.column; ++c)
    for (int r = first.row; r <= last.row; ++r)
      if (area.contains({(c + 0.5) * scene_tile_m, (r + 0.5) * scene_tile_m})) inside.insert({c, r});
  tiles.assign(inside.begin(), inside.end());
}

/// Terrain vertices beside roads and below decks.
void SceneLayout::add_terrain_points() {
  const auto add_terrain_point = [&](Vec2 p) { terrain_points[tile_at(p)].push_back(snap_to_grid(p)); };
  walk_borders(roads.outline(), verge_point_step_m, [&](Vec2 p, Vec2 outwards) {
    for (const double share : {0.25, 0.6, 1.0}) {
      const Vec2 q = p + outwards * (share * options.verge_m);
      if (roads.outline().nearest(q).distance_m > 0.95 * share * options.verge_m) add_terrain_point(q);
    }
  });
  for (std::size_t d = 0; d < decks.size(); ++d) {
    walk_borders(decks[d].outline(), 0.5 * verge_point_step_m, [&](Vec2 p, Vec2 outwards) {
      add_terrain_point(p);
      add_terrain_point(p + outwards * options.verge_m);
    });
    for (const auto& [address, points] : deck_lines[d].axis_points)
      for (const Vec2 p : points) add_terrain_point(p);
  }
}

}  // namespace orthodrive
