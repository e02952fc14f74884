// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/lab/commands/run_synth.hpp"

#include <fmt/format.h>

#include <optional>
#include <string_view>

#include "orthodrive/core/atomic_file.hpp"
#include "orthodrive/core/error.hpp"
#include "orthodrive/io/osm/osm_reader.hpp"
#include "orthodrive/io/osm/osm_writer.hpp"
#include "orthodrive/io/raster/raster_io.hpp"
#include "orthodrive/io/support/read_file.hpp"
#include "orthodrive/io/support/vector_io.hpp"
#include "orthodrive/pipeline/files/network_spec.hpp"
#include "orthodrive/pipeline/files/toml_section.hpp"
#include "orthodrive/synth/make_region.hpp"
#include "orthodrive/synth/paint/label_classes.hpp"
#include "orthodrive/synth/paint/world.hpp"
#include "orthodrive/synth/plan/plan_from_track.hpp"
#include "orthodrive/synth/plan/plan_presets.hpp"

namespace orthodrive {
namespace fs = std::filesystem;

namespace {
constexpr int jpeg_quality = 85;  // visible artefacts, as in photos from map services

std::string toml_text(std::string_view text) {
  std::string result = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') result += '\\';
    if (static_cast<unsigned char>(c) >= 0x20) result += c;
  }
  return result + '"';
}

std::string site_toml(const SynthSite& site) {
  std::string attribution;
  for (const std::string& text : site.attribution) attribution += (attribution.empty() ? "" : ", ") + toml_text(text);
  const Box2& b = site.bounds;
  return fmt::format(
      "# A synthetic site with exact truth, made by `orthodrive synth`.\n"
      "name = {}\n\n"
      "[area]\ncrs = \"{}\"\nbounds = [{:.1f}, {:.1f}, {:.1f}, {:.1f}]  # min_x, min_y, max_x, max_y in metres\n\n"
      "[sources]\nphoto = \"ortho.tif\"\nosm = \"roads.osm\"\ndtm = [\"dtm_1m.tif\", \"dtm_10m.tif\"]  # best first\n\n"
      "{}"
      "[attribution]\ntext = [{}]\n\n"
      "[truth]\ndir = \"truth\"\n",
      toml_text(site.name), site.crs.definition, b.min_x, b.min_y, b.max_x, b.max_y,
      site.route_name.empty() ? std::string()
                              : fmt::format("[drive]\nroute = {}  # name of a {}way\n\n", toml_text(site.route_name),
                                            site.route_closed ? "closed " : ""),
      attribution);
}

void write_rasters(const fs::path& folder, const SynthSite& site) {
  fs::create_directories(folder / "truth");
  io::write_photo(folder / "ortho.tif", site.photo, {.jpeg_quality = jpeg_quality});
  io::write_dtm(folder / "dtm_1m.tif", site.dtm_1m);
  io::write_dtm(folder / "dtm_10m.tif", site.dtm_10m);
  io::write_labels(folder / "truth/labels.tif", site.labels);
  io::write_dtm(folder / "truth/dtm_1m.tif", site.true_dtm);
}

/// What `tools/paint quilt` wrote: textures.toml and a PNG a class.
PhotoTextures read_textures(const fs::path& folder) {
  const fs::path file = folder / "textures.toml";
  const toml::table table = parse_toml(io::read_file(file), file);
  TomlSection section(table, file);
  PhotoTextures textures;
  section.require("gsd_m");
  section.read("gsd_m", textures.gsd_m);
  section.finish();
  if (!(textures.gsd_m >= 0.05 && textures.gsd_m <= 2.0))
    throw InputError(file.string(), fmt::format("'gsd_m' is {}, need 0.05 to 2 metres a pixel", textures.gsd_m));
  for (const ClassInfo& info : default_class_table().classes) {
    const fs::path tile = folder / (info.name + ".png");
    if (fs::exists(tile)) textures.tiles.emplace(info.name, io::read_image(tile));
  }
  if (textures.tiles.empty())
    throw InputError(folder.string(),
                     "has no textures: need road.png, grass.png and others; make them with tools/paint quilt");
  return textures;
}

/// With all that sites show.
ClassTable read_classes(const fs::path& file) {
  ClassTable table = parse_class_table(io::read_file(file), file);
  try {
    synth::check_synth_classes(table);
  } catch (const OptionError& error) {
    throw InputError(file.string(), error.what());
  }
  return table;
}

/// Writes the rasters on the way.
SynthSite make_region_site(const fs::path& folder, synth::SitePlan plan, const SynthOptions& options,
                           Monitor* monitor) {
  const RegionFrames frames = region_frames(plan, options);  // options that cannot be leave no folder behind
  fs::create_directories(folder / "truth");
  const Crs crs{"EPSG:32633"};
  io::RasterStream photo = io::stream_photo(folder / "ortho.tif", crs, frames.photo, {.jpeg_quality = jpeg_quality}),
                   labels = io::stream_labels(folder / "truth/labels.tif", crs, frames.photo, default_class_table()),
                   dtm_1m = io::stream_dtm(folder / "dtm_1m.tif", crs, frames.dtm_1m),
                   dtm_10m = io::stream_dtm(folder / "dtm_10m.tif", crs, frames.dtm_10m),
                   true_dtm = io::stream_dtm(folder / "truth/dtm_1m.tif", crs, frames.dtm_1m);
  const auto write_picture = [&](const RegionPicture& tile) {
    photo.write(tile.box, tile.rgb), labels.write(tile.box, tile.labels);
  };
  const auto write_heights = [&](const RegionHeights& tile) {
    true_dtm.write(tile.box_1m, tile.true_1m), dtm_1m.write(tile.box_1m, tile.dtm_1m);
    dtm_10m.write(tile.box_10m, tile.dtm_10m);
  };
  SynthSite site = make_region(std::move(plan), options, {write_picture, write_heights}, monitor);
  for (io::RasterStream* stream : {&photo, &labels, &dtm_1m, &dtm_10m, &true_dtm}) stream->finish();
  return site;
}

/// What is not a raster; site.toml last: a folder with a site file is complete.
void write_vectors(const fs::path& folder, const SynthSite& site) {
  const fs::path truth = folder / "truth";
  io::write_osm(folder / "roads.osm", site.osm);
  io::write_roads(truth / "roads.gpkg", site.roads);
  std::vector<io::Feature> surfaces, lines;
  for (std::size_t i = 0; i < site.roads.paths.size(); ++i) {
    const RoadPath& path = site.roads.paths[i];
    const SynthSurface& surface = site.surfaces[i];
    const std::string id = fmt::format("{}", path.osm_id);
    surfaces.push_back(
        {.polygons = {surface.polygon},
         .tags = {{"id", id}, {"kind", surface.highway}, {"visibility", fmt::format("{:.3f}", surface.visibility)}}});
    lines.push_back({.lines = {centerline(path)}, .tags = {{"of", id}, {"osm_id", id}, {"highway", path.highway}}});
  }
  io::write_geojson(truth / "surface.geojson", surfaces, site.crs);
  io::write_geojson(truth / "centrelines.geojson", lines, site.crs);
  write_text_file(folder / "site.toml", site_toml(site));
}

/// With the size, tile by tile.
SynthSite make_track_site(const SynthFiles& files, const SynthOptions& options, StageContext& context) {
  synth::TrackSources sources{
      .file = files.track.string(), .osm_file = files.track_osm.string(), .heights_file = files.track_heights.string()};
  sources.rows = synth::parse_track(io::read_file(files.track), sources.file);
  if (!sources.osm_file.empty()) {
    sources.osm = io::read_osm(files.track_osm, {"EPSG:32633"});
    if (sources.osm.ways.empty()) throw InputError(sources.osm_file, "has no ways");
  }
  if (!sources.heights_file.empty())
    sources.heights = synth::parse_heights(io::read_file(files.track_heights), sources.heights_file);
  SynthSite site;
  if (files.track_size_m > 0.0) {
    site = make_region_site(files.folder, synth::plan_from_track(sources, options.seed, files.track_size_m), options,
                            context.monitor);
  } else {
    site = make_site(synth::plan_from_track(sources, options.seed), options, context.monitor);
    write_rasters(files.folder, site);
  }
  site.attribution = {fmt::format("Road edges: {}, see its licence", files.track.filename().string())};
  if (!sources.osm_file.empty()) site.attribution.push_back("Roads: OpenStreetMap contributors, ODbL");
  if (!sources.heights_file.empty())
    site.attribution.push_back(fmt::format("Heights: {}, see its licence", files.track_heights.filename().string()));
  site.attribution.push_back("All else made up by orthodrive synth");
  RoadNetwork track = site.roads;
  std::erase_if(track.paths, [&](const RoadPath& path) { return path.name != site.route_name; });
  const synth::TrackErrors errors = synth::measure_track(sources.rows, track);
  context.info(
      fmt::format("lap {:.2f} m; given edges lie {:.3f} m (mean), {:.3f} m (p95), {:.3f} m (most) from the true "
                  "carriageway's",
                  errors.lap_m, errors.edge_mean_m, errors.edge_p95_m, errors.edge_most_m));
  return site;
}
}  // namespace

StageOutcome run_synth(const SynthFiles& files, Preset preset, const SynthOptions& options, StageContext& context) {
  SynthOptions made = options;
  made.threads = context.threads;
  std::optional<PhotoTextures> textures;
  if (!files.textures.empty()) made.textures = &textures.emplace(read_textures(files.textures));
  std::optional<ClassTable> classes;
  if (!files.classes.empty()) made.classes = &classes.emplace(read_classes(files.classes));
  SynthSite site;
  if (!files.track.empty()) {
    site = make_track_site(files, made, context);
  } else if (made_by_tiles(preset)) {
    const auto plan = preset == Preset::region ? synth::plan_region : synth::plan_conurbation;
    site = make_region_site(files.folder, plan(made.size_m, made.seed), made, context.monitor);
  } else {
    site = make_preset(preset, made, context.monitor);
    write_rasters(files.folder, site);
  }
  write_vectors(files.folder, site);
  double road_m = 0.0;
  for (const RoadPath& path : site.roads.paths) road_m += path.nodes.back().s_m;
  return {.summary = {fmt::format("{}: {} ways, {:.1f} km of road, written to {}", site.name, site.roads.paths.size(),
                                  road_m / 1000.0, files.folder.string())}};
}

}  // namespace orthodrive
