// orthodrive refine: OSM roads moved onto the road in the labels, or by the MRF baseline in the photo.

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <vector>

#include "commands.hpp"
#include "orthodrive/core/error.hpp"
#include "orthodrive/io/gpx_reader.hpp"
#include "orthodrive/io/raster_io.hpp"
#include "orthodrive/io/vector_io.hpp"
#include "orthodrive/io/weights_io.hpp"
#include "orthodrive/model/dense_nodes.hpp"
#include "orthodrive/pipeline/refine_files.hpp"
#include "orthodrive/refine/mrf_roads.hpp"
#include "orthodrive/refine/nlo_roads.hpp"
#include "orthodrive/refine/refine_roads.hpp"
#include "photo_site.hpp"

namespace orthodrive::app {
namespace {

struct RefineCommand {
  std::filesystem::path osm, labels, road_probability, weights_file, photo, forests, out;
  std::vector<std::filesystem::path> gpx;
  std::string method = "default", weights = "1+2", polygons = "smooth", driving_side = "right";
  RefineRoadsOptions options;
};

std::vector<NloPass> nlo_passes(const std::string& weights) {
  std::vector<NloPass> passes;
  if (weights != "2") passes.push_back(nlo_set_1);
  if (weights != "1") passes.push_back(nlo_set_2);
  return passes;
}

/// What the methods have in common of their results.
struct Refined {
  RoadNetwork roads;
  Findings findings;
};

Refined refine_in_photo(const RefineCommand& command, const Context& context) {
  if (command.photo.empty() || command.forests.empty() || !command.labels.empty() || !command.road_probability.empty())
    throw OptionError("refine: --method mrf reads --photo and --forests (`orthodrive forests` makes them) and no labels");
  const RoadForests forests = load_road_forests(io::read_file(command.forests), command.forests.string());
  const SiteFrame site = site_of_photo(command.photo);
  const PhotoSource photo = io::open_photo(command.photo, site, {.threads = context.threads});
  Findings findings;
  MrfRoadsResult result = refine_roads_mrf(
      io::read_osm_roads(command.osm, site, &findings), mrf_photo_evidence(photo, forests),
      {.polygons = command.polygons == "dp" ? RoadPolygons::douglas_peucker : RoadPolygons::smooth, .threads = context.threads},
      context.monitor);
  findings.insert(findings.end(), result.findings.begin(), result.findings.end());
  return {std::move(result.roads), std::move(findings)};
}

constexpr double node_distance_m = 2.0;  // as the default method's

Refined refine_in_labels(const RefineCommand& command, const Context& context) {
  if (command.labels.empty() || !command.photo.empty() || !command.forests.empty())
    throw OptionError("refine: needs --labels; --photo and --forests are for --method mrf");
  RefineRoadsOptions options = command.options;
  options.driving_side = command.driving_side == "left" ? DrivingSide::left : DrivingSide::right;
  options.threads = context.threads;
  if (!command.weights_file.empty()) options.weights = read_refine_weights(command.weights_file);
  const LabelMap labels = io::read_labels(command.labels);
  const SiteFrame site = labelled_site(command.labels, labels);
  Findings findings;
  const RoadNetwork osm = io::read_osm_roads(command.osm, site, &findings);
  const io::GpxTraces gpx = io::read_gpx(command.gpx, site);
  findings.insert(findings.end(), gpx.findings.begin(), gpx.findings.end());
  RefineRoadsResult result =
      command.method == "none" ? RefineRoadsResult{.roads = with_nodes_every(osm, node_distance_m)}
      : command.method == "nlo"
          ? refine_roads_nlo(osm, labels, {.passes = nlo_passes(command.weights), .threads = context.threads}, context.monitor)
          : refine_roads(osm, read_evidence(labels, command.road_probability), options, context.monitor, gpx.traces);
  findings.insert(findings.end(), result.findings.begin(), result.findings.end());
  return {std::move(result.roads), std::move(findings)};
}

void run(const RefineCommand& command, const Context& context) {
  if (command.method != "default" && !command.weights_file.empty())
    throw OptionError("--weights-file holds weights of the default method; leave out --method");
  if (command.method != "default" && !command.gpx.empty())
    throw OptionError("--gpx is for the default method, which alone knows GPS traces; leave out --method");
  const Refined result = command.method == "mrf" ? refine_in_photo(command, context) : refine_in_labels(command, context);
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
  cmd->add_option("--labels", command->labels, "label map of `orthodrive segment`: gives area and CRS; not for mrf");
  cmd->add_option("--road-probability", command->road_probability,
                  "of `orthodrive segment --road-probability`, on the grid of the labels: how sure each pixel is");
  cmd->add_option("-o,--output", command->out, "refined roads (GeoPackage)")->required();
  cmd->add_option("--method", command->method, "default; to compare with: nlo, the reference's, mrf, Mattyus et al. 2015, or none, the OSM roads as they are")
      ->check(CLI::IsMember({"default", "nlo", "mrf", "none"}))->capture_default_str();
  cmd->add_option("--weights", command->weights, "of nlo: the reference's weight set 1, 2, or one after the other")
      ->check(CLI::IsMember({"1", "2", "1+2"}))->capture_default_str();
  cmd->add_option("--weights-file", command->weights_file,
                  "of default: TOML file of weights, as `orthodrive tune` writes it; default: the shipped ones");
  cmd->add_option("--photo", command->photo, "of mrf: orthophoto, gives area and CRS");
  cmd->add_option("--forests", command->forests, "of mrf: what `orthodrive forests` learned");
  cmd->add_option("--polygons", command->polygons, "of mrf: borders by Douglas and Peucker (dp) or averaged (smooth)")
      ->check(CLI::IsMember({"dp", "smooth"}))->capture_default_str();
  cmd->add_option("--gpx", command->gpx, "of default: GPX tracks, for hidden roads and paths that OSM lacks; may be repeated");
  cmd->add_option("--driving-side", command->driving_side, "of the GPX tracks: right, left")
      ->check(CLI::IsMember({"right", "left"}))->capture_default_str();
  RefineRoadsOptions& o = command->options;
  cmd->add_option("--search-radius", o.search_radius_m, "of default: largest offset from the OSM line, m")
      ->check(CLI::Range(1.0, 50.0))->capture_default_str();
  cmd->add_option("--iterations", o.max_iterations, "of default: largest number of iterations")->check(CLI::Range(0, 1000))->capture_default_str();
  cmd->footer(
      "Reads roads and labels (mrf: roads and the photo); writes the layers centrelines, nodes and surface: centre line, offset, width and their\n"
      "standard deviations every 2 m (mrf: every 10 m, without standard deviations).\n"
      "Examples:\n"
      "  orthodrive refine --osm roads.osm --labels out/labels.tif -o roads.gpkg\n"
      "  orthodrive refine --osm roads.osm --labels out/labels.tif --gpx monday.gpx --gpx tuesday.gpx -o roads.gpkg\n"
      "  orthodrive refine --osm town.osm.pbf --labels labels.tif --search-radius 12 -o roads.gpkg\n"
      "  orthodrive refine --method mrf --osm roads.osm --photo ortho.tif --forests forests.yml -o roads.gpkg");
  cmd->callback([command, &context] { run(*command, context); });
}

}  // namespace orthodrive::app
