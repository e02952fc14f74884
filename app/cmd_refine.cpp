// orthodrive refine: OSM roads moved onto the road in the labels.

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <vector>

#include "commands.hpp"
#include "orthodrive/core/error.hpp"
#include "orthodrive/io/raster_io.hpp"
#include "orthodrive/io/vector_io.hpp"
#include "orthodrive/pipeline/refine_files.hpp"
#include "orthodrive/refine/nlo_roads.hpp"
#include "orthodrive/refine/refine_roads.hpp"

namespace orthodrive::app {
namespace {

struct RefineCommand {
  std::filesystem::path osm, labels, road_probability, weights_file, out;
  std::string method = "default", weights = "1+2";
  RefineRoadsOptions options;
};

std::vector<NloPass> nlo_passes(const std::string& weights) {
  std::vector<NloPass> passes;
  if (weights != "2") passes.push_back(nlo_set_1);
  if (weights != "1") passes.push_back(nlo_set_2);
  return passes;
}

void run(const RefineCommand& command, const Context& context) {
  if (command.method != "default" && !command.weights_file.empty())
    throw OptionError("--weights-file holds weights of the default method; leave out --method");
  RefineRoadsOptions options = command.options;
  options.threads = context.threads;
  if (!command.weights_file.empty()) options.weights = read_refine_weights(command.weights_file);
  const LabelMap labels = io::read_labels(command.labels);
  const RoadNetwork osm = io::read_osm_roads(command.osm, labelled_site(command.labels, labels));
  const RefineRoadsResult result =
      command.method == "none" ? RefineRoadsResult{.roads = osm}
      : command.method == "nlo"
          ? refine_roads_nlo(osm, labels, {.passes = nlo_passes(command.weights), .threads = context.threads}, context.monitor)
          : refine_roads(osm, read_evidence(labels, command.road_probability), options, context.monitor);
  io::write_roads(command.out, result.roads);

  double offset_m = 0.0;
  std::size_t nodes = 0;
  for (const RoadPath& path : result.roads.paths)
    for (const RoadNode& node : path.nodes) offset_m += std::abs(node.offset_m), ++nodes;
  for (const Finding& finding : result.findings) context.monitor->info(fmt::format("{}: {}", finding.code, finding.message));
  context.monitor->info(fmt::format("{}: {} ways, {} nodes, moved by {:.2f} m on average", command.out.string(),
                                    result.roads.paths.size(), nodes, offset_m / static_cast<double>(std::max<std::size_t>(1, nodes))));
}

}  // namespace

void add_refine(CLI::App& app, Context& context) {
  auto command = std::make_shared<RefineCommand>();
  CLI::App* cmd = app.add_subcommand("refine", "Move OSM roads onto the road seen in the labels and measure their width.");
  cmd->add_option("--osm", command->osm, "OSM roads (.osm, .osm.pbf)")->required();
  cmd->add_option("--labels", command->labels, "label map of `orthodrive segment`: gives area and CRS")->required();
  cmd->add_option("--road-probability", command->road_probability,
                  "of `orthodrive segment --road-probability`, on the grid of the labels: how sure each pixel is");
  cmd->add_option("-o,--output", command->out, "refined roads (GeoPackage)")->required();
  cmd->add_option("--method", command->method, "default; to compare with: nlo, the reference's, or none, the OSM roads as they are")
      ->check(CLI::IsMember({"default", "nlo", "none"}))->capture_default_str();
  cmd->add_option("--weights", command->weights, "of nlo: the reference's weight set 1, 2, or one after the other")
      ->check(CLI::IsMember({"1", "2", "1+2"}))->capture_default_str();
  cmd->add_option("--weights-file", command->weights_file,
                  "of default: TOML file of weights, as `orthodrive tune` writes it; default: the shipped ones");
  RefineRoadsOptions& o = command->options;
  cmd->add_option("--search-radius", o.search_radius_m, "of default: largest offset from the OSM line, m")
      ->check(CLI::Range(1.0, 50.0))->capture_default_str();
  cmd->add_option("--iterations", o.max_iterations, "of default: largest number of iterations")->check(CLI::Range(0, 1000))->capture_default_str();
  cmd->footer(
      "Reads roads and labels; writes the layers centrelines, nodes and surface: centre line, offset, width and their\n"
      "standard deviations every 2 m.\n"
      "Examples:\n"
      "  orthodrive refine --osm roads.osm --labels out/labels.tif -o roads.gpkg\n"
      "  orthodrive refine --osm town.osm.pbf --labels labels.tif --search-radius 12 -o roads.gpkg");
  cmd->callback([command, &context] { run(*command, context); });
}

}  // namespace orthodrive::app
