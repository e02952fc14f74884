// SPDX-License-Identifier: Apache-2.0
// orthodrive fmu: roads, and a car if asked, as a functional mock-up unit.

#include <memory>

#include "commands.hpp"
#include "idle_options.hpp"
#include "load_runs.hpp"
#include "stage_output.hpp"

namespace orthodrive::app {
namespace {
struct FmuCommand {
  FmuFiles files;
  FmuOptions options;
  IdleOptions idle;
};
}  // namespace

void add_fmu(CLI::App& app, Context& context) {
  auto command = std::make_shared<FmuCommand>();
  CLI::App* cmd = app.add_subcommand("fmu", "Pack roads, and a car if asked, into an FMU for co-simulation.");
  CLI::Option* network = cmd->add_option(
      "--network", command->files.network,
      "roads (OpenDRIVE) with the OpenCRG files that they name; without it the simulator sets road_file");
  command->idle.needs(cmd->add_option("--terrain", command->files.terrain,
                                      "ESRI ASCII grid around the roads (orthodrive scene --terrain-grid)"),
                      {network});
  cmd->add_option(
      "--car", command->files.car,
      "parameter file or name of a car (family_car, sports_car, gt3_like): the FMU is that car on the roads");
  cmd->add_option("--fmi", command->options.fmi_version, "version of FMI: 2 or 3")->capture_default_str();
  cmd->add_option("-o,--output", command->files.fmu, "FMU, written")->required();
  cmd->footer(
      "Reads all files to check them; writes one .fmu (x86-64 Linux).\n"
      "Examples:\n"
      "  orthodrive fmu --network out/roads.xodr -o roads.fmu\n"
      "  orthodrive fmu --network out/roads.xodr --car sports_car -o car.fmu");
  cmd->callback([command, &context] {
    command->idle.refuse();
    StageContext stage = stage_context(context);
    print_outcome(runs().run_fmu(command->files, command->options, stage), stage);
  });
}

}  // namespace orthodrive::app
