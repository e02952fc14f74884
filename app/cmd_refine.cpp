// SPDX-License-Identifier: Apache-2.0
// orthodrive refine: OSM roads moved onto the road in the labels, or by the MRF baseline in the photo.

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "commands.hpp"
#include "driving_side_option.hpp"
#include "load_runs.hpp"
#include "stage_output.hpp"

namespace orthodrive::app {
namespace {

struct RefineCommand {
  std::filesystem::path osm;
  RefineFiles files;
  RunRefineOptions options;
  std::string method = "default", nlo_weights = "1+2", polygons = "smooth";
};

std::vector<NloPass> nlo_passes(const std::string& weights) {
  std::vector<NloPass> passes;
  if (weights != "2") passes.push_back(nlo_set_1);
  if (weights != "1") passes.push_back(nlo_set_2);
  return passes;
}

void refine_it(RefineCommand& command, const Context& context) {
  static const std::map<std::string, RefineMethod> methods{{"default", RefineMethod::standard},
                                                           {"nlo", RefineMethod::nlo},
                                                           {"mrf", RefineMethod::mrf},
                                                           {"none", RefineMethod::none}};
  command.files.osm = {command.osm};
  command.options.method = methods.at(command.method);
  command.options.nlo_passes = nlo_passes(command.nlo_weights);
  command.options.mrf_polygons = command.polygons == "dp" ? RoadPolygons::douglas_peucker : RoadPolygons::smooth;
  StageContext stage = stage_context(context);
  print_outcome(runs().run_refine(command.files, command.options, stage), stage);
}

}  // namespace

void add_refine(CLI::App& app, Context& context) {
  auto command = std::make_shared<RefineCommand>();
  CLI::App* cmd =
      app.add_subcommand("refine", "Move OSM roads onto the road seen in the labels and measure their width.");
  cmd->add_option("--osm", command->osm, "OSM roads (.osm, .osm.pbf)")->required();
  cmd->add_option("--labels", command->files.labels,
                  "label map of `orthodrive segment`: gives area and CRS; not for mrf");
  cmd->add_option("--road-probability", command->files.road_probability,
                  "of `orthodrive segment --road-probability`, on the grid of the labels: how sure each pixel is");
  cmd->add_option("--alignment", command->files.alignment,
                  "of `orthodrive segment --alignment`: where a network that sees the map has the roads");
  cmd->add_option("-o,--output", command->files.roads, "refined roads (GeoPackage)")->required();
  cmd->add_option(
         "--method", command->method,
         "default; to compare with: nlo, the reference's, mrf, Mattyus et al. 2015, or none, the OSM roads as they are")
      ->check(CLI::IsMember({"default", "nlo", "mrf", "none"}))
      ->capture_default_str();
  cmd->add_option("--weights", command->nlo_weights, "of nlo: the reference's weight set 1, 2, or one after the other")
      ->check(CLI::IsMember({"1", "2", "1+2"}))
      ->capture_default_str();
  cmd->add_option("--weights-file", command->files.weights,
                  "of default: TOML file of weights, as `orthodrive tune` writes it; default: the shipped ones");
  cmd->add_option("--photo", command->files.photo, "of mrf: orthophoto, gives area and CRS");
  cmd->add_option("--forests", command->files.forests, "of mrf: what `orthodrive forests` learned");
  cmd->add_option("--polygons", command->polygons, "of mrf: borders by Douglas and Peucker (dp) or averaged (smooth)")
      ->check(CLI::IsMember({"dp", "smooth"}))
      ->capture_default_str();
  cmd->add_option("--gpx", command->files.gpx,
                  "of default: GPX tracks, for hidden roads and paths that OSM lacks; may be repeated");
  add_driving_side(cmd, command->options.standard.driving_side, "of the GPX tracks: right, left");
  RefineRoadsOptions& o = command->options.standard;
  cmd->add_option("--search-radius", o.search_radius_m, "of default: largest offset from the OSM line, m")
      ->check(CLI::Range(1.0, 50.0))
      ->capture_default_str();
  cmd->add_option("--iterations", o.max_iterations, "of default: largest number of iterations")
      ->check(CLI::Range(0, 1000))
      ->capture_default_str();
  cmd->footer(
      "Reads roads and labels (mrf: roads and the photo); writes the layers centrelines, nodes and surface: centre "
      "line, offset, width and their\n"
      "standard deviations every 2 m (mrf: every 10 m, without standard deviations).\n"
      "Examples:\n"
      "  orthodrive refine --osm roads.osm --labels out/labels.tif -o roads.gpkg\n"
      "  orthodrive refine --osm roads.osm --labels out/labels.tif --gpx monday.gpx --gpx tuesday.gpx -o roads.gpkg\n"
      "  orthodrive refine --osm town.osm.pbf --labels labels.tif --search-radius 12 -o roads.gpkg\n"
      "  orthodrive refine --method mrf --osm roads.osm --photo ortho.tif --forests forests.yml -o roads.gpkg");
  cmd->callback([command, &context] { refine_it(*command, context); });
}

}  // namespace orthodrive::app
