// SPDX-License-Identifier: Apache-2.0
// orthodrive elevate: heights and gradients for refined roads.

#include <memory>

#include "choice_option.hpp"
#include "commands.hpp"
#include "driving_side_option.hpp"
#include "stage_output.hpp"

namespace orthodrive::app {
namespace {
struct ElevateCommand {
  ElevateFiles files;
  RunElevateOptions options;
};
}  // namespace

void add_elevate(CLI::App& app, Context& context) {
  auto command = std::make_shared<ElevateCommand>();
  ElevateFiles& files = command->files;
  CLI::App* cmd = app.add_subcommand("elevate", "Give roads a smooth height profile and banking from terrain models.");
  cmd->add_option("--roads", files.roads, "roads of `orthodrive refine` (GeoPackage)")->required();
  cmd->add_option("--dtm", files.dtm, "bare-earth terrain models, best first; later ones fill holes of the earlier")
      ->required();
  cmd->add_option(
      "--log", files.drive_logs,
      "drive logs (CSV, or folder of a comma2k19 segment) for gradient, banking and roughness; may be repeated");
  cmd->add_option("--control-points", files.control_points,
                  "known heights of roads and clearances of decks (points of GeoJSON or GeoPackage); may be repeated");
  cmd->add_option("-o,--output", files.elevated, "roads with heights (GeoPackage); may be the input")->required();
  cmd->add_option("--findings", files.findings, "also write what was odd, as GeoJSON points");
  ElevateOptions& o = command->options.elevate.heights;
  add_choice<HeightSampling>(*cmd, "--sampling", o.sampling,
                             {{"bilinear", HeightSampling::bilinear}, {"cubic", HeightSampling::cubic}},
                             "how heights are taken between the terrain's pixels");
  cmd->add_option("--clearance", o.clearance_m, "least height of a bridge over the road below, m")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  add_driving_side(cmd, command->options.driving_side,
                   "right, left: one-way roads fall to that edge where nothing is measured");
  cmd->footer(
      "Reads roads, terrain, control points and drive logs if there are any; writes the roads with z, gradient, "
      "banking and\n"
      "crown and their standard deviations. Banking and crown are measured where terrain "
      "of 2 m or\n"
      "finer shows them, else taken from design rules (banking_source). Where a log was driven: banking with the "
      "source 'log'\n"
      "and a layer of roughness (ISO 8608) as well. Fields of a control point: z_m (of the road) or clearance_m (of a "
      "deck over\n"
      "the road below), and where known sigma_m (0.05), osm_id, layer.\n"
      "Examples:\n"
      "  orthodrive elevate --roads roads.gpkg --dtm dtm.tif -o roads.gpkg\n"
      "  orthodrive elevate --roads roads.gpkg --dtm dtm_1m.tif --dtm dtm_10m.tif --sampling bilinear -o "
      "roads_3d.gpkg\n"
      "  orthodrive elevate --roads roads.gpkg --dtm dtm.tif --control-points heights.geojson -o roads_3d.gpkg\n"
      "  orthodrive elevate --roads roads.gpkg --dtm dtm.tif --log monday.csv --log comma2k19/segment -o "
      "roads_3d.gpkg");
  cmd->callback([command, &context] {
    StageContext stage = stage_context(context);
    print_outcome(context.run_elevate(command->files, command->options, stage), stage);
  });
}

}  // namespace orthodrive::app
