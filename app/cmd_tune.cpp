// orthodrive tune: weights of the road refinement from sites with truth.

#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <system_error>

#include "commands.hpp"
#include "orthodrive/core/aside_file.hpp"
#include "orthodrive/core/error.hpp"
#include "orthodrive/pipeline/tune_refine.hpp"

namespace orthodrive::app {
namespace {

struct TuneCommand {
  std::filesystem::path sites, out;
  SearchWeightsOptions options;
};

void run(const TuneCommand& command, const Context& context) {
  SearchWeightsOptions options = command.options;
  options.threads = context.threads;
  const TuneSites sites = read_tune_sites(command.sites, context.monitor);
  std::error_code failed;  // told before the search, which takes minutes
  std::filesystem::create_directories(command.out, failed);
  if (!std::filesystem::is_directory(command.out))
    throw OptionError(fmt::format("{}: cannot make this folder; give another -o", command.out.string()));
  const TuneResult result = tune_refine(sites, options, context.monitor);
  write_text_file(command.out / "weights.toml", to_weights_file(result));
  write_text_file(command.out / "report.json", to_json(result).dump(1) + "\n");
  fmt::print("{}", to_table(result));
}

}  // namespace

void add_tune(CLI::App& app, Context& context) {
  auto command = std::make_shared<TuneCommand>();
  CLI::App* cmd = app.add_subcommand(
      "tune", "Search the weights of refine's default method on sites with truth, and tell over-fitting.");
  cmd->add_option("sites", command->sites, "TOML file of [[site]]")->required();
  cmd->add_option("-o,--output", command->out, "folder for weights.toml and report.json; created when missing")
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
  cmd->callback([command, &context] { run(*command, context); });
}

}  // namespace orthodrive::app
