// SPDX-License-Identifier: Apache-2.0
// orthodrive synth: a synthetic site with exact truth.

#include <fmt/format.h>

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "commands/idle_options.hpp"
#include "commands/stage_output.hpp"
#include "lab_commands.hpp"
#include "load_lab.hpp"

namespace orthodrive::app {
namespace {
struct SynthArguments {
  std::string preset = "village";
  SynthFiles files;
  SynthOptions options;
  IdleOptions idle;
};

const std::map<std::string, Preset> presets{
    {"village", Preset::village}, {"circuit", Preset::circuit},         {"junction", Preset::junction},
    {"region", Preset::region},   {"conurbation", Preset::conurbation}, {"grid", Preset::grid},
    {"lanes", Preset::lanes},     {"farmland", Preset::farmland}};
/// A real track in place of a preset.
CLI::Option* add_track(CLI::App& cmd, SynthFiles& files, IdleOptions& idle) {
  CLI::Option* track = cmd.add_option("--from-track", files.track,
                                      "CSV of a real closed track: w_tr_right_m, w_tr_left_m, utm33_e, utm33_n; "
                                      "paints a site round its edges, with --size the country round it, too");
  idle.needs(
      cmd.add_option("--track-osm", files.track_osm, "its OSM ways, kept as they are (default: the truth, disturbed)"),
      {track});
  idle.needs(cmd.add_option("--track-heights", files.track_heights,
                            "CSV of heights along it: lon, lat, elev_m (default: made-up hills)"),
             {track});
  return track;
}
}  // namespace

void add_synth(CLI::App& app, Context& context) {
  std::vector<std::string> names;
  names.reserve(presets.size());
  for (const auto& [name, preset] : presets) names.push_back(name);
  auto arguments = std::make_shared<SynthArguments>();
  CLI::App* cmd = app.add_subcommand("synth",
                                     "Makes a synthetic site with exact truth.\n"
                                     "Writes site.toml, ortho.tif, roads.osm, dtm_1m.tif, dtm_10m.tif and truth/ "
                                     "(labels.tif, roads.gpkg, surface.geojson, centrelines.geojson, dtm_1m.tif).");
  SynthOptions& options = arguments->options;
  CLI::Option* preset =
      cmd->add_option("--preset", arguments->preset, fmt::format("kind of site: {}", fmt::join(names, ", ")))
          ->check(CLI::IsMember(names))
          ->capture_default_str();
  cmd->add_option("--seed", options.seed, "same seed, same bytes")->capture_default_str();
  cmd->add_option("-o,--output", arguments->files.folder, "folder to write to")->required();
  cmd->add_option("--world", options.world,
                  fmt::format("season, streets, light and roofs: a name ({}) or random, drawn by seed (default: summer "
                              "in Central Europe)",
                              fmt::join(world_names, ", ")));
  cmd->add_option("--textures", arguments->files.textures,
                  "folder with textures of real photos for its surfaces (tools/paint quilt)");
  cmd->add_option("--classes", arguments->files.classes,
                  "class table of the labels, as models/classes/reference-38.toml; the site then has a quarry, a "
                  "railway, a farm and what else those classes name");
  CLI::Option* size =
      cmd->add_option(
             "--size", options.size_m,
             "edge of the site in metres, a multiple of 10 (region, conurbation: 10000; track: as small as can be)")
          ->capture_default_str();
  CLI::Option* gsd = cmd->add_option("--gsd", options.gsd_m,
                                     "edge of a photo pixel in metres (region, conurbation, track with a size: 0.5)")
                         ->capture_default_str();
  cmd->add_option("--osm-offset-min", options.osm_offset_min_m, "least distance of OSM from the truth in metres")
      ->capture_default_str();
  cmd->add_option("--osm-offset-max", options.osm_offset_max_m, "largest distance of OSM from the truth in metres")
      ->capture_default_str();
  CLI::Option* track = add_track(*cmd, arguments->files, arguments->idle);
  arguments->idle.excludes(preset, {track});
  cmd->footer(
      "Examples:\n  orthodrive synth --seed 7 -o sites/village\n  orthodrive synth --preset junction --seed 3 --size "
      "500 --gsd 0.5 -o /tmp/small\n  orthodrive synth --preset region --size 5000 -o sites/region\n  orthodrive synth "
      "--preset circuit --classes models/classes/reference-38.toml -o sites/circuit\n  orthodrive synth "
      "--preset lanes --world random --seed 5 --size 800 --gsd 0.4 -o sites/lanes\n  orthodrive synth "
      "--from-track track.csv --track-osm track.osm -o sites/track\n"
      "Needs 0.8 GB of memory for 1 km2 at 0.2 m; a region, a conurbation and a track with a size are made tile by "
      "tile.");
  cmd->callback([arguments, size, gsd, track, &context] {
    arguments->idle.refuse();
    const bool is_track = track->count() > 0;
    const bool is_region = !is_track && made_by_tiles(presets.at(arguments->preset));
    if (is_track && size->count() > 0) arguments->files.track_size_m = arguments->options.size_m;
    if (is_region && size->count() == 0) arguments->options.size_m = 10000.0;
    if ((is_region || arguments->files.track_size_m > 0.0) && gsd->count() == 0) arguments->options.gsd_m = 0.5;
    StageContext stage = stage_context(context);
    print_outcome(lab_runs().run_synth(arguments->files, presets.at(arguments->preset), arguments->options, stage),
                  stage);
  });
}

}  // namespace orthodrive::app
