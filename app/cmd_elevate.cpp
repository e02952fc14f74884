// orthodrive elevate: heights and gradients for refined roads.

#include <fmt/format.h>

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "commands.hpp"
#include "orthodrive/core/error.hpp"
#include "orthodrive/elevate/estimate_profiles.hpp"
#include "orthodrive/io/raster_io.hpp"
#include "orthodrive/io/vector_io.hpp"

namespace orthodrive::app {
namespace {

struct ElevateCommand {
  std::filesystem::path roads, out;
  std::vector<std::filesystem::path> dtm;
  ElevateOptions options;
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
  const std::vector<HeightGrid> dtms = io::read_dtms(command.dtm, site_of(command.roads, roads));
  ElevateOptions options = command.options;
  options.threads = context.threads;
  const EstimateProfilesResult result = estimate_profiles(roads, dtms, options, context.monitor);
  io::write_roads(command.out, result.roads);
  for (const Finding& finding : result.findings) context.monitor->info(fmt::format("{}: {}", finding.code, finding.message));
  context.monitor->info(fmt::format("{}: mean squared gradient E_RG {:.3e} (terrain {:.3e}), mean squared height difference E_h {:.3f} m2",
                                    command.out.string(), result.after.gradient, result.before.gradient, result.after.height_error_m2));
}

}  // namespace

void add_elevate(CLI::App& app, Context& context) {
  auto command = std::make_shared<ElevateCommand>();
  CLI::App* cmd = app.add_subcommand("elevate", "Give roads a smooth height profile from terrain models.");
  cmd->add_option("--roads", command->roads, "roads of `orthodrive refine` (GeoPackage)")->required();
  cmd->add_option("--dtm", command->dtm, "bare-earth terrain models, best first; later ones fill holes of the earlier")->required();
  cmd->add_option("-o,--output", command->out, "roads with heights (GeoPackage); may be the input")->required();
  const std::map<std::string, HeightSampling> samplings{{"bilinear", HeightSampling::bilinear}, {"cubic", HeightSampling::cubic}};
  cmd->add_option("--sampling", command->options.sampling, "how heights are taken between the terrain's pixels")
      ->transform(CLI::CheckedTransformer(samplings))->default_str("cubic");
  ElevateOptions& o = command->options;
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
  cmd->footer(
      "Reads roads and terrain; writes the roads with z, gradient and the standard deviation of z (default method only).\n"
      "Examples:\n"
      "  orthodrive elevate --roads roads.gpkg --dtm dtm.tif -o roads.gpkg\n"
      "  orthodrive elevate --roads roads.gpkg --dtm dtm_1m.tif --dtm dtm_10m.tif --sampling bilinear -o roads_3d.gpkg\n"
      "  orthodrive elevate --roads roads.gpkg --dtm dtm.tif --method moving-average --window 35 -o averaged.gpkg");
  cmd->callback([command, window, &context] {
    if (window->count() > 0 && command->options.method != HeightMethod::moving_average)
      throw OptionError("--window is the moving average's; give --method moving-average with it");
    run(*command, context);
  });
}

}  // namespace orthodrive::app
