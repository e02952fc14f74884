// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/pipeline/stages/run_drive.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <map>
#include <optional>

#include "orthodrive/core/atomic_file.hpp"
#include "orthodrive/core/error.hpp"
#include "orthodrive/core/find_resource.hpp"
#include "orthodrive/drive/drive_all_roads.hpp"
#include "orthodrive/drive/drive_route.hpp"
#include "orthodrive/model/roads/highway_class.hpp"
#include "orthodrive/pipeline/files/read_network.hpp"
#include "orthodrive/pipeline/stages/bare_road_finding.hpp"
#include "orthodrive/report/lap_exchange.hpp"
#include "orthodrive/report/lap_report.hpp"
#include "orthodrive/report/lap_table.hpp"
#include "roadquery/crg/road_crgs.hpp"
#include "roadquery/query/road_query.hpp"
#include "roadquery/surface/road_surface.hpp"
#include "vehicle/read_car.hpp"

namespace orthodrive {
namespace fs = std::filesystem;
namespace {

fs::path vehicle_file(const std::string& name) {
  static const std::map<std::string, std::string> presets = {
      {"family", "family_car.toml"}, {"sports", "sports_car.toml"}, {"gt3", "gt3_like.toml"}};
  const auto preset = presets.find(name);
  if (preset == presets.end()) return name;
  return find_resource(resource_folders("models/vehicles", "models/vehicles"), preset->second, "vehicle " + name,
                       "give --vehicle a file");
}

vehicle::CarParameters read_vehicle(const std::string& name) {
  const fs::path file = vehicle_file(name);
  try {
    return vehicle::read_car(file);
  } catch (const std::runtime_error& error) {
    throw Error(error.what());
  }
}

bool mostly_raceway(const roadquery::RoadMap& map, const Route& route) {
  double raceway_m = 0.0;
  for (const RouteStep& step : route.steps) {
    const roadquery::Road& road = map.roads[static_cast<std::size_t>(step.road)];
    if (is_raceway(road.highway)) raceway_m += road.length;
  }
  return raceway_m > 0.5 * route.length_m;
}

DriveOptions drive_options(const RunDriveOptions& options, DrivingStyle style) {
  const bool racing = style != DrivingStyle::road;
  DriveOptions drive;
  drive.car = read_vehicle(options.vehicle == "auto" ? (racing ? "sports" : "family") : options.vehicle);
  drive.style = style;
  if (racing) drive.driver = racing_driver();
  if (options.max_speed_mps) drive.driver.max_speed_mps = *options.max_speed_mps;
  if (options.max_lateral_mps2) drive.driver.max_lateral_mps2 = *options.max_lateral_mps2;
  drive.standing_start = options.standing_start, drive.stops = options.stops, drive.laps = options.laps;
  drive.step_s = 1e-3 * options.step_ms;
  return drive;
}

nlohmann::json numbers_of(const DriveResult& drive) {
  return {{"route", drive.route.name},
          {"closed", drive.route.closed},
          {"finished", drive.finished},
          {"vehicle", drive.car.name},
          {"length_m", drive.length_m},
          {"lap_time_s", drive.lap_time_s},
          {"max_speed_mps", drive.max_speed_mps},
          {"max_lateral_mps2", drive.max_lateral_mps2},
          {"max_vertical_mps2", drive.max_vertical_mps2},
          {"max_gradient", drive.max_gradient},
          {"min_gradient", drive.min_gradient},
          {"climb_m", drive.climb_m},
          {"fuel_kg", drive.fuel_kg},
          {"max_line_error_m", drive.max_line_error_m},
          {"tyre_queries", drive.tyre_queries},
          {"tyre_queries_per_s", drive.tyre_queries_per_s()},
          {"off_road_share", drive.off_road_share},
          {"max_height_step_m", drive.max_height_step_m}};
}

/// None where nobody can say where on Earth the lap lies: a finding says why.
std::optional<std::string> gpx_of(const roadquery::RoadMap& map, const DriveResult& drive, Findings& findings) {
  std::string why = "the network has no geoReference";
  try {
    if (!map.geo_reference.empty()) return lap_gpx(drive, map.geo_reference);
  } catch (const Error& error) {
    why = fmt::format("the lap cannot be placed on Earth by the network's geoReference ({})", error.what());
  }
  const DriveSample start = drive.samples.empty() ? DriveSample{} : drive.samples.front();
  findings.push_back({.severity = Severity::info,
                      .code = "drive.no_gpx",
                      .message = why + ": there is no lap.gpx",
                      .x_m = start.x_m,
                      .y_m = start.y_m});
  return std::nullopt;
}

void write_drive(const DriveFiles& files, const roadquery::RoadMap& map, const DriveResult& drive, Findings& findings) {
  write_text_file(files.folder / "lap.csv", lap_csv(drive));
  write_text_file(files.folder / "cycle.csv", cycle_csv(drive));
  const fs::path network = fs::relative(fs::absolute(files.network), fs::absolute(files.folder));
  write_text_file(files.folder / "lap.xosc", lap_openscenario(drive, network.generic_string()));
  if (const std::optional<std::string> gpx = gpx_of(map, drive, findings))
    write_text_file(files.folder / "lap.gpx", *gpx);
  write_text_file(files.folder / "report.html", lap_report_html(map, drive));
  if (!files.plots.empty()) write_text_file(files.plots, fmt::format("{}", fmt::join(lap_plots(map, drive), "\n")));
}

/// Where an OpenCRG file begins or ends within a road and leaves a step.
Findings crg_findings(const roadquery::RoadMap& map) {
  constexpr double least_m = 0.02;  // as drive.bump
  Findings findings;
  for (const roadquery::CrgStep& step : find_crg_steps(map, *map.crgs, least_m)) {
    const roadquery::Road& road = map.roads[static_cast<std::size_t>(step.road)];
    const roadquery::SurfacePoint at = roadquery::surface_point(road, step.s, step.t);
    findings.push_back({.code = "drive.crg_step",
                        .message = fmt::format("an OpenCRG file of road {} leaves a step of {:.3f} m at s = {:.1f} m",
                                               road.id, step.step_m, step.s),
                        .x_m = at.x,
                        .y_m = at.y});
  }
  return findings;
}

/// What the drive cannot do with the network, said with its file.
template <typename Work>
auto with_file(const DriveFiles& files, const Work& work) {
  try {
    return work();
  } catch (const OptionError&) {
    throw;
  } catch (const Error& error) {
    throw InputError(files.network.string(), error.what());
  }
}

StageOutcome run_all_roads(const DriveFiles& files, const roadquery::RoadMap& map, const RunDriveOptions& options,
                           StageContext& context) {
  const DriveOptions drive_as = drive_options(options, DrivingStyle::road);
  const AllRoadsResult all =
      with_file(files, [&] { return drive_all_roads(map, drive_as, context.threads, context.monitor); });
  std::string csv = "code,x_m,y_m,message\n";
  for (const Finding& f : all.findings)
    csv += fmt::format("{},{:.2f},{:.2f},\"{}\"\n", f.code, f.x_m, f.y_m, f.message);
  write_text_file(files.folder / "all_roads.csv", csv);
  StageOutcome outcome{.numbers = {{"routes", all.routes},
                                   {"routes_finished", all.finished},
                                   {"routes_too_short", all.too_short},
                                   {"routes_m", all.routes_m},
                                   {"length_m", all.length_m},
                                   {"driven_s", all.driven_s},
                                   {"max_vertical_mps2", all.max_vertical_mps2},
                                   {"max_height_step_m", all.max_height_step_m},
                                   {"tyre_queries", all.tyre_queries},
                                   {"tyre_misses", all.tyre_misses},
                                   {"off_road_places", all.off_road_places},
                                   {"jolt_places", all.jolt_places},
                                   {"bump_places", all.bump_places},
                                   {"too_tight_places", all.too_tight_places}},
                       .findings = all.findings};
  write_text_file(files.folder / "all_roads.json", outcome.numbers.dump(1) + "\n");
  outcome.summary = {
      fmt::format("{} routes of {:.1f} km, {} driven to the end, {} too short to drive", all.routes,
                  1e-3 * all.routes_m, all.finished, all.too_short),
      fmt::format("places: {} off the road, {} above 5 m/s2 vertically (most {:.1f}), {} with a step (most {:.3f} m)",
                  all.off_road_places, all.jolt_places, all.max_vertical_mps2, all.bump_places, all.max_height_step_m),
      fmt::format("bends too tight for the car: {}", all.too_tight_places),
      fmt::format("{:.0f} s simulated, {:.0f} times real time", all.driven_s,
                  all.wall_s > 0.0 ? all.driven_s / all.wall_s : 0.0)};
  return outcome;
}

StageOutcome drive_map(const DriveFiles& files, const roadquery::RoadMap& map, const RunDriveOptions& options,
                       StageContext& context) {
  if (options.all_roads) return run_all_roads(files, map, options, context);
  const Route route = with_file(files, [&] { return find_route(map, options.route); });
  if (!route.closed && (options.laps > 1 || options.standing_start))
    throw OptionError(fmt::format("{} changes nothing: the route {} is not closed, so it has no laps",
                                  options.laps > 1 ? "--laps" : "--standing-start", route.name));
  const DrivingStyle usual = mostly_raceway(map, route) ? DrivingStyle::racing : DrivingStyle::road;
  const roadquery::RoadQuery query(map);
  const DriveOptions drive_as = drive_options(options, options.style.value_or(usual));
  const EnvelopeTable envelope(drive_as.car);
  const DriveResult drive =
      with_file(files, [&] { return drive_route(query, route, drive_as, envelope, context.monitor); });
  StageOutcome outcome{.numbers = numbers_of(drive), .findings = drive.findings};
  write_drive(files, map, drive, outcome.findings);
  for (const auto& [label, value] : lap_numbers(drive)) outcome.summary.push_back(fmt::format("{}: {}", label, value));
  return outcome;
}

}  // namespace

StageOutcome run_drive(const DriveFiles& files, const RunDriveOptions& run_options, StageContext& context) {
  RunDriveOptions options = run_options;
  Findings odd;
  roadquery::RoadMap map = read_network(files.network, odd);
  if (const auto bare = widen_bare_roads(map, options.bare_width_m, "drive")) {
    odd.push_back(*bare);
    if (!options.style) options.style = DrivingStyle::centre;
  }
  roadquery::load_crgs(map, files.network.string());
  append(odd, crg_findings(map));
  if (options.flat) map = flattened(std::move(map));
  StageOutcome outcome = drive_map(files, map, options, context);
  outcome.findings.insert(outcome.findings.begin(), odd.begin(), odd.end());
  return outcome;
}

BuildStage drive_stage(SiteBuild& build) {
  const Site& site = build.site;
  const std::vector<std::string> network =
      site.crg.empty() ? std::vector<std::string>{"roads.xodr"} : std::vector<std::string>{"roads.xodr", "roads_crg"};
  return {.name = "drive",
          .version = 3,
          .sources = {{"vehicle", {vehicle_file("family"), vehicle_file("sports")}}},
          .options = {{"drive.route", site.route}},
          .reads = network,
          .outputs = {"drive", ".orthodrive/lap_plots.html"},
          .run = [&build, &site] {
            return run_drive({.network = build.out_dir / "roads.xodr",
                              .folder = build.out_dir / "drive",
                              .plots = build.out_dir / ".orthodrive/lap_plots.html"},
                             {.route = {.route = site.route}}, build.context);
          }};
}

}  // namespace orthodrive
