// SPDX-License-Identifier: Apache-2.0
// orthodrive refine: OSM roads moved onto the road in the labels, or by the MRF baseline in the photo.

#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "commands.hpp"
#include "driving_side_option.hpp"
#include "idle_options.hpp"
#include "load_runs.hpp"
#include "stage_output.hpp"

namespace orthodrive::app {
namespace {

struct RefineCommand {
  std::filesystem::path osm;
  RefineFiles files;
  RunRefineOptions options;
  std::string method = "default", nlo_weights = "1+2", polygons = "smooth";
  std::optional<double> search_radius_m;  ///< each method has its own default
  std::optional<int> iterations;
  std::vector<double> width_factors;
  CLI::Option* method_option = nullptr;
  IdleOptions idle;
};

/// "1+2": one pass after the other, each a set of the reference's or four weights: "10,1,0.2,0.2".
std::vector<NloPass> nlo_passes(const std::string& text) {
  std::vector<NloPass> passes;
  for (const std::string& pass : CLI::detail::split(text + '+', '+')) {
    NloPass weights = pass == "2" ? nlo_set_2 : nlo_set_1;
    if (pass != "1" && pass != "2") {
      const std::vector<std::string> words = CLI::detail::split(pass + ',', ',');
      std::array<double, 4> numbers{};
      bool good = words.size() == numbers.size();
      for (std::size_t i = 0; good && i < numbers.size(); ++i)
        good = CLI::detail::lexical_cast(words[i], numbers[i]) && std::isfinite(numbers[i]);
      if (!good)
        throw OptionError(fmt::format(
            "--weights {}: '{}' is neither set 1 nor 2 nor four numbers w_c,w_a,w_w,w_o such as 10,1,0.2,0.2", text,
            pass));
      weights = {numbers[0], numbers[1], numbers[2], numbers[3]};
    }
    passes.push_back(weights);
  }
  return passes;
}

void refine_it(RefineCommand& command, const Context& context) {
  static const std::map<std::string, RefineMethod> methods{{"default", RefineMethod::standard},
                                                           {"nlo", RefineMethod::nlo},
                                                           {"mrf", RefineMethod::mrf},
                                                           {"none", RefineMethod::none}};
  command.idle.refuse();
  RunRefineOptions& options = command.options;
  command.files.osm = {command.osm};
  options.method = methods.at(command.method);
  options.nlo.passes = nlo_passes(command.nlo_weights);
  if (command.width_factors.size() == 2)
    options.nlo.min_width_factor = command.width_factors[0], options.nlo.max_width_factor = command.width_factors[1];
  options.mrf.polygons = command.polygons == "dp" ? RoadPolygons::douglas_peucker : RoadPolygons::smooth;
  if (command.search_radius_m)
    options.standard.search_radius_m = options.nlo.max_offset_m = options.mrf.search_radius_m =
        *command.search_radius_m;
  if (command.iterations) {
    options.standard.max_iterations = *command.iterations;
    for (NloPass& pass : options.nlo.passes) pass.max_iterations = *command.iterations;
  }
  StageContext stage = stage_context(context);
  print_outcome(runs().run_refine(command.files, options, stage), stage);
}

void add_nlo_options(CLI::App* cmd, RefineCommand& command) {
  const auto of = [&command](CLI::Option* option, const std::vector<std::string>& methods) {
    return command.idle.read_for(option, command.method_option, methods);
  };
  NloRoadsOptions& nlo = command.options.nlo;
  of(cmd->add_option("--weights", command.nlo_weights,
                     "of nlo: passes with the reference's set 1 or 2, or w_c,w_a,w_w,w_o, one after the other: 1+1")
         ->capture_default_str(),
     {"nlo"});
  of(cmd->add_option("--width-factors", command.width_factors,
                     fmt::format("of nlo: widths from this to that many times the map's; default: {} {}",
                                 nlo.min_width_factor, nlo.max_width_factor))
         ->expected(2),
     {"nlo"});
  of(cmd->add_option("--strip", nlo.strip_m, "of nlo: width of the strips on both sides of a border, m")
         ->check(CLI::Range(0.1, 20.0))
         ->capture_default_str(),
     {"nlo"});
  of(cmd->add_option("--spacing", nlo.spacing_m, "of nlo: distance of nodes, m")
         ->check(CLI::Range(0.2, 100.0))
         ->capture_default_str(),
     {"nlo"});
  of(cmd->add_option("--unlabelled-cost", nlo.unlabelled_cost, "of nlo: what a pixel without a label costs in a road")
         ->check(CLI::Range(0.0, 1.0))
         ->capture_default_str(),
     {"nlo"});
  of(cmd->add_flag("--filter-and-join", nlo.filter_and_join,
                   "of nlo: the reference's filter of the curvature, then junctions by the rank of their roads"),
     {"nlo"});
}

void add_mrf_options(CLI::App* cmd, RefineCommand& command) {
  const auto of = [&command](CLI::Option* option, const std::vector<std::string>& methods) {
    return command.idle.read_for(option, command.method_option, methods);
  };
  of(cmd->add_option("--photo", command.files.photo, "of mrf: orthophoto, gives area and CRS"), {"mrf"});
  of(cmd->add_option("--forests", command.files.forests, "of mrf: what `orthodrive forests` learned"), {"mrf"});
  of(cmd->add_option("--polygons", command.polygons, "of mrf: borders by Douglas and Peucker (dp) or averaged (smooth)")
         ->check(CLI::IsMember({"dp", "smooth"}))
         ->capture_default_str(),
     {"mrf"});
}

/// Of the default method, and what others read as well.
void add_standard_options(CLI::App* cmd, RefineCommand& command) {
  const auto of = [&command](CLI::Option* option, const std::vector<std::string>& methods) {
    return command.idle.read_for(option, command.method_option, methods);
  };
  const RunRefineOptions& o = command.options;
  of(cmd->add_option("--labels", command.files.labels,
                     "label map of `orthodrive segment`: gives area and CRS; not for mrf"),
     {"default", "nlo", "none"});
  of(cmd->add_option("--road-probability", command.files.road_probability,
                     "of `orthodrive segment --road-probability`, on the grid of the labels: how sure each pixel is"),
     {"default"});
  of(cmd->add_option("--alignment", command.files.alignment,
                     "of `orthodrive segment --alignment`: where a network that sees the map has the roads"),
     {"default"});
  of(cmd->add_option("--weights-file", command.files.weights,
                     "of default: TOML file of weights, as `orthodrive tune` writes it; default: the shipped ones"),
     {"default"});
  CLI::Option* gpx =
      of(cmd->add_option("--gpx", command.files.gpx,
                         "of default: GPX tracks, for hidden roads and paths that OSM lacks; may be repeated"),
         {"default"});
  command.idle.needs(add_driving_side(cmd, command.options.driving_side, "of the GPX tracks: right, left"), {gpx});
  of(cmd->add_option("--search-radius", command.search_radius_m,
                     fmt::format("largest offset from the OSM line, m; default: {}, of nlo {}, of mrf {}",
                                 o.standard.search_radius_m, o.nlo.max_offset_m, o.mrf.search_radius_m))
         ->check(CLI::Range(1.0, 50.0)),
     {"default", "nlo", "mrf"});
  of(cmd->add_option("--iterations", command.iterations,
                     fmt::format("largest number of iterations; default: {}, of each pass of nlo {}",
                                 o.standard.max_iterations, nlo_set_1.max_iterations))
         ->check(CLI::Range(0, 1000)),
     {"default", "nlo"});
}

}  // namespace

void add_refine(CLI::App& app, Context& context) {
  auto command = std::make_shared<RefineCommand>();
  CLI::App* cmd =
      app.add_subcommand("refine", "Move OSM roads onto the road seen in the labels and measure their width.");
  cmd->add_option("--osm", command->osm, "OSM roads (.osm, .osm.pbf)")->required();
  cmd->add_option("-o,--output", command->files.roads, "refined roads (GeoPackage)")->required();
  command->method_option =
      cmd->add_option(
             "--method", command->method,
             "default; to compare with: nlo, the reference's, mrf, Mattyus et al. 2015, or none, the OSM roads "
             "as they are")
          ->check(CLI::IsMember({"default", "nlo", "mrf", "none"}))
          ->capture_default_str();
  add_standard_options(cmd, *command);
  add_nlo_options(cmd, *command);
  add_mrf_options(cmd, *command);
  cmd->footer(
      "Reads roads and labels (mrf: roads and the photo); writes the layers centrelines, nodes and surface: centre "
      "line, offset, width and their\n"
      "standard deviations every 2 m (mrf: every 10 m, without standard deviations).\n"
      "Examples:\n"
      "  orthodrive refine --osm roads.osm --labels out/labels.tif -o roads.gpkg\n"
      "  orthodrive refine --osm roads.osm --labels out/labels.tif --gpx monday.gpx --gpx tuesday.gpx -o roads.gpkg\n"
      "  orthodrive refine --osm town.osm.pbf --labels labels.tif --search-radius 12 -o roads.gpkg\n"
      "  orthodrive refine --method nlo --weights 1+2 --osm roads.osm --labels labels.tif -o roads.gpkg\n"
      "  orthodrive refine --method mrf --osm roads.osm --photo ortho.tif --forests forests.yml -o roads.gpkg");
  cmd->callback([command, &context] { refine_it(*command, context); });
}

}  // namespace orthodrive::app
