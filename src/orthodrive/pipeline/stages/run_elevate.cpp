// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/pipeline/stages/run_elevate.hpp"

#include <fmt/format.h>

#include "orthodrive/core/error.hpp"
#include "orthodrive/io/support/vector_io.hpp"
#include "orthodrive/io/vector/road_graph_io.hpp"
#include "orthodrive/pipeline/sources/catalogue.hpp"
#include "orthodrive/roads/dense_nodes.hpp"

namespace orthodrive {
namespace fs = std::filesystem;

namespace {
constexpr double map_step_m = 5.0;  // of the map's lines in the road graph: they follow the ground

/// The hull of the roads: a box would ask for terrain in corners that a slanting area does not have.
SiteFrame site_of_roads(const fs::path& file, const RoadNetwork& roads) {
  Ring points;
  for (const RoadPath& path : roads.paths)
    for (const RoadNode& node : path.nodes) points.push_back(node.p);
  if (points.empty()) throw InputError(file.string(), "has no road; refine an area with roads");
  return {roads.crs, {convex_hull(std::move(points)), {}}};
}

StageOutcome outcome_of(const ElevateRoadsResult& elevated, const ElevateFiles& files) {
  StageOutcome outcome{.numbers = {{"gradient_energy_of_terrain", elevated.before.gradient},
                                   {"gradient_energy", elevated.after.gradient},
                                   {"height_error_energy_m2", elevated.after.height_error_m2},
                                   {"banking_measured_share", elevated.banking_measured_share},
                                   {"converged", elevated.solve.converged},
                                   {"iterations", elevated.solve.iterations}}};
  if (!files.drive_logs.empty()) {
    outcome.numbers["driven_m"] = elevated.logged_m;
    outcome.numbers["driven_on_roads_m"] = elevated.logged_on_roads_m;
    outcome.summary.push_back(fmt::format("drive logs: {:.0f} of {:.0f} m on roads, roughness of {} stretches",
                                          elevated.logged_on_roads_m, elevated.logged_m, elevated.roughness.size()));
  }
  outcome.summary.push_back(fmt::format(
      "{}: mean squared gradient E_RG {:.3e} (terrain {:.3e}), mean squared height difference E_h {:.3f} m2, "
      "banking measured at {:.0f} % of the nodes",
      files.elevated.string(), elevated.after.gradient, elevated.before.gradient, elevated.after.height_error_m2,
      100.0 * elevated.banking_measured_share));
  return outcome;
}
}  // namespace

StageOutcome run_elevate(const ElevateFiles& files, const RunElevateOptions& options, StageContext& context) {
  const RoadNetwork roads = io::read_roads(files.roads);
  const SiteFrame site = options.site ? *options.site : site_of_roads(files.roads, roads);
  const Terrain& terrain = context.sources.terrain(files.dtm, site);
  const io::DriveLogs& logs = context.sources.drive_logs(files.drive_logs, site);
  ElevateRoadsOptions elevate = options.elevate;
  const io::ControlPoints& control = context.sources.control_points(files.control_points, site);
  elevate.banking.driving_side = driving_side_in(options.driving_side, site.crs, bounds_of(site.area.outer));
  elevate.heights.control_points = control.points;
  elevate.heights.threads = elevate.banking.threads = context.threads;
  const ElevateRoadsResult elevated = elevate_roads(roads, terrain.dtms, logs.log, elevate, context.monitor);
  StageOutcome outcome = outcome_of(elevated, files);
  if (!files.control_points.empty()) outcome.numbers["control_points"] = control.points.size();
  for (const Findings* part : {&logs.findings, &control.findings, &terrain.findings, &elevated.findings})
    append(outcome.findings, *part);
  io::write_roads(files.elevated, elevated.roads, elevated.roughness);
  if (!files.findings.empty()) io::write_findings(files.findings, outcome.findings, roads.crs);
  if (!files.road_graph.empty())
    io::write_road_graph(files.road_graph, with_nodes_every(context.sources.osm(files.osm, site).roads, map_step_m),
                         elevated.roads);
  return outcome;
}

BuildStage elevate_stage(SiteBuild& build) {
  const Site& site = build.site;
  Sources::Files log_files;
  for (const fs::path& log : site.drive_logs)
    for (const fs::path& file : io::drive_log_files(log)) log_files.push_back(file);
  nlohmann::json options = frame_options(site.frame);
  options["elevate.sampling"] = site.dtm_sampling;
  options["refine.driving_side"] = to_string(site.driving_side);
  return {.name = "elevate",
          .version = 9,
          // The road graph shows the map's roads as well.
          .sources = {{"dtm", site.dtm, SourceRole::Kind::raster},
                      {"drive_logs", log_files},
                      {"control_points", site.control_points},
                      {"osm", site.osm}},
          .options = options,
          .reads = {".orthodrive/refined.gpkg"},
          .outputs = {"roads.gpkg", "road_graph.geojson"},
          .check =
              [&build, &site] {
                (void)build.context.sources.drive_logs(site.drive_logs, site.frame);
                (void)build.context.sources.control_points(site.control_points, site.frame);
                (void)build.context.sources.terrain(site.dtm, site.frame);
              },
          .run =
              [&build, &site] {
                RunElevateOptions options{.site = site.frame};
                options.elevate.heights.sampling =
                    site.dtm_sampling == "cubic" ? HeightSampling::cubic : HeightSampling::bilinear;
                options.driving_side = site.driving_side;
                return run_elevate({.roads = build.out_dir / ".orthodrive/refined.gpkg",
                                    .dtm = site.dtm,
                                    .drive_logs = site.drive_logs,
                                    .control_points = site.control_points,
                                    .elevated = build.out_dir / "roads.gpkg",
                                    .osm = site.osm,
                                    .road_graph = build.out_dir / "road_graph.geojson"},
                                   options, build.context);
              }};
}

}  // namespace orthodrive
