// SPDX-License-Identifier: Apache-2.0
// orthodrive refine --method: baselines to compare the default method with.

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "commands/idle_options.hpp"
#include "lab_commands.hpp"
#include "load_lab.hpp"
#include "orthodrive/core/error.hpp"

namespace orthodrive::app {
namespace {

struct RefineMethods {
  OtherRefineOptions other;
  std::string method = "default", nlo_weights = "1+2", polygons = "smooth";
  std::vector<double> width_factors;
  CLI::Option* chooser = nullptr;
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

void add_nlo_options(CLI::App* cmd, RefineMethods& command) {
  const auto of = [&command](CLI::Option* option, const std::vector<std::string>& methods) {
    return command.idle.read_for(option, command.chooser, methods);
  };
  NloRoadsOptions& nlo = command.other.nlo;
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

void add_mrf_options(CLI::App* cmd, RefineMethods& command) {
  const auto of = [&command](CLI::Option* option, const std::vector<std::string>& methods) {
    return command.idle.read_for(option, command.chooser, methods);
  };
  of(cmd->add_option("--photo", command.other.photo, "of mrf: orthophoto, gives area and CRS"), {"mrf"});
  of(cmd->add_option("--forests", command.other.forests, "of mrf: what `orthodrive forests` learned"), {"mrf"});
  of(cmd->add_option("--polygons", command.polygons, "of mrf: borders by Douglas and Peucker (dp) or averaged (smooth)")
         ->check(CLI::IsMember({"dp", "smooth"}))
         ->capture_default_str(),
     {"mrf"});
}

/// The options of the command that the default method and some of the others read.
void add_rules(CLI::App& cmd, RefineMethods& command) {
  const auto of = [&](const char* name, const std::vector<std::string>& methods, const std::string& more) {
    CLI::Option* option = cmd.get_option(name);
    option->description(option->get_description() + more);
    command.idle.read_for(option, command.chooser, methods);
  };
  of("--labels", {"default", "nlo", "none"}, "; not for mrf");
  for (const char* name : {"--road-probability", "--alignment", "--weights-file", "--gpx"}) of(name, {"default"}, "");
  const OtherRefineOptions& o = command.other;
  of("--search-radius", {"default", "nlo", "mrf"},
     fmt::format("; of nlo {}, of mrf {} where it is not given", o.nlo.max_offset_m, o.mrf.search_radius_m));
  of("--iterations", {"default", "nlo"},
     fmt::format("; of each pass of nlo {} where it is not given", nlo_set_1.max_iterations));
}

StageOutcome refine_by(RefineMethods& command, const CLI::App& cmd, const RefineFiles& files,
                       const RunRefineOptions& run, StageContext& stage) {
  OtherRefineOptions& other = command.other;
  other.method = command.method == "nlo"   ? RefineMethod::nlo
                 : command.method == "mrf" ? RefineMethod::mrf
                                           : RefineMethod::none;
  other.nlo.passes = nlo_passes(command.nlo_weights);
  if (command.width_factors.size() == 2)
    other.nlo.min_width_factor = command.width_factors[0], other.nlo.max_width_factor = command.width_factors[1];
  other.mrf.polygons = command.polygons == "dp" ? RoadPolygons::douglas_peucker : RoadPolygons::smooth;
  if (cmd.get_option("--search-radius")->count() > 0)
    other.nlo.max_offset_m = other.mrf.search_radius_m = run.standard.search_radius_m;
  if (cmd.get_option("--iterations")->count() > 0)
    for (NloPass& pass : other.nlo.passes) pass.max_iterations = run.standard.max_iterations;
  return lab_runs().run_refine_by(other, files, run, stage);
}

}  // namespace

void add_refine_methods(CLI::App& app, Context& context) {
  auto command = std::make_shared<RefineMethods>();
  CLI::App* cmd = app.get_subcommand("refine");
  command->chooser =
      cmd->add_option(
             "--method", command->method,
             "default; to compare with: nlo, the reference's, mrf, Mattyus et al. 2015, or none, the OSM roads "
             "as they are")
          ->check(CLI::IsMember({"default", "nlo", "mrf", "none"}))
          ->capture_default_str();
  add_rules(*cmd, *command);
  add_nlo_options(cmd, *command);
  add_mrf_options(cmd, *command);
  cmd->footer(
      cmd->get_footer() +
      "\n"
      "  orthodrive refine --method nlo --weights 1+2 --osm roads.osm --labels labels.tif -o roads.gpkg\n"
      "  orthodrive refine --method mrf --osm roads.osm --photo ortho.tif --forests forests.yml -o roads.gpkg\n"
      "The method mrf reads roads and the photo, gives area and CRS by it, and has nodes every 10 m; nlo and mrf state "
      "no standard\n"
      "deviations.");
  context.run_refine = [command, cmd, by_default = context.run_refine](
                           const RefineFiles& files, const RunRefineOptions& run, StageContext& stage) {
    command->idle.refuse();
    return command->method == "default" ? by_default(files, run, stage) : refine_by(*command, *cmd, files, run, stage);
  };
}

}  // namespace orthodrive::app
