// orthodrive drive: one lap in a simulated car.

#include <fmt/format.h>

#include <cstdio>
#include <filesystem>
#include <memory>
#include <vector>

#include "commands.hpp"
#include "orthodrive/core/aside_file.hpp"
#include "orthodrive/core/error.hpp"
#include "orthodrive/drive/drive_report.hpp"
#include "orthodrive/drive/simulate_lap.hpp"

namespace orthodrive::app {
namespace {

struct Arguments {
  std::string network;
  std::filesystem::path out_dir;
  DriveOptions drive;
  std::vector<std::string> via;
};

Vec2 parse_point(const std::string& text) {
  Vec2 p;
  char comma = 0, rest = 0;
  if (std::sscanf(text.c_str(), "%lf%c%lf%c", &p.x, &comma, &p.y, &rest) != 3 || comma != ',') {
    throw OptionError("--via " + text + ": need two numbers, x,y in metres of the site CRS");
  }
  return p;
}

void run(Arguments& arguments, Monitor* monitor) {
  for (const std::string& text : arguments.via) arguments.drive.route.via.push_back(parse_point(text));
  const roadquery::RoadMap map = roadquery::read_opendrive(arguments.network);
  const DriveResult result = simulate_lap(map, arguments.drive, monitor);
  write_text_file(arguments.out_dir / "lap.csv", lap_csv(result));
  write_text_file(arguments.out_dir / "report.html", lap_report_html(map, result));
  if (monitor == nullptr) return;
  for (const auto& [label, value] : lap_numbers(result)) monitor->info(fmt::format("{}: {}", label, value));
  for (const Finding& finding : result.findings) {
    monitor->info(fmt::format("{} at {:.1f}, {:.1f}: {}", finding.code, finding.x_m, finding.y_m, finding.message));
  }
}

}  // namespace

void add_drive(CLI::App& app, Context& context) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App* cmd =
      app.add_subcommand("drive",
                         "Drives one lap on OpenDRIVE roads: four tyres ask for the road surface 1000 times a second.\n"
                         "Reads roads.xodr (OpenDRIVE 1.4 - 1.8), writes DIR/lap.csv and DIR/report.html.");
  cmd->add_option("--network", arguments->network, "OpenDRIVE file")->required();
  cmd->add_option("-o,--output", arguments->out_dir, "output folder")->required();
  cmd->add_option("--route", arguments->drive.route.route,
                  "auto (a loop of raceways, else a good loop of 0.5 to 5 km), or names / OSM ids of ways with commas")
      ->capture_default_str();
  cmd->add_option("--via", arguments->via,
                  "x,y in metres of the site CRS; several: past these in order and back to the first");
  Driver& driver = arguments->drive.driver;
  cmd->add_option("--max-speed", driver.max_speed_mps, "top speed, m/s")
      ->check(CLI::Range(3.0, 120.0))
      ->capture_default_str();
  cmd->add_option("--max-lateral", driver.max_lateral_mps2, "lateral acceleration in bends, m/s^2")
      ->check(CLI::Range(0.5, 9.0))
      ->capture_default_str();
  cmd->footer(
      "Examples:\n"
      "  orthodrive drive --network out/roads.xodr -o out/drive\n"
      "  orthodrive drive --network roads.xodr --via 529900,5542300 --via 530400,5542800 --max-lateral 3 -o lap");
  cmd->callback([arguments, &context] { run(*arguments, context.monitor); });
}

}  // namespace orthodrive::app
