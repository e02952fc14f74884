// SPDX-License-Identifier: Apache-2.0
// orthodrive network: roads with widths and heights as OpenDRIVE.

#include <fmt/format.h>

#include <map>
#include <memory>

#include "choice_option.hpp"
#include "commands.hpp"
#include "driving_side_option.hpp"
#include "idle_options.hpp"
#include "load_runs.hpp"
#include "stage_output.hpp"

namespace orthodrive::app {
namespace {

struct NetworkCommand {
  NetworkFiles files;
  RunNetworkOptions options;
  std::string opendrive = "1.7", crg_format = "KRBI";
  IdleOptions idle;
};

void build_it(NetworkCommand& command, const Context& context) {
  command.idle.refuse();
  command.options.opendrive_minor_version = command.opendrive == "1.8" ? 8 : 7;
  command.options.crg.format = runs().crg_format_of(command.crg_format);
  StageContext stage = stage_context(context);
  const StageOutcome outcome = runs().run_network(command.files, command.options, stage);
  std::map<std::string, int> counts;  // a line a place would be too many
  for (const Finding& finding : outcome.findings) ++counts[finding.code];
  for (const auto& [code, count] : counts) stage.info(fmt::format("{}: {} places", code, count));
  for (const std::string& line : outcome.summary) stage.info(line);
}

/// Grids of the surfaces of chosen roads, beside the OpenDRIVE file.
void add_crg_options(CLI::App* cmd, NetworkCommand& command) {
  CrgFilesOptions& options = command.options.crg;
  CLI::Option* crg =
      cmd->add_option("--crg", options.roads,
                      "also write OpenCRG surfaces of these roads into NAME_crg/ beside the output and refer to them:\n"
                      "ids of roads, way/ID of OSM ways, all-of-route, all; separated by commas")
          ->delimiter(',');
  CLI::Option* route =
      cmd->add_option("--route", options.route, "for --crg all-of-route: as --route of drive")->capture_default_str();
  command.idle.read_for(route, crg, {"all-of-route"});
  for (CLI::Option* of_crg :
       {cmd->add_flag("--crg-friction", options.friction,
                      "beside each of them also road_ID_friction.crg, a grid of the friction of the lanes"),
        cmd->add_option("--crg-format", command.crg_format,
                        "KRBI, KDBI (binary, 4 or 8 bytes a value), LRFI or LDFI (text)")
            ->capture_default_str(),
        cmd->add_option("--crg-u-step", options.u_step_m, "m, largest step of the grid along the road")
            ->check(CLI::Range(0.01, 10.0))
            ->capture_default_str(),
        cmd->add_option("--crg-v-step", options.v_step_m, "m, step of the grid across the road")
            ->check(CLI::Range(0.01, 5.0))
            ->capture_default_str()})
    command.idle.needs(of_crg, {crg});
}

/// How far the network may be from the roads that it is fitted to.
void add_tolerances(CLI::App* cmd, BuildNetworkOptions& options) {
  const auto tolerance = [&](const char* flag, double& value, const char* text) {
    cmd->add_option(flag, value, text)->check(CLI::PositiveNumber)->capture_default_str();
  };
  tolerance("--plan-tolerance", options.plan_tolerance_m, "m, largest distance of a node from the reference line");
  tolerance("--elevation-tolerance", options.elevation_tolerance_m, "m, largest height error at a node");
  tolerance("--banking-tolerance", options.banking_tolerance_rad, "rad, largest superelevation error at a node");
  tolerance("--width-tolerance", options.width_tolerance_m, "m, largest width error at a node");
}

}  // namespace

void add_network(CLI::App& app, Context& context) {
  auto command = std::make_shared<NetworkCommand>();
  CLI::App* cmd = app.add_subcommand(
      "network", "Write roads as OpenDRIVE 1.7 or 1.8: lines, arcs and clothoids, profiles, lanes, junctions.");
  cmd->add_option("--roads", command->files.roads, "roads with widths and heights (GeoPackage of refine and elevate)")
      ->required();
  cmd->add_option("-o,--output", command->files.network, "OpenDRIVE file to write (.xodr)")->required();
  cmd->add_option("--findings", command->files.findings, "also write what was odd, as GeoJSON points");
  CLI::Option* opendrive = cmd->add_option("--opendrive", command->opendrive, "version of the file")
                               ->check(CLI::IsMember({"1.7", "1.8"}))
                               ->capture_default_str();
  command->idle.read_for(
      cmd->add_flag("--junction-grids", command->options.junction_grids,
                    "also write the surfaces of junctions as <boundary> and <elevationGrid> of OpenDRIVE 1.8, for "
                    "readers that\nknow them; netconvert of SUMO refuses such a file"),
      opendrive, {"1.8"});
  cmd->add_flag("--absolute", command->options.absolute,
                "write coordinates of the CRS, for readers that get the header's <offset> wrong (SUMO 1.15)");
  cmd->add_flag("--check", command->options.check,
                "read the file back; an error when its surface is not the same within 1 mm");
  cmd->add_flag("--judge", command->options.judge,
                "also follow every lane and say whether the network can be driven, as `evaluate network` does");
  cmd->add_option("--layers", command->files.layers, "also write reference lines, lanes and junctions as a GeoPackage");
  cmd->add_option("--geojson", command->files.geojson, "also write the same as GeoJSON (WGS84)");
  add_crg_options(cmd, *command);
  command->options.network.name.clear();
  cmd->add_option("--name", command->options.network.name, "name in the header; default: the name of the output file");
  add_tolerances(cmd, command->options.network);
  cmd->add_option(
      "--country", command->options.country,
      "code of the country (ISO 3166-1) or of its part (ISO 3166-2, such as US-CA) whose law gives limits where no "
      "sign tells; default: that in which the roads lie");
  add_driving_side(cmd, command->options.driving_side, "right, left: where one drives");
  add_choice<Weather>(*cmd, "--weather", command->options.network.weather,
                      {{"dry", Weather::dry}, {"wet", Weather::wet}},
                      "dry, wet: what the friction of the lanes is for");
  cmd->footer(
      "Reads roads.gpkg (layers centrelines, nodes and, for OpenCRG, roughness). Writes one OpenDRIVE file in the CRS "
      "of the roads. Roads without\n"
      "heights lie flat at z = 0. Where roughness was measured (`elevate --log`) OpenCRG surfaces have it: waves of "
      "two steps of\n"
      "the grid and longer, so give --crg-u-step 0.1 for all that tyres feel. Takes three seconds and 300 MB for 250 "
      "km of roads; a kilometre of OpenCRG surface a\n"
      "quarter of a second and half a megabyte.\n\n"
      "Examples:\n"
      "  orthodrive network --roads out/roads.gpkg -o out/roads.xodr\n"
      "  orthodrive network --roads roads.gpkg -o roads.xodr --elevation-tolerance 0.01 --findings odd.geojson\n"
      "  orthodrive network --roads roads.gpkg -o roads.xodr --opendrive 1.8 --layers network.gpkg --crg way/26182390");
  cmd->callback([command, &context] { build_it(*command, context); });
}

}  // namespace orthodrive::app
