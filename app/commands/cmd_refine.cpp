// SPDX-License-Identifier: Apache-2.0
// orthodrive refine: OSM roads moved onto the road in the labels.

#include <memory>

#include "commands.hpp"
#include "driving_side_option.hpp"
#include "idle_options.hpp"
#include "stage_output.hpp"

namespace orthodrive::app {
namespace {
struct RefineCommand {
  std::filesystem::path osm;
  RefineFiles files;
  RunRefineOptions options;
  IdleOptions idle;
};

void add_options(CLI::App& cmd, RefineCommand& command) {
  RefineFiles& files = command.files;
  cmd.add_option("--labels", files.labels, "label map of `orthodrive segment`: gives area and CRS");
  cmd.add_option("--road-probability", files.road_probability,
                 "of `orthodrive segment --road-probability`, on the grid of the labels: how sure each pixel is");
  cmd.add_option("--alignment", files.alignment,
                 "of `orthodrive segment --alignment`: where a network that sees the map has the roads");
  cmd.add_option("--weights-file", files.weights,
                 "TOML file of weights, as `orthodrive tune` writes it; default: the shipped ones");
  CLI::Option* gpx =
      cmd.add_option("--gpx", files.gpx, "GPX tracks, for hidden roads and paths that OSM lacks; may be repeated");
  command.idle.needs(add_driving_side(&cmd, command.options.driving_side, "of the GPX tracks: right, left"), {gpx});
  RefineRoadsOptions& o = command.options.standard;
  cmd.add_option("--search-radius", o.search_radius_m, "largest offset from the OSM line, m")
      ->check(CLI::Range(1.0, 50.0))
      ->capture_default_str();
  cmd.add_option("--iterations", o.max_iterations, "largest number of iterations")
      ->check(CLI::Range(0, 1000))
      ->capture_default_str();
}
}  // namespace

void add_refine(CLI::App& app, Context& context) {
  auto command = std::make_shared<RefineCommand>();
  CLI::App* cmd =
      app.add_subcommand("refine", "Move OSM roads onto the road seen in the labels and measure their width.");
  cmd->add_option("--osm", command->osm, "OSM roads (.osm, .osm.pbf)")->required();
  cmd->add_option("-o,--output", command->files.roads, "refined roads (GeoPackage)")->required();
  add_options(*cmd, *command);
  cmd->footer(
      "Reads roads and labels; writes the layers centrelines, nodes and surface: centre line, offset, width and their\n"
      "standard deviations every 2 m.\n"
      "Examples:\n"
      "  orthodrive refine --osm roads.osm --labels out/labels.tif -o roads.gpkg\n"
      "  orthodrive refine --osm roads.osm --labels out/labels.tif --gpx monday.gpx --gpx tuesday.gpx -o roads.gpkg\n"
      "  orthodrive refine --osm town.osm.pbf --labels labels.tif --search-radius 12 -o roads.gpkg");
  cmd->callback([command, &context] {
    command->idle.refuse();
    command->files.osm = {command->osm};
    StageContext stage = stage_context(context);
    print_outcome(context.run_refine(command->files, command->options, stage), stage);
  });
}

}  // namespace orthodrive::app
