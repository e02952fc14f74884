// orthodrive elevate: heights and gradients for refined roads.

#include <fmt/format.h>

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "commands.hpp"
#include "orthodrive/core/error.hpp"
#include "orthodrive/elevate/elevate_roads.hpp"
#include "orthodrive/io/drive_log_io.hpp"
#include "orthodrive/io/raster_io.hpp"
#include "orthodrive/io/vector_io.hpp"

namespace orthodrive::app {
namespace {

struct ElevateCommand {
  std::filesystem::path roads, out, findings;
  std::vector<std::filesystem::path> dtm, logs;
  ElevateRoadsOptions options;
};

/// The hull of the roads: a box would ask for terrain in corners that a slanting area does not have.
SiteFrame site_of(const std::filesystem::path& file, const RoadNetwork& roads) {
  Ring points;
  for (const RoadPath& path : roads.paths)
    for (const RoadNode& node : path.nodes) points.push_back(node.p);
  if (points.empty()) throw InputError(file.string(), "has no road; refine an area with roads");
  return {roads.crs, {convex_hull(std::move(points)), {}}};
}

void run(const ElevateCommand& command, const Context& context) {
  const RoadNetwork roads = io::read_roads(command.roads);
  Findings findings;
  const std::vector<HeightGrid> dtms =
      io::read_dtms(command.dtm, site_of(command.roads, roads), {.least_coverage = io::least_site_coverage}, &findings);
  const io::DriveLogs logs = io::read_drive_logs(command.logs, site_of(command.roads, roads));
  ElevateRoadsOptions options = command.options;
  options.heights.threads = context.threads;
  const ElevateRoadsResult result = elevate_roads(roads, dtms, logs.log, options, context.monitor);
  for (const Findings& more : {logs.findings, result.findings}) findings.insert(findings.end(), more.begin(), more.end());
  if (!command.logs.empty())
    context.monitor->info(fmt::format("drive logs: {:.0f} of {:.0f} m on roads, roughness of {} stretches",
                                      result.logged_on_roads_m, result.logged_m, result.roughness.size()));
  io::write_roads(command.out, result.roads, result.roughness);
  if (!command.findings.empty()) io::write_findings(command.findings, findings, roads.crs);
  for (const Finding& finding : findings) context.monitor->info(fmt::format("{}: {}", finding.code, finding.message));
  context.monitor->info(fmt::format("{}: mean squared gradient E_RG {:.3e} (terrain {:.3e}), mean squared height difference E_h {:.3f} m2, "
                                    "cross-fall measured at {:.0f} % of the nodes",
                                    command.out.string(), result.after.gradient, result.before.gradient, result.after.height_error_m2,
                                    100.0 * result.cross_fall_measured_share));
}

}  // namespace

void add_elevate(CLI::App& app, Context& context) {
  auto command = std::make_shared<ElevateCommand>();
  CLI::App* cmd = app.add_subcommand("elevate", "Give roads a smooth height profile and cross-fall from terrain models.");
  cmd->add_option("--roads", command->roads, "roads of `orthodrive refine` (GeoPackage)")->required();
  cmd->add_option("--dtm", command->dtm, "bare-earth terrain models, best first; later ones fill holes of the earlier")->required();
  cmd->add_option("--log", command->logs, "drive logs (CSV, or folder of a comma2k19 segment) for gradient, banking and roughness; may be repeated");
  cmd->add_option("-o,--output", command->out, "roads with heights (GeoPackage); may be the input")->required();
  cmd->add_option("--findings", command->findings, "also write what was odd, as GeoJSON points");
  const std::map<std::string, HeightSampling> samplings{{"bilinear", HeightSampling::bilinear}, {"cubic", HeightSampling::cubic}};
  cmd->add_option("--sampling", command->options.heights.sampling, "how heights are taken between the terrain's pixels")
      ->transform(CLI::CheckedTransformer(samplings))->default_str("cubic");
  ElevateOptions& o = command->options.heights;
  const std::map<std::string, HeightMethod> methods{{"default", HeightMethod::network},
                                                    {"reference", HeightMethod::reference},
                                                    {"moving-average", HeightMethod::moving_average}};
  cmd->add_option("--method", o.method,
                  "default: the whole network at once, C2, within the limits of the road classes; reference: the thesis' "
                  "optimisation, way by way; moving-average: of the terrain along each way")
      ->transform(CLI::CheckedTransformer(methods))->default_str("default");
  CLI::Option* window = cmd->add_option("--window", o.window, "samples of the moving average, odd; 1 is the terrain as sampled")
      ->check(CLI::PositiveNumber)->capture_default_str();
  cmd->add_option("--clearance", o.clearance_m, "least height of a bridge over the road below, m")
      ->check(CLI::NonNegativeNumber)->capture_default_str();
  cmd->add_flag("--drives-left", command->options.cross_fall.drives_left, "one-way roads fall to their left edge where nothing is measured");
  cmd->footer(
      "Reads roads, terrain and drive logs if there are any; writes the roads with z, gradient, banking and crown and their\n"
      "standard deviations (of z: default method only). Banking and crown are measured where terrain of 2 m or finer shows them,\n"
      "else taken from design rules (banking_source). Where a log was driven: banking with the source 'log' and a layer of\n"
      "roughness (ISO 8608) as well.\n"
      "Examples:\n"
      "  orthodrive elevate --roads roads.gpkg --dtm dtm.tif -o roads.gpkg\n"
      "  orthodrive elevate --roads roads.gpkg --dtm dtm_1m.tif --dtm dtm_10m.tif --sampling bilinear -o roads_3d.gpkg\n"
      "  orthodrive elevate --roads roads.gpkg --dtm dtm.tif --method moving-average --window 35 -o averaged.gpkg\n"
      "  orthodrive elevate --roads roads.gpkg --dtm dtm.tif --log monday.csv --log comma2k19/segment -o roads_3d.gpkg");
  cmd->callback([command, window, &context] {
    if (window->count() > 0 && command->options.heights.method != HeightMethod::moving_average)
      throw OptionError("--window is the moving average's; give --method moving-average with it");
    run(*command, context);
  });
}

}  // namespace orthodrive::app
