// SPDX-License-Identifier: Apache-2.0
// orthodrive forests: the two random forests of the MRF baseline, learned from labelled photos.

#include <memory>

#include "commands/stage_output.hpp"
#include "lab_commands.hpp"
#include "load_lab.hpp"

namespace orthodrive::app {
namespace {
struct ForestsCommand {
  ForestsFiles files;
  RoadForestOptions options;
};
}  // namespace

void add_forests(CLI::App& app, Context& context) {
  auto command = std::make_shared<ForestsCommand>();
  CLI::App* cmd =
      app.add_subcommand("forests", "Learn from labelled photos what `refine --method mrf` takes for a road.");
  cmd->add_option("--photo", command->files.photos, "orthophoto; once for each --labels")
      ->required()
      ->allow_extra_args(false);
  cmd->add_option("--labels", command->files.labels,
                  "its labels: a label map, or polygons (GeoJSON, GeoPackage) with class and piece")
      ->required()
      ->allow_extra_args(false);
  cmd->add_option("-o,--output", command->files.forests, "the forests (YAML text)")->required();
  cmd->add_option("--trees", command->options.trees, "of each forest")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  cmd->add_option("--samples", command->options.max_samples, "superpixels of each kind to learn from, at most")
      ->check(CLI::Range(1, 1000000))
      ->capture_default_str();
  cmd->add_option("--seed", command->options.seed, "of the random choice")->capture_default_str();
  cmd->footer(
      "Reads pairs of a photo and its labels, the first --photo with the first --labels and so on; writes one file.\n"
      "Roads are learned as road, parking not at all, every other class as beside or far from a road. Photos are read "
      "at\n"
      "their own scale, which must be near that of the photos to refine in. Memory: about 5 bytes a pixel of all "
      "photos.\n"
      "Examples:\n"
      "  orthodrive forests --photo village/ortho.tif --labels village/truth/labels.tif -o forests.yml\n"
      "  orthodrive forests --photo a.tif --labels a.geojson --photo b.tif --labels b_labels.tif -o forests.yml");
  cmd->callback([command, &context] {
    StageContext stage = stage_context(context);
    print_outcome(lab_runs().run_forests(command->files, command->options, stage), stage);
  });
}

}  // namespace orthodrive::app
