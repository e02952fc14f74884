// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/synth/make_region.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>

#include "orthodrive/core/error.hpp"
#include "orthodrive/core/noise.hpp"
#include "orthodrive/core/parallel.hpp"
#include "orthodrive/core/random.hpp"
#include "orthodrive/synth/disturb_osm.hpp"
#include "orthodrive/synth/paint/paint_ortho.hpp"
#include "orthodrive/synth/plan/plan_index.hpp"
#include "orthodrive/synth/true_surfaces.hpp"

namespace orthodrive {
namespace {
using namespace synth;

constexpr double cell_m = 512.0;          // objects are placed cell by cell
constexpr double object_reach_m = 64.0;   // gardens and crowns reach so far beyond their cell
constexpr double samples_reach_m = 30.0;  // sampled roads end so far outside a window that nothing shows it

struct Region {
  const SynthOptions& options;
  SitePlan plan;
  Terrain terrain;
  PlanIndex index;
  GridFrame photo_frame, earth_frame;  ///< local metres
};

GridFrame window_of(const GridFrame& grid, const PixelBox& box) {
  GridFrame frame = grid;
  frame.first_col = static_cast<int>(box.col), frame.first_row = static_cast<int>(box.row);
  frame.width = box.width, frame.height = box.height;
  return frame;
}

/// The pixels of a grid that touch a box.
PixelBox pixels_over(const GridFrame& grid, const Box2& box) {
  const Vec2 low = grid.pixel_from_world({box.min_x, box.max_y}), high = grid.pixel_from_world({box.max_x, box.min_y});
  const auto col = static_cast<std::int64_t>(std::floor(low.x)), row = static_cast<std::int64_t>(std::floor(low.y));
  return {col, row, static_cast<int>(static_cast<std::int64_t>(std::ceil(high.x)) - col),
          static_cast<int>(static_cast<std::int64_t>(std::ceil(high.y)) - row)};
}

BareEarth earth_of(const Region& region, const GridFrame& frame) {
  return make_bare_earth(region.plan, region.terrain, region.index.stretches(frame.bounds().grown(max_clearance_m)),
                         frame, 1);
}

/// Objects by cell: made when a row of tiles needs them, and dropped behind it.
class ObjectCells {
 public:
  explicit ObjectCells(const Region& region)
      : region_(region), count_(static_cast<int>(std::ceil(region.plan.size_m / cell_m))) {}

  /// Keeps those that touch the box, and no others. Boxes come from north to south.
  void move_to(const Box2& box) {
    std::erase_if(cells_, [&](const auto& cell) { return !box_of(cell.first).overlaps(box); });
    std::vector<int> missing;
    for (int number = 0; number < count_ * count_; ++number)
      if (box_of(number).overlaps(box) && !cells_.contains(number)) missing.push_back(number);
    std::vector<SiteObjects> made(missing.size());
    parallel_for(missing.size(), region_.options.threads, [&](std::size_t i) { made[i] = place(missing[i]); });
    for (std::size_t i = 0; i < missing.size(); ++i) {
      houses_[missing[i]] = made[i].houses;
      cells_[missing[i]] = std::move(made[i]);
    }
  }

  /// What may show in a window, by cell.
  [[nodiscard]] SiteObjects near(const Box2& window) const {
    SiteObjects all;
    for (const std::size_t i : region_.index.areas(window)) all.areas.push_back(region_.plan.areas[i]);
    for (const auto& [number, cell] : cells_) {
      if (!box_of(number).grown(object_reach_m).overlaps(window)) continue;
      for (const Area& area : cell.areas)
        if (bounds_of(area.polygon.outer).overlaps(window)) all.areas.push_back(area);
      const Box2 reach = window.grown(object_reach_m);
      for (const House& house : cell.houses)
        if (reach.contains(house.center)) all.houses.push_back(house);
      for (const Tree& tree : cell.trees)
        if (reach.contains(tree.center)) all.trees.push_back(tree);
      for (const Car& car : cell.cars)
        if (reach.contains(car.center)) all.cars.push_back(car);
    }
    if (all.areas.size() > std::numeric_limits<std::uint16_t>::max())
      throw OptionError("tile_px is too large: a tile has more than 65535 areas");
    return all;
  }

