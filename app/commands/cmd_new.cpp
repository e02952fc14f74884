// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <filesystem>
#include <memory>

#include "commands.hpp"
#include "idle_options.hpp"
#include "load_runs.hpp"

namespace orthodrive::app {

void add_new(CLI::App& app, Context& context) {
  auto args = std::make_shared<RunNewOptions>();
  auto idle = std::make_shared<IdleOptions>();
  CLI::App* cmd = app.add_subcommand("new", "A site file for a place on earth, from the catalogue of open sources.");
  auto* bbox = cmd->add_option("--bbox", args->bbox, "west,south,east,north in degrees of WGS84");
  auto* place = cmd->add_option("--place", args->place, "GeoJSON file with the polygon of the place");
  auto* relation = cmd->add_option("--relation", args->relation, "OSM relation whose area it is; needs --osm");
  auto* osm = cmd->add_option("--osm", args->relation_file, "OSM file (.osm, .osm.pbf) that holds the relation");
  relation->needs(osm);
  idle->needs(osm, {relation});
  idle->excludes(place, {bbox});
  idle->excludes(relation, {bbox, place});
  CLI::Option* list = cmd->add_flag("--list", args->list, "print the sources for the area, or all, and write nothing");
  const auto of_file = [&](CLI::Option* option) { return idle->excludes(option, {list}); };
  of_file(cmd->add_option("--name", args->site.name, "name of the site; without it, that of the file"));
  CLI::Option* photo =
      of_file(cmd->add_option("--photo", args->site.photos,
                              "source of the photo; without it, the best for the area; may be repeated, best first"));
  CLI::Option* terrain = of_file(cmd->add_option("--terrain", args->site.terrain, "source of the terrain"));
  CLI::Option* osm_source = of_file(cmd->add_option("--osm-source", args->site.osm, "source of the roads"));
  CLI::Option* photo_file = of_file(cmd->add_option("--photo-file", args->photo_files,
                                                    "local photo in place of a source; may be repeated, best first"));
  idle->excludes(osm_source,
                 {of_file(cmd->add_option("--osm-file", args->osm_file, "local OSM file in place of a source"))});
  idle->excludes(terrain,
                 {of_file(cmd->add_option("--dtm-file", args->dtm_files,
                                          "local terrain in place of a source; may be repeated, best first"))});
  CLI::Option* finest =
      of_file(cmd->add_option("--finest", args->site.finest_m, "photos are fetched no finer than this, m/px")
                  ->check(CLI::Range(0.05, 5.0))
                  ->capture_default_str());
  idle->excludes(photo, {photo_file});
  idle->excludes(finest, {photo_file});
  cmd->add_option("--catalogue", args->catalogue, "folder with another catalogue (docs/new.md)");
  of_file(cmd->add_option("-o,--output", args->out, "site file to write"));
  of_file(cmd->add_flag("--force", args->force, "replace the site file when it is there"));
  cmd->footer(
      "Reads the catalogue and, where given, the polygon or the OSM file. Writes one site file. Needs no network:\n"
      "`orthodrive fetch` gets the sources that it names.\n\n"
      "Examples:\n"
      "  orthodrive new --bbox 14.44,50.07,14.47,50.09 -o vinohrady.toml\n"
      "  orthodrive new --place lake.geojson --photo at-basemap -o lake.toml\n"
      "  orthodrive new --relation 439840 --osm praha.osm.pbf --osm-file praha.osm.pbf -o praha.toml\n"
      "  orthodrive new --list --bbox 11.5,48.1,11.6,48.2");
  cmd->callback([args, idle, &context] {
    idle->refuse();
    const RunNewResult result = runs().run_new(*args);
    for (const Finding& finding : result.findings)
      context.monitor->info(
          fmt::format("{}: {}", finding.severity == Severity::info ? "note" : "warning", finding.message));
    fmt::print("{}", result.text);
  });
}

}  // namespace orthodrive::app
