// SPDX-License-Identifier: Apache-2.0
// orthodrive segment: a class for every pixel of an orthophoto.

#include <fmt/ranges.h>

#include <memory>
#include <ranges>

#include "commands.hpp"
#include "idle_options.hpp"
#include "load_runs.hpp"
#include "stage_output.hpp"

namespace orthodrive::app {
namespace {
struct SegmentCommand {
  SegmentFiles files;
  RunSegmentOptions options;
  bool crf = false;
  IdleOptions idle;
};

void add_map_options(CLI::App& cmd, SegmentCommand& command) {
  CLI::Option* osm = cmd.add_option(
      "--osm", command.files.osm,
      "OpenStreetMap of the photo, for models that see the map beside it and for --adapt; may be repeated");
  command.idle.needs(
      cmd.add_option("--alignment", command.files.alignment,
                     "with --osm: also write where such a model sees the map's roads (CSV): for `refine`"),
      {osm});
  CLI::Option* adapt =
      cmd.add_flag("--adapt", command.options.adapt,
                   "let the network first learn from this photo and its map (--osm); kept only where it gains")
          ->needs(osm);
  command.idle.needs(
      cmd.add_option("--buildings", command.files.buildings, "maps with buildings for --adapt; none: those of --osm"),
      {adapt});
  command.idle.needs(
      cmd.add_option("--surroundings", command.files.surroundings, "maps with water for --adapt; none: those of --osm"),
      {adapt});
}

void add_crf_options(CLI::App& cmd, SegmentCommand& command) {
  const CLI::Option* crf = cmd.add_flag(
      "--crf", command.crf, "refine the labels along the photo's edges by a dense conditional random field");
  command.idle.needs(
      cmd.add_option("--crf-set", command.options.crf_set,
                     fmt::format("with --crf, in place of the model's one that is not trained: {}, or numbers "
                                 "w1,theta_alpha,theta_beta,w2,theta_gamma",
                                 fmt::join(crf_sets | std::views::transform(&CrfSet::name), ", "))),
      {crf});
  command.idle.needs(cmd.add_option("--crf-iterations", command.options.crf_iterations,
                                    "with --crf: mean-field iterations; 0: as trained")
                         ->check(CLI::Range(0, 100)),
                     {crf});
}
}  // namespace

void add_segment(CLI::App& app, Context& context) {
  auto command = std::make_shared<SegmentCommand>();
  CLI::App* cmd = app.add_subcommand("segment", "Labels every pixel of an orthophoto: road, building, vegetation, ...");
  cmd->add_option(
         "photo", command->files.photos,
         "orthophoto, georeferenced, in any GDAL format of photos; several: best first, later ones fill its gaps")
      ->required();
  cmd->add_option("-o,--output", command->files.labels, "label map (palette GeoTIFF with class table)")->required();
  cmd->add_option("--confidence", command->files.confidence,
                  "also write the probability of each label (GeoTIFF, 0..255)");
  cmd->add_option("--road-probability", command->files.road_probability,
                  "also write the probability of road, whatever the label (GeoTIFF, 0..255): for `refine`");
  cmd->add_option("--model", command->files.model, "name in the models folder or a .safetensors file")
      ->capture_default_str();
  add_map_options(*cmd, *command);
  add_crf_options(*cmd, *command);
  cmd->add_option("--window", command->options.window_px,
                  "pixels decided at once, in each direction; 0: as suits memory; the labels do not depend on it")
      ->capture_default_str();
  cmd->footer(
      "Reads the photo and a model; writes the labels in the photo's UTM zone at the model's scale (0.5 m/px);\n"
      "a photo of 0.3 m/px and finer is read at the finest scale the model knows (0.4 m/px) and gets labels of 0.2 "
      "m/px.\n"
      "The photo: 8 bit a band; its first three bands are red, green, blue; one band is taken as grey, a palette as "
      "its\n"
      "colours. Pixels that are nodata, transparent or masked get no label (255). 16 bit is refused: convert it "
      "first.\n"
      "Photo and labels stream: memory does not grow with the mosaic, about 0.9 GB a thread; 93 megapixels take half\n"
      "a minute on two cores, with the CRF a minute and a half.\n"
      "Examples:\n"
      "  orthodrive segment ortho.tif -o labels.tif\n"
      "  orthodrive segment ortho.tif --osm town.osm -o labels.tif --road-probability p.tif --alignment alignment.csv\n"
      "  orthodrive segment ortho.tif -o labels.tif --confidence confidence.tif --model out/train/model.safetensors\n"
      "  orthodrive segment ortho.tif --adapt --osm town.osm -o labels.tif");
  cmd->callback([command, &context] {
    command->idle.refuse();
    if (command->crf) command->options.crf = CrfUse::trained_or_reference;
    StageContext stage = stage_context(context);
    for (const Finding& finding : runs().run_segment(command->files, command->options, stage).findings)
      stage.info(finding.message);
  });
}

}  // namespace orthodrive::app
