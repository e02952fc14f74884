// SPDX-License-Identifier: Apache-2.0
// orthodrive elevate --method: the reference's methods, to compare the default method with.

#include <memory>
#include <string>

#include "commands/idle_options.hpp"
#include "lab_commands.hpp"
#include "load_lab.hpp"

namespace orthodrive::app {
namespace {
struct ElevateMethods {
  OtherHeightOptions other;
  std::string method = "default";
  IdleOptions idle;
};
}  // namespace

void add_elevate_methods(CLI::App& app, Context& context) {
  auto command = std::make_shared<ElevateMethods>();
  CLI::App* cmd = app.get_subcommand("elevate");
  CLI::Option* method =
      cmd->add_option(
             "--method", command->method,
             "default: the whole network at once, C2, within the limits of the road classes; reference: the thesis' "
             "optimisation, way by way; moving-average: of the terrain along each way")
          ->check(CLI::IsMember({"default", "reference", "moving-average"}))
          ->capture_default_str();
  IdleOptions& idle = command->idle;
  idle.read_for(
      cmd->add_option("--window", command->other.window, "of moving-average: samples, odd; 1 is the terrain as sampled")
          ->check(CLI::PositiveNumber)
          ->capture_default_str(),
      method, {"moving-average"});
  idle.read_for(cmd->add_option("--loss", command->other.reference.loss_m, "of reference: scale of its Cauchy loss, m")
                    ->check(CLI::PositiveNumber)
                    ->capture_default_str(),
                method, {"reference"});
  idle.read_for(cmd->get_option("--control-points"), method, {"default"});
  idle.read_for(cmd->get_option("--clearance"), method, {"default"}, {cmd->get_option("--log")});
  cmd->footer(cmd->get_footer() +
              "\n"
              "  orthodrive elevate --roads roads.gpkg --dtm dtm.tif --method moving-average --window 35 -o "
              "averaged.gpkg\n"
              "Other methods than the default state no standard deviations of z.");
  context.run_elevate = [command, by_default = context.run_elevate](const ElevateFiles& files,
                                                                    const RunElevateOptions& run, StageContext& stage) {
    command->idle.refuse();
    if (command->method == "default") return by_default(files, run, stage);
    command->other.method = command->method == "reference" ? HeightMethod::reference : HeightMethod::moving_average;
    return lab_runs().run_elevate_by(command->other, files, run, stage);
  };
}

}  // namespace orthodrive::app
