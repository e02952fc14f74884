#include <fmt/format.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <memory>
#include <string>
#include <string_view>

#include "commands.hpp"
#include "orthodrive/core/aside_file.hpp"
#include "orthodrive/core/error.hpp"
#include "orthodrive/io/osm_reader.hpp"
#include "orthodrive/io/osm_writer.hpp"
#include "orthodrive/io/raster_io.hpp"
#include "orthodrive/io/vector_io.hpp"
#include "orthodrive/synth/make_site.hpp"
#include "orthodrive/synth/plan_from_track.hpp"

namespace orthodrive::app {
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
      site.circuit_name.empty()
          ? std::string()
          : fmt::format("[drive]\nroute = {}  # name of a closed way\n\n", toml_text(site.circuit_name)),
      attribution);
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

struct Arguments {
  std::string preset = "village";
  std::filesystem::path output, track, track_osm, track_heights;
  SynthOptions options;
};

std::string read_text(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file || std::filesystem::is_directory(path)) throw InputError(path.string(), "cannot be read; is it there?");
  return {std::istreambuf_iterator<char>(file), {}};
}

SynthSite make_track_site(const Arguments& arguments, Monitor* monitor) {
  synth::TrackSources sources{.file = arguments.track.string(),
                              .osm_file = arguments.track_osm.string(),
                              .heights_file = arguments.track_heights.string()};
  sources.rows = synth::parse_track(read_text(arguments.track), sources.file);
  if (!sources.osm_file.empty()) {
    sources.osm = io::read_osm(arguments.track_osm, {"EPSG:32633"});
    if (sources.osm.ways.empty()) throw InputError(sources.osm_file, "has no ways");
  }
  if (!sources.heights_file.empty())
    sources.heights = synth::parse_heights(read_text(arguments.track_heights), sources.heights_file);
  SynthSite site = make_site(synth::plan_from_track(sources, arguments.options.seed), arguments.options, monitor);
  site.attribution = {fmt::format("Road edges: {}, see its licence", arguments.track.filename().string())};
  if (!sources.osm_file.empty()) site.attribution.push_back("Roads: OpenStreetMap contributors, ODbL");
  if (!sources.heights_file.empty())
    site.attribution.push_back(
        fmt::format("Heights: {}, see its licence", arguments.track_heights.filename().string()));
  site.attribution.push_back("All else made up by orthodrive synth");
  const synth::TrackErrors errors = synth::measure_track(sources.rows, site.roads);
  if (monitor)
    monitor->info(
        fmt::format("lap {:.2f} m; given edges lie {:.3f} m (mean), {:.3f} m (p95), {:.3f} m (most) from the true "
                    "carriageway's",
                    errors.lap_m, errors.edge_mean_m, errors.edge_p95_m, errors.edge_most_m));
  return site;
}
}  // namespace

void add_synth(CLI::App& app, Context& context) {
  static const std::map<std::string, Preset> presets{
      {"village", Preset::village}, {"circuit", Preset::circuit}, {"junction", Preset::junction}};
  auto arguments = std::make_shared<Arguments>();
  CLI::App* cmd = app.add_subcommand("synth",
                                     "Makes a synthetic site with exact truth.\n"
                                     "Writes site.toml, ortho.tif, roads.osm, dtm_1m.tif, dtm_10m.tif and truth/ "
                                     "(labels.tif, roads.gpkg, surface.geojson, centrelines.geojson, dtm_1m.tif).");
  SynthOptions& options = arguments->options;
  CLI::Option* preset = cmd->add_option("--preset", arguments->preset, "kind of site: village, circuit, junction")
                            ->check(CLI::IsMember({"village", "circuit", "junction"}))
                            ->capture_default_str();
  cmd->add_option("--seed", options.seed, "same seed, same bytes")->capture_default_str();
  cmd->add_option("-o,--output", arguments->output, "folder to write to")->required();
  CLI::Option* size =
      cmd->add_option("--size", options.size_m, "edge of the site in metres, a multiple of 10")->capture_default_str();
  cmd->add_option("--gsd", options.gsd_m, "edge of a photo pixel in metres")->capture_default_str();
  cmd->add_option("--osm-offset-min", options.osm_offset_min_m, "least distance of OSM from the truth in metres")
      ->capture_default_str();
  cmd->add_option("--osm-offset-max", options.osm_offset_max_m, "largest distance of OSM from the truth in metres")
      ->capture_default_str();
  CLI::Option* track = cmd->add_option("--from-track", arguments->track,
                                       "CSV of a real closed track: w_tr_right_m, w_tr_left_m, utm33_e, utm33_n; "
                                       "paints a site round its edges")
                           ->excludes(preset)
                           ->excludes(size);
  cmd->add_option("--track-osm", arguments->track_osm, "its OSM ways, kept as they are (default: the truth, disturbed)")
      ->needs(track);
  cmd->add_option("--track-heights", arguments->track_heights,
                  "CSV of heights along it: lon, lat, elev_m (default: made-up hills)")
      ->needs(track);
  cmd->footer(
      "Examples:\n  orthodrive synth --seed 7 -o sites/village\n  orthodrive synth --preset junction --seed 3 --size "
      "500 --gsd 0.5 -o /tmp/small\n  orthodrive synth --from-track track.csv --track-osm track.osm -o sites/track\n"
      "Needs 0.8 GB of memory for 1 km2 at 0.2 m.");
  cmd->callback([arguments, &context] {
    arguments->options.threads = context.threads;
    const SynthSite site = arguments->track.empty()
                               ? make_preset(presets.at(arguments->preset), arguments->options, context.monitor)
                               : make_track_site(*arguments, context.monitor);
    write_site(arguments->output, site);
    double road_m = 0.0;
    for (const RoadPath& path : site.roads.paths) road_m += path.nodes.back().s_m;
    context.monitor->info(fmt::format("{}: {} ways, {:.1f} km of road, written to {}", site.name,
                                      site.roads.paths.size(), road_m / 1000.0, arguments->output.string()));
  });
}

}  // namespace orthodrive::app