  /// Of all cells so far.
  [[nodiscard]] std::vector<House> houses() const {
    std::vector<House> all;
    for (const auto& [number, houses] : houses_) all.insert(all.end(), houses.begin(), houses.end());
    return all;
  }

 private:
  [[nodiscard]] Box2 box_of(int number) const {
    const auto column = number % count_, row = number / count_;
    const double size = region_.plan.size_m, x = column * cell_m, y = row * cell_m;
    return {x, y, std::min(size, x + cell_m), std::min(size, y + cell_m)};
  }
  [[nodiscard]] SiteObjects place(int number) const {
    constexpr double margin_m = 4.0;
    const Box2 box = box_of(number);
    const GridFrame frame = window_of(region_.earth_frame, pixels_over(region_.earth_frame, box.grown(margin_m)));
    const ObjectCell cell{box, region_.index.stretches(box.grown(samples_reach_m)), region_.index.areas(box),
                          derive_seed(derive_seed(region_.options.seed, 3), static_cast<std::uint64_t>(number))};
    return place_cell_objects(region_.plan, cell, earth_of(region_, frame).clearance_m, frame);
  }

  const Region& region_;
  int count_;  ///< along an edge
  std::map<int, SiteObjects> cells_;
  std::map<int, std::vector<House>> houses_;
};

template <typename T>
Raster<T> cropped(const Raster<T>& raster, int first_col, int first_row, int width, int height) {
  Raster<T> part(width, height);
  for (int row = 0; row < height; ++row) std::copy_n(&raster.at(first_col, first_row + row), width, &part.at(0, row));
  return part;
}

/// The pixels that a picture needs: those of its shadows, too, which fall northwards.
GridFrame scene_frame(const Region& region, const PixelBox& box) {
  const int reach_px = static_cast<int>(std::ceil(shadow_reach_m / region.photo_frame.gsd_m)) + 2;
  constexpr int north_px = 2;  // the optics blur by a pixel, whose own slope takes another
  return window_of(region.photo_frame, {box.col - reach_px, box.row - north_px, box.width + 2 * reach_px,
                                        box.height + north_px + reach_px});
}

RegionPicture paint(const Region& region, const ObjectCells& cells, const PixelBox& box) {
  const GridFrame frame = scene_frame(region, box);
  const Box2 window = frame.bounds();
  constexpr double margin_m = 4.0;  // heights are interpolated, slopes are differences
  const GridFrame earth_frame = window_of(region.earth_frame, pixels_over(region.earth_frame, window.grown(margin_m)));
  const BareEarth earth = earth_of(region, earth_frame);
  const SiteObjects objects = cells.near(window);
  const std::vector<RoadSample> samples =
      sample_roads(region.plan, region.terrain, region.index.stretches(window.grown(samples_reach_m)), 1.0);
  const SceneSource source{region.plan, samples,     objects,
                           earth,       earth_frame, static_cast<std::uint32_t>(derive_seed(region.options.seed, 7))};
  const SceneRaster scene = rasterize_scene(source, frame, 1);
  RegionPicture picture{box, paint_ortho(source, scene, box, 1), {}};
  picture.labels = cropped(label_scene(source, scene, 1), static_cast<int>(box.col) - frame.first_col,
                           static_cast<int>(box.row) - frame.first_row, box.width, box.height);
  return picture;
}

/// Standard normal, a pure function of place (Box-Muller).
double normal_at(std::int64_t col, std::int64_t row, std::uint64_t seed) {
  const auto x = static_cast<std::int32_t>(col), y = static_cast<std::int32_t>(row);
  const auto layer = static_cast<std::uint32_t>(seed);
  const double u = 1.0 - unit_hash(x, y, layer), v = unit_hash(x, y, layer + 1);
  return std::sqrt(-2.0 * std::log(u)) * std::cos(2.0 * std::numbers::pi * v);
}

constexpr int coarse_cell = 10;  // pixels of the finer terrain model along one of the coarser

RegionHeights measure_heights(const Region& region, const PixelBox& box) {
  const SynthOptions& o = region.options;
  RegionHeights heights{
      box,
      {box.col / coarse_cell, box.row / coarse_cell, box.width / coarse_cell, box.height / coarse_cell},
      earth_of(region, window_of(region.earth_frame, box)).height_m,
      Raster<float>(box.width, box.height),
      Raster<float>(box.width / coarse_cell, box.height / coarse_cell)};
  const std::uint64_t fine_seed = derive_seed(o.seed, 8), coarse_seed = derive_seed(o.seed, 9);
  for (int row = 0; row < box.height; ++row)
    for (int col = 0; col < box.width; ++col)
      heights.dtm_1m.at(col, row) = static_cast<float>(
          heights.true_1m.at(col, row) + o.dtm_1m_sigma_m * normal_at(box.col + col, box.row + row, fine_seed));
  for (int row = 0; row < heights.box_10m.height; ++row)
    for (int col = 0; col < heights.box_10m.width; ++col) {
      double sum = 0.0;
      for (int j = 0; j < coarse_cell; ++j)
        for (int i = 0; i < coarse_cell; ++i) sum += heights.true_1m.at(col * coarse_cell + i, row * coarse_cell + j);
      const double noise = normal_at(heights.box_10m.col + col, heights.box_10m.row + row, coarse_seed);
      heights.dtm_10m.at(col, row) = static_cast<float>(sum / (coarse_cell * coarse_cell) + o.dtm_10m_sigma_m * noise);
    }
  return heights;
}

/// Tiles of a grid, row by row from the north.
std::vector<std::vector<PixelBox>> tile_rows(const GridFrame& grid, int tile_px) {
  std::vector<std::vector<PixelBox>> rows;
  for (std::int64_t row = 0; row < grid.height; row += tile_px) {
    rows.emplace_back();
    for (std::int64_t col = 0; col < grid.width; col += tile_px)
      rows.back().push_back(intersection({col, row, tile_px, tile_px}, pixels_of(grid)));
  }
  return rows;
}

/// Calls make for the tiles of a row on all threads, then take for one after the other.
template <typename Tile, typename Make, typename Take>
void for_row(const std::vector<PixelBox>& row, int threads, const Make& make, const Take& take) {
  const auto at_once = static_cast<std::size_t>(worker_count(threads));
  for (std::size_t first = 0; first < row.size(); first += at_once) {
    std::vector<Tile> made(std::min(at_once, row.size() - first));
    parallel_for(made.size(), threads, [&](std::size_t i) { made[i] = make(row[first + i]); });
    for (const Tile& tile : made) take(tile);
  }
}

void stream_heights(const Region& region, const RegionSink& sink) {
  const int tile_px = std::max(
      coarse_cell, static_cast<int>(region.options.tile_px * region.photo_frame.gsd_m) / coarse_cell * coarse_cell);
  for (const std::vector<PixelBox>& row : tile_rows(region.earth_frame, tile_px))
    for_row<RegionHeights>(
        row, region.options.threads, [&](const PixelBox& box) { return measure_heights(region, box); }, sink.heights);
}

/// Also counts what is seen of the carriageways.
void stream_pictures(const Region& region, ObjectCells& cells, std::vector<SynthSurface>& surfaces,
                     const RegionSink& sink, const std::function<void(double)>& report) {
  const GridFrame site_frame = region_frames(region.plan, region.options).photo;
  std::vector<SeenPixels> seen(surfaces.size());
  std::vector<Box2> boxes;
  boxes.reserve(surfaces.size());
  for (const SynthSurface& surface : surfaces) boxes.push_back(bounds_of(surface.polygon.outer));
  const SpatialIndex index(boxes);
  const auto rows = tile_rows(region.photo_frame, region.options.tile_px);
  double rows_done = 0.0;
  for (const std::vector<PixelBox>& row : rows) {
    Box2 strip = scene_frame(region, row.front()).bounds();
    strip.max_x = scene_frame(region, row.back()).bounds().max_x;
    cells.move_to(strip.grown(object_reach_m));
    for_row<RegionPicture>(
        row, region.options.threads, [&](const PixelBox& box) { return paint(region, cells, box); },
        [&](const RegionPicture& picture) {
          const GridFrame frame = window_of(site_frame, picture.box);
          for (const std::uint32_t i : index.touching(frame.bounds()))
            seen[i].count(surfaces[i].polygon, picture.labels, frame, default_class_table());
          sink.picture(picture);
        });
    report(++rows_done / static_cast<double>(rows.size()));
  }
  for (std::size_t i = 0; i < surfaces.size(); ++i) surfaces[i].visibility = seen[i].share();
}

}  // namespace

RegionFrames region_frames(const SitePlan& plan, const SynthOptions& options) {
  check_synth_options(options);
  if (options.tile_px < 16 || options.tile_px > 8192)
    throw OptionError(fmt::format("tile_px is {}, need 16 to 8192", options.tile_px));
  if (!options.world.empty()) throw OptionError("sites that are made tile by tile have no worlds: leave out --world");
  if (options.textures)
    throw OptionError("sites that are made tile by tile have no textures of photos: leave out --textures");
  if (options.classes)
    throw OptionError("sites that are made tile by tile have the default classes: leave out --classes");
  const Vec2 corner = plan.world_from_local;
  const double size = plan.size_m;
  const int photo_px = static_cast<int>(std::ceil(size / options.gsd_m - 1e-6));
  const int earth_px = static_cast<int>(size + 2.0 * dtm_margin_m);
  const double west = corner.x - dtm_margin_m, north = corner.y + size + dtm_margin_m;
  return {{corner.x, corner.y + size, options.gsd_m, photo_px, photo_px},
          {west, north, 1.0, earth_px, earth_px},
          {west, north, 1.0 * coarse_cell, earth_px / coarse_cell, earth_px / coarse_cell}};
}

SynthSite make_region(SitePlan plan, const SynthOptions& options, const RegionSink& sink, Monitor* monitor) {
  const RegionFrames frames = region_frames(plan, options);
  const auto report = [&](double fraction) {
    if (monitor) monitor->progress(fraction, "synth");
  };
  Terrain terrain = make_terrain(plan, options.seed);
  PlanIndex index(plan);
  const auto local = [&](GridFrame frame) {
    frame.west_m -= plan.world_from_local.x, frame.north_m -= plan.world_from_local.y;
    return frame;
  };
  const GridFrame photo_frame = local(frames.photo), earth_frame = local(frames.dtm_1m);
  const Region region{options, std::move(plan), std::move(terrain), std::move(index), photo_frame, earth_frame};
  report(0.05);

  SynthSite site;
  site.name = site_name(region.plan, options.seed);
  site.crs = {"EPSG:32633"};
  site.bounds = {region.plan.world_from_local.x, region.plan.world_from_local.y,
                 region.plan.world_from_local.x + region.plan.size_m,
                 region.plan.world_from_local.y + region.plan.size_m};
  site.route_closed = region.plan.circuit.has_value();
  site.route_name = site.route_closed ? region.plan.roads[*region.plan.circuit].name : region.plan.route;
  const std::vector<PlannedWay> ways = plan_ways(region.plan);
  const DisturbOptions disturb{options.osm_offset_min_m, options.osm_offset_max_m, options.seed};
  // The truth knows how far OSM's lines lie from it; buildings follow when all cells have theirs.
  site.roads = true_roads(region.plan, region.terrain, ways, disturb_osm(region.plan, ways, {}, disturb));
  for (RoadPath& path : site.roads.paths)
    for (RoadNode& node : path.nodes) node.p = node.p + region.plan.world_from_local;
  site.roads.crs = site.crs;
  site.surfaces = true_surfaces(site.roads);

  stream_heights(region, sink);
  report(0.2);
  ObjectCells cells(region);
  stream_pictures(region, cells, site.surfaces, sink, [&](double done) { report(0.2 + 0.75 * done); });

  site.osm = disturb_osm(region.plan, ways, {cells.houses(), {}, {}, region.plan.areas}, disturb);
  for (OsmNode& node : site.osm.nodes) node.p = node.p + region.plan.world_from_local;
  site.osm.crs = site.crs;
  report(1.0);
  return site;
}

}  // namespace orthodrive
