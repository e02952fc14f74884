// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <filesystem>
#include <memory>

#include "commands.hpp"
#include "load_runs.hpp"
#include "orthodrive/core/stop.hpp"

namespace orthodrive::app {
namespace {
/// "refine    runs: option refine.driving_side was "right", is "left""
std::string line_of(const StageForecast& forecast) {
  using Fate = StageForecast::Fate;
  const StageChanges& changes = forecast.changes;
  const auto text = [&]() -> std::string {
    switch (forecast.fate) {
      case Fate::taken_over:
        return "taken over";
      case Fate::depends:
        return fmt::format("runs unless {} come{} out as before", fmt::join(changes.unknown, ", "),
                           changes.unknown.size() == 1 ? "s" : "");
      case Fate::runs:
        return fmt::format("runs: {}", fmt::join(changes.reasons, "; "));
    }
    return {};
  };
  return fmt::format("{:<9} {}", forecast.stage, text());
}

void explain(const Site& site, const std::filesystem::path& out) {
  for (const StageForecast& forecast : runs().explain_build(site, out)) fmt::print("{}\n", line_of(forecast));
  fmt::print("{:<9} runs: it always does\n", "report");
}
}  // namespace

void add_build(CLI::App& app, Context& context) {
  struct Arguments {
    std::filesystem::path site, out;
    std::vector<std::string> overrides;
    bool explain = false;
  };
  auto args = std::make_shared<Arguments>();
  CLI::App* cmd =
      app.add_subcommand("build", "All stages in order: from a site file to a scene, a road network and a driven lap.");
  cmd->add_option("site", args->site, "site file (TOML): area, sources, options")->required();
  cmd->add_option("-o,--output", args->out, "folder for the results; created when missing")->required();
  cmd->add_option("--set", args->overrides, "override of the site file, section.key=value; may be repeated");
  cmd->add_flag("--explain", args->explain,
                "say of each stage whether it would run and why, on standard output; runs and writes nothing");
  cmd->footer(
      "Reads the site file and its sources. Writes labels.tif confidence.tif roads.gpkg road_graph.geojson roads.xodr "
      "scene/\n"
      "drive/ report.html findings.geojson run.json. Stages whose inputs, options and version are unchanged are taken "
      "over; a killed run\n"
      "goes on. Ctrl-C ends it within 2 s (exit code 130); the same command goes on. A second build into the folder is "
      "refused.\n"
      "Needs about 1.5 GB for 10 km2 and 2.5 GB for 100 km2 of a city at 0.5 m/px; `orthodrive plan` estimates time, "
      "memory and "
      "disk.\n\n"
      "Examples:\n"
      "  orthodrive build sites/kvarnbyn.toml -o out/kvarnbyn\n"
      "  orthodrive build site.toml -o out --explain --set elevate.sampling=bilinear\n"
      "  orthodrive build site.toml -o out --set drive.route=\"Circuit\" --set elevate.sampling=bilinear");
  cmd->callback([args, &context, &app] {
    const Site site = runs().read_site(args->site, args->overrides);
    if (args->explain) return explain(site, args->out);
    const StopOnSignals stoppable({.last_words = [&context] { context.last_words(Stopped(0).what()); }});
    runs().fetch_what_lacks(site, context.monitor);
    runs().build_site(site, args->out,
                      {.threads = context.threads, .version = app.version(), .at_stage = context.set_stage},
                      context.monitor);
    fmt::print("{}\n", (args->out / "report.html").string());
  });
}

}  // namespace orthodrive::app
