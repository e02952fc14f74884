// SPDX-License-Identifier: Apache-2.0
// orthodrive tune: weights of the road refinement from sites with truth.

#include <fmt/format.h>

#include <memory>

#include "commands/stage_output.hpp"
#include "lab_commands.hpp"
#include "load_lab.hpp"

namespace orthodrive::app {
namespace {
struct TuneCommand {
  TuneFiles files;
  SearchWeightsOptions options;
};
}  // namespace

void add_tune(CLI::App& app, Context& context) {
  auto command = std::make_shared<TuneCommand>();
  CLI::App* cmd = app.add_subcommand(
      "tune", "Search the weights of refine's default method on sites with truth, and tell over-fitting.");
  cmd->add_option("sites", command->files.sites, "TOML file of [[site]]")->required();
  cmd->add_option("-o,--output", command->files.folder, "folder for weights.toml and report.json; created when missing")
      ->required();
  SearchWeightsOptions& o = command->options;
  cmd->add_option("--trials", o.trials, "weights tried in each search")
      ->check(CLI::Range(0, 1000000))
      ->capture_default_str();
  cmd->add_option("--seed", o.seed, "of the random changes")->capture_default_str();
  cmd->footer(
      "Each fold of sites is held out once: weights are searched on the others, from the shipped ones, and judged on "
      "it.\n"
      "weights.toml is searched on all sites. Loss, m: mean offset + half the mean width error + (1 - surface IoU).\n"
      "The file, with paths relative to it:\n"
      "  [[site]]\n"
      "  name = \"kvarnbyn\"\n"
      "  labels = \"labels.tif\"\n"
      "  road_probability = \"road_probability.tif\"  # optional\n"
      "  osm = \"roads.osm\"\n"
      "  truth = \"carriageways.geojson\"   # as `evaluate roads` takes it, with centre lines\n"
      "  area = \"area.geojson\"            # optional; only ways within 150 m of it are refined\n"
      "  ignore = \"unmapped.geojson\"      # optional\n"
      "  pieces = true                    # optional: each polygon of area is a site of its own\n"
      "  fold = \"Sweden\"                  # optional, default the name: held out together\n"
      "Needs 4 bytes a pixel of the labels of all sites.\n"
      "Examples:\n"
      "  orthodrive tune sites.toml -o tuned\n"
      "  orthodrive tune sites.toml -o tuned --trials 200 --seed 2\n"
      "  orthodrive refine --osm roads.osm --labels labels.tif --weights-file tuned/weights.toml -o roads.gpkg");
  cmd->callback([command, &context] {
    StageContext stage = stage_context(context);
    for (const std::string& table : lab_runs().run_tune(command->files, command->options, stage).summary)
      fmt::print("{}", table);
  });
}

}  // namespace orthodrive::app
