#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <string>

#include "commands.hpp"
#include "orthodrive/core/aside_file.hpp"
#include "orthodrive/io/osm_writer.hpp"
#include "orthodrive/io/raster_io.hpp"
#include "orthodrive/io/vector_io.hpp"
#include "orthodrive/synth/make_village.hpp"

namespace orthodrive::app {
namespace {
constexpr int jpeg_quality = 85;  // visible artefacts, as in photos from map services

std::string site_toml(const SynthSite& site) {
  const Box2& b = site.bounds;
  return fmt::format(
      "# A synthetic site with exact truth, made by `orthodrive synth`.\n"
      "name = \"{}\"\n\n"
      "[area]\ncrs = \"{}\"\nbounds = [{:.1f}, {:.1f}, {:.1f}, {:.1f}]  # min_x, min_y, max_x, max_y in metres\n\n"
      "[sources]\nphoto = \"ortho.tif\"\nosm = \"roads.osm\"\ndtm = [\"dtm_1m.tif\", \"dtm_10m.tif\"]  # best first\n\n"
      "[drive]\nroute = \"{}\"  # name of a closed way\n\n"
      "[attribution]\ntext = [\"Synthetic site made by orthodrive synth, no rights reserved\"]\n\n"
      "[truth]\ndir = \"truth\"\n",
      site.name, site.crs.definition, b.min_x, b.min_y, b.max_x, b.max_y, site.circuit_name);
}

void write_site(const std::filesystem::path& folder, const SynthSite& site) {
  const std::filesystem::path truth = folder / "truth";
  std::filesystem::create_directories(truth);
  io::write_photo(folder / "ortho.tif", site.photo, {.jpeg_quality = jpeg_quality});
  io::write_dtm(folder / "dtm_1m.tif", site.dtm_1m);
  io::write_dtm(folder / "dtm_10m.tif", site.dtm_10m);
  io::write_osm(folder / "roads.osm", site.osm);

  io::write_labels(truth / "labels.tif", site.labels);
  io::write_dtm(truth / "dtm_1m.tif", site.true_dtm);
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
  write_text_file(folder / "site.toml", site_toml(site));  // last: a folder with a site file is complete
}
}  // namespace

void add_synth(CLI::App& app, Context& context) {
  struct Arguments {
    std::string preset = "village";
    std::filesystem::path output;
    VillageOptions village;
  };
  auto arguments = std::make_shared<Arguments>();
  CLI::App* cmd = app.add_subcommand("synth",
                                     "Makes a synthetic site with exact truth.\n"
                                     "Writes site.toml, ortho.tif, roads.osm, dtm_1m.tif, dtm_10m.tif and truth/ "
                                     "(labels.tif, roads.gpkg, surface.geojson, centrelines.geojson, dtm_1m.tif).");
  VillageOptions& village = arguments->village;
  cmd->add_option("--preset", arguments->preset, "kind of site")
      ->check(CLI::IsMember({"village"}))
      ->capture_default_str();
  cmd->add_option("--seed", village.seed, "same seed, same bytes")->capture_default_str();
  cmd->add_option("-o,--output", arguments->output, "folder to write to")->required();
  cmd->add_option("--size", village.size_m, "edge of the site in metres, a multiple of 10")->capture_default_str();
  cmd->add_option("--gsd", village.gsd_m, "edge of a photo pixel in metres")->capture_default_str();
  cmd->add_option("--osm-offset-min", village.osm_offset_min_m, "least distance of OSM from the truth in metres")
      ->capture_default_str();
  cmd->add_option("--osm-offset-max", village.osm_offset_max_m, "largest distance of OSM from the truth in metres")
      ->capture_default_str();
  cmd->footer(
      "Examples:\n  orthodrive synth --seed 7 -o sites/village\n  orthodrive synth --seed 3 --size 300 --gsd 0.5 -o "
      "/tmp/small\n"
      "Needs 0.65 GB of memory for 1 km2 at 0.2 m.");
  cmd->callback([arguments, &context] {
    arguments->village.threads = context.threads;
    const SynthSite site = make_village(arguments->village, context.monitor);
    write_site(arguments->output, site);
    double road_m = 0.0;
    for (const RoadPath& path : site.roads.paths) road_m += path.nodes.back().s_m;
    context.monitor->info(fmt::format("{}: {} ways, {:.1f} km of road, written to {}", site.name,
                                      site.roads.paths.size(), road_m / 1000.0, arguments->output.string()));
  });
}

}  // namespace orthodrive::app
