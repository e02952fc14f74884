// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/scene/tiles/scene_frame.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "orthodrive/core/error.hpp"
#include "orthodrive/geo/overlay.hpp"
#include "orthodrive/scene/ground/photo_shadows.hpp"
#include "orthodrive/scene/plan/plan_grid.hpp"
#include "orthodrive/scene/plan/tile_address.hpp"
#include "orthodrive/scene/roads/crossing_roads.hpp"

namespace orthodrive::scene {
namespace {

constexpr double area_reach_m = 2.0;
constexpr double least_terrain_step_m = 4.0;

void check(const SceneSource& source, const SceneOptions& options) {
  const bool is_block = options.block_tiles > 0 && (options.block_tiles & (options.block_tiles - 1)) == 0;
  if (!(options.road_tolerance_m > 0.0 && options.terrain_step_m >= least_terrain_step_m && options.verge_m > 0.0 &&
        options.deck_thickness_m > 0.0 && options.max_texture_px > 0 && is_block))
    throw OptionError(
        "scene: tolerance, verge, deck thickness and texture size must be positive, the step at least 4 m, tiles of a "
        "block a power of two");
  if (source.area.outer.size() < 3) throw OptionError("scene: needs an area");
}

Polygon on_grid(Polygon polygon) {
  const auto snap = [](Ring& ring) {
    for (Vec2& p : ring) p = snap_to_grid(p);
  };
  snap(polygon.outer);
  for (Ring& hole : polygon.holes) snap(hole);
  return polygon;
}

MultiPolygon densified(const Polygon& area, double step_m) {
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

/// Where a segment crosses the borders of tiles, as shares of its length, with both ends.
std::vector<double> crossings(Vec2 a, Vec2 b) {
  std::vector<double> shares = {0.0, 1.0};
  const auto add = [&](double from, double to) {
    const auto [low, high] = std::minmax(from, to);
    for (double line = (std::floor(low / scene_tile_m) + 1.0) * scene_tile_m; line < high; line += scene_tile_m)
      shares.push_back((line - from) / (to - from));
  };
  add(a.x, b.x), add(a.y, b.y);
  std::ranges::sort(shares);
  return shares;
}

/// Those that the border passes through, and those whose middle lies inside.
std::vector<TileAddress> tiles_of(const Outline& outline, const Box2& bounds) {
  std::set<TileAddress> tiles;
  const auto is_border = [](double v) { return std::fmod(v, scene_tile_m) == 0.0; };  // exact on the plan grid
  for (const auto& [a, b, az, bz] : outline.segments()) {
    if ((a.x == b.x && is_border(a.x)) || (a.y == b.y && is_border(a.y))) continue;
    const std::vector<double> shares = crossings(a, b);
    for (std::size_t i = 1; i < shares.size(); ++i)
      tiles.insert(tile_at(a + (b - a) * (0.5 * (shares[i - 1] + shares[i]))));
  }
  const TileAddress first = tile_at({bounds.min_x, bounds.min_y}), last = tile_at({bounds.max_x, bounds.max_y});
  for (int c = first.column; c <= last.column; ++c)
    for (int r = first.row; r <= last.row; ++r)
      if (outline.contains({(c + 0.5) * scene_tile_m, (r + 0.5) * scene_tile_m})) tiles.insert({c, r});
  return {tiles.begin(), tiles.end()};
}

}  // namespace

SceneFrame::SceneFrame(const SceneSource& source, const SceneOptions& scene_options) : options(scene_options) {
  check(source, options);
  photo = source.photo;
  if (source.labels)
    if (auto shadows = find_shadows(photo, *source.labels, options.threads))
      photo = without_shadows(source.photo, *source.labels, std::move(*shadows));
  area = on_grid(source.area);
  dense_area = densified(area, options.terrain_step_m);
  bounds = bounds_of(area.outer);
  outline = Outline(dense_area, area_reach_m);
  tiles = tiles_of(outline, bounds);
  terrain = std::make_unique<const TerrainWindows>(source.terrain, outline, findings);
  if (source.surroundings) {
    water_levels = scene::water_levels(source.surroundings->water, outline, *terrain, photo, findings);
    for (const MapPowerLine& line : source.surroundings->power_lines) {
      std::vector<double>& ground_m = power_ground_m.emplace_back();
      for (const Vec2 p : line.line) ground_m.push_back(outline.contains(p) ? terrain->height_m(p) : 0.0);
    }
  }
  const std::vector<bool> is_over = lying_over(source.roads.roads);
  for (std::size_t i = 0; i < is_over.size(); ++i)
    if (is_over[i]) roads_over.insert(source.roads.roads[i].id);
  const Vec2 middle{std::round(0.5 * (bounds.min_x + bounds.max_x)), std::round(0.5 * (bounds.min_y + bounds.max_y))};
  origin = {middle.x, middle.y, std::floor(terrain->height_m(middle))};
}

}  // namespace orthodrive::scene
