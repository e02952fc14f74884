// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/synth/make_site.hpp"

#include <fmt/format.h>

#include <cmath>
#include <functional>
#include <optional>

#include "orthodrive/core/error.hpp"
#include "orthodrive/core/parallel.hpp"
#include "orthodrive/core/random.hpp"
#include "orthodrive/synth/disturb_osm.hpp"
#include "orthodrive/synth/ground/landmarks.hpp"
#include "orthodrive/synth/paint/label_classes.hpp"
#include "orthodrive/synth/paint/paint_ortho.hpp"
#include "orthodrive/synth/paint/world.hpp"
#include "orthodrive/synth/plan/plan_presets.hpp"
#include "orthodrive/synth/true_surfaces.hpp"

namespace orthodrive {
namespace {
using namespace synth;

GridFrame moved(GridFrame frame, Vec2 world_from_local) {
  frame.west_m += world_from_local.x, frame.north_m += world_from_local.y;
  return frame;
}

/// Means over `cell` x `cell` pixels plus normal noise.
HeightGrid noisy_dtm(const HeightGrid& truth, int cell, double sigma_m, std::uint64_t seed) {
  HeightGrid grid{truth.crs, truth.frame, {}, truth.vertical_datum};
  grid.frame.gsd_m *= cell, grid.frame.width /= cell, grid.frame.height /= cell;
  grid.height_m = Raster<float>(grid.frame.width, grid.frame.height);
  Random random(seed);
  for (int row = 0; row < grid.frame.height; ++row)
    for (int col = 0; col < grid.frame.width; ++col) {
      double sum = 0.0;
      for (int j = 0; j < cell; ++j)
        for (int i = 0; i < cell; ++i) sum += truth.height_m.at(col * cell + i, row * cell + j);
      grid.height_m.at(col, row) = static_cast<float>(sum / (cell * cell) + sigma_m * random.normal());
    }
  return grid;
}

/// With what the labels let see of each.
std::vector<SynthSurface> seen_surfaces(const SynthSite& site) {
  std::vector<SynthSurface> surfaces = true_surfaces(site.roads);
  for (SynthSurface& surface : surfaces) {
    SeenPixels seen;
    seen.count(surface.polygon, site.labels.labels, site.labels.frame, site.labels.classes);
    surface.visibility = seen.share();
  }
  return surfaces;
}

/// Photo and labels of the scene.
void take_picture(const SceneSource& source, const GridFrame& frame, const SynthOptions& options, SynthSite& site,
                  const std::function<void(double)>& report) {
  const SceneRaster scene = rasterize_scene(source, frame, options.threads);
  report(0.35);
  const GridFrame in_world = moved(frame, source.plan.world_from_local);
  site.labels = {site.crs, in_world,
                 options.classes ? label_scene(source, scene, *options.classes, options.threads)
                                 : label_scene(source, scene, options.threads),
                 options.classes ? *options.classes : default_class_table()};
  site.photo = {site.crs, in_world, paint_ortho(source, scene, pixels_of(frame), options.threads),
                Raster<std::uint8_t>(frame.width, frame.height, 1, 1)};
}
}  // namespace

void check_synth_options(const SynthOptions& o) {
  if (!(o.gsd_m >= 0.05 && o.gsd_m <= 2.0)) throw OptionError(fmt::format("gsd is {} m, need 0.05 to 2", o.gsd_m));
  if (!(o.osm_offset_min_m >= 0.0 && o.osm_offset_min_m <= o.osm_offset_max_m && o.osm_offset_max_m <= 20.0))
    throw OptionError(
        fmt::format("OSM offsets are {} to {} m, need 0 <= min <= max <= 20", o.osm_offset_min_m, o.osm_offset_max_m));
  if (o.classes) check_synth_classes(*o.classes);
}

SynthSite make_site(const SitePlan& given_plan, const SynthOptions& options, Monitor* monitor) {
  check_synth_options(options);
  SitePlan plan = given_plan;
  std::optional<World> world;
  if (!options.world.empty()) {
    world = make_world(options.world, options.seed);
    pave_roads(plan, *world, options.seed);
    plan.only_footpaths = true;
  }
  if (options.classes) add_landmarks(plan, options.seed);
  const auto report = [&](double fraction) {
    if (monitor) monitor->progress(fraction, "synth");
  };
  SynthSite site;
  site.name = site_name(plan, options.seed);
  site.crs = {"EPSG:32633"};
  const double size = plan.size_m;
  const Vec2 world_from_local = plan.world_from_local;
  const auto to_world = [&](const GridFrame& frame) { return moved(frame, world_from_local); };
  site.bounds = {world_from_local.x, world_from_local.y, world_from_local.x + size, world_from_local.y + size};
  if (plan.circuit) site.route_name = plan.roads[*plan.circuit].name;

  const Terrain terrain = make_terrain(plan, options.seed);
  const int earth_px = static_cast<int>(size + 2.0 * dtm_margin_m);
  const GridFrame earth_frame{-dtm_margin_m, size + dtm_margin_m, 1.0, earth_px, earth_px};
  BareEarth earth = make_bare_earth(plan, terrain, earth_frame, options.threads);
  report(0.15);

  SiteObjects objects = place_objects(plan, earth.clearance_m, earth_frame, options.seed);
  if (world) dress_objects(objects, *world, options.seed);
  const std::vector<RoadSample> samples = sample_roads(plan, terrain, 1.0);
  const int photo_px = static_cast<int>(std::ceil(size / options.gsd_m - 1e-6));
  const GridFrame photo_frame{0.0, size, options.gsd_m, photo_px, photo_px};
  const auto seed = static_cast<std::uint32_t>(derive_seed(options.seed, 7));
  std::optional<TextureSampler> textures;
  if (options.textures) textures.emplace(*options.textures, options.gsd_m, seed);
  const SceneSource source{
      plan, samples, objects, earth, earth_frame, seed, world ? &*world : nullptr, textures ? &*textures : nullptr};
  take_picture(source, photo_frame, options, site, report);
  report(0.9);

  site.true_dtm = {site.crs, to_world(earth_frame), std::move(earth.height_m), "synthetic"};
  site.dtm_1m = noisy_dtm(site.true_dtm, 1, options.dtm_1m_sigma_m, derive_seed(options.seed, 8));
  site.dtm_10m = noisy_dtm(site.true_dtm, 10, options.dtm_10m_sigma_m, derive_seed(options.seed, 9));

  const std::vector<PlannedWay> ways = plan_ways(plan);
  site.osm = disturb_osm(plan, ways, objects, {options.osm_offset_min_m, options.osm_offset_max_m, options.seed});
  site.roads = true_roads(plan, terrain, ways, site.osm);
  for (OsmNode& node : site.osm.nodes) node.p = node.p + world_from_local;
  for (RoadPath& path : site.roads.paths)
    for (RoadNode& node : path.nodes) node.p = node.p + world_from_local;
  site.osm.crs = site.roads.crs = site.crs;
  site.surfaces = seen_surfaces(site);
  report(1.0);
  return site;
}

SynthSite make_preset(Preset preset, const SynthOptions& o, Monitor* monitor) {
  switch (preset) {
    case Preset::village:
      return make_site(plan_village(o.size_m, o.seed), o, monitor);
    case Preset::circuit:
      return make_site(plan_circuit(o.size_m, o.seed), o, monitor);
    case Preset::junction:
      return make_site(plan_junction(o.size_m, o.seed), o, monitor);
    case Preset::grid:
      return make_site(plan_grid(o.size_m, o.seed), o, monitor);
    case Preset::lanes:
      return make_site(plan_lanes(o.size_m, o.seed), o, monitor);
    case Preset::farmland:
      return make_site(plan_farmland(o.size_m, o.seed), o, monitor);
    case Preset::region:
    case Preset::conurbation:
      break;
  }
  throw OptionError("a region or conurbation is made tile by tile: make_region");
}

}  // namespace orthodrive
