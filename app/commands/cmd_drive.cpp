// SPDX-License-Identifier: Apache-2.0
// orthodrive drive: laps, routes or every road in a simulated car.

#include <fmt/format.h>

#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include "choice_option.hpp"
#include "commands.hpp"
#include "idle_options.hpp"
#include "load_runs.hpp"
#include "orthodrive/core/error.hpp"
#include "stage_output.hpp"

namespace orthodrive::app {
namespace {

struct DriveArguments {
  DriveFiles files;
  RunDriveOptions drive;
  std::vector<std::string> via;
  IdleOptions idle;
};

Vec2 parse_point(const std::string& text) {
  char *comma = nullptr, *end = nullptr;
  const double x = std::strtod(text.c_str(), &comma);
  if (comma != text.c_str() && *comma == ',') {
    const double y = std::strtod(comma + 1, &end);
    if (end != comma + 1 && *end == '\0') return {x, y};
  }
  throw OptionError("--via " + text + ": need two numbers, x,y in metres of the site CRS");
}

void drive_it(DriveArguments& arguments, const Context& context) {
  arguments.idle.refuse();
  for (const std::string& text : arguments.via) arguments.drive.route.via.push_back(parse_point(text));
  StageContext stage = stage_context(context);
  const StageOutcome outcome = runs().run_drive(arguments.files, arguments.drive, stage);
  for (const std::string& line : outcome.summary) stage.info(line);
  for (const Finding& finding : outcome.findings)
    stage.info(fmt::format("{} at {:.1f}, {:.1f}: {}", finding.code, finding.x_m, finding.y_m, finding.message));
}

}  // namespace

namespace {

/// Returns --all-roads.
CLI::Option* add_route_options(CLI::App& cmd, DriveArguments& arguments) {
  CLI::Option* all_roads =
      cmd.add_flag("--all-roads", arguments.drive.all_roads,
                   "drives every road of the largest connected part at its speed limit and lists the places that fail; "
                   "writes DIR/all_roads.csv, all_roads.json");
  CLI::Option* route =
      cmd.add_option(
             "--route", arguments.drive.route.route,
             "auto (a loop of raceways, else a good loop of 0.5 to 5 km), or names / OSM ids of ways with commas")
          ->capture_default_str();
  CLI::Option* via = cmd.add_option(
      "--via", arguments.via, "x,y in metres of the site CRS; several: past these in order and back to the first");
  arguments.idle.excludes(route, {via, all_roads});
  arguments.idle.excludes(via, {all_roads});
  return all_roads;
}

void add_car_options(CLI::App& cmd, RunDriveOptions& drive, IdleOptions& idle, const CLI::Option* all_roads) {
  cmd.add_option("--vehicle", drive.vehicle, "auto (sports when racing, else family), family, sports, gt3, or a file")
      ->capture_default_str();
  idle.excludes(add_choice<std::optional<DrivingStyle>>(
                    cmd, "--style", drive.style,
                    {{"auto", std::nullopt},
                     {"road", DrivingStyle::road},
                     {"racing", DrivingStyle::racing},
                     {"centre", DrivingStyle::centre}},
                    "auto (centre on roads without lanes, racing on raceways), road (own lane, speed limits), racing "
                    "(whole width, the car's limit), centre (the plain middle of the road, the car's limit)"),
                {all_roads});
  idle.excludes(cmd.add_option("--laps", drive.laps, "timed laps of a closed route")
                    ->check(CLI::Range(1, 1000))
                    ->capture_default_str(),
                {all_roads});
  idle.excludes(cmd.add_flag("--standing-start", drive.standing_start,
                             "of a closed route: from rest; else a lap to warm up comes before the timed one"),
                {all_roads});
  cmd.add_flag("--stops", drive.stops, "stands where other traffic goes first");
  cmd.add_option("--bare-width", drive.bare_width_m, "of roads that are a reference line without lanes, m")
      ->check(CLI::Range(2.0, 100.0))
      ->capture_default_str();
  cmd.add_flag("--flat", drive.flat, "without the heights of the roads, to see what they change");
  cmd.add_option("--max-speed", drive.max_speed_mps, "top speed, m/s; else 36 on roads")->check(CLI::Range(3.0, 120.0));
  cmd.add_option("--max-lateral", drive.max_lateral_mps2, "lateral acceleration in bends, m/s^2; else 4 on roads")
      ->check(CLI::Range(0.5, 50.0));
  cmd.add_option("--step", drive.step_ms, "time step of the car, ms")
      ->check(CLI::Range(0.1, 2.0))
      ->capture_default_str();
}

}  // namespace

void add_drive(CLI::App& app, Context& context) {
  auto arguments = std::make_shared<DriveArguments>();
  CLI::App* cmd = app.add_subcommand(
      "drive",
      "Drives on OpenDRIVE roads: a car whose four tyres ask for the road surface 1000 times a second.\n"
      "Reads roads.xodr (OpenDRIVE 1.4 - 1.8), writes into DIR lap.csv, cycle.csv, lap.gpx, lap.xosc\n"
      "(OpenSCENARIO) and report.html.");
  cmd->add_option("--network", arguments->files.network, "OpenDRIVE file")->required();
  cmd->add_option("-o,--output", arguments->files.folder, "output folder")->required();
  const CLI::Option* all_roads = add_route_options(*cmd, *arguments);
  add_car_options(*cmd, arguments->drive, arguments->idle, all_roads);
  cmd->footer(
      "Examples:\n"
      "  orthodrive drive --network out/roads.xodr -o out/drive\n"
      "  orthodrive drive --network ring/roads.xodr --vehicle gt3 --laps 2 -o lap\n"
      "  orthodrive drive --network ring/roads.xodr --style centre --vehicle sports -o centre_line\n"
      "  orthodrive drive --network roads.xodr --all-roads --vehicle family -o check\n"
      "  orthodrive drive --network roads.xodr --via 529900,5542300 --via 530400,5542800 --max-lateral 3 -o lap");
  cmd->callback([arguments, &context] { drive_it(*arguments, context); });
}

}  // namespace orthodrive::app
