// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/pipeline/stages/run_network.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "orthodrive/core/error.hpp"
#include "orthodrive/evaluate/networks/compare_surfaces.hpp"
#include "orthodrive/io/opendrive/opendrive_io.hpp"
#include "orthodrive/io/support/vector_io.hpp"
#include "orthodrive/io/vector/network_layers.hpp"
#include "orthodrive/network/lanes/lanes.hpp"
#include "orthodrive/pipeline/score/network_verdict.hpp"
#include "orthodrive/pipeline/sources/catalogue.hpp"
#include "orthodrive/pipeline/stages/road_relief.hpp"

namespace orthodrive {
namespace fs = std::filesystem;

namespace {
CrgFilesResult write_surfaces(NetworkResult& network, const RoadNetwork& roads, const NetworkFiles& files,
                              const RunNetworkOptions& options, int threads) {
  CrgFilesOptions crg = options.crg;
  if (crg.roads.empty() && options.old_surfaces == OldSurfaces::remove) fs::remove_all(crg_folder(files.network));
  if (crg.roads.empty()) return {};
  crg.threads = threads;
  const RoadRelief relief(roads, io::read_roughness(files.roads), 2.0 * std::max(crg.u_step_m, crg.v_step_m));
  crg.relief_of = [&](const roadquery::Road& road) { return relief.of(network.map, road); };
  return write_crg_files(network.map, files.network, crg);
}

/// Reads the file back: what simulators get has to be the surface that was built.
std::string check_file(const fs::path& file, const roadquery::RoadMap& built) {
  constexpr double same_m = 1e-3;
  const SurfaceComparison comparison = compare_surfaces(built, roadquery::read_opendrive(file.string()));
  if (comparison.missing_roads > 0 || !(comparison.max_distance_m <= same_m))
    throw Error(
        fmt::format("{}: read back, {} roads are missing and the surface of road {} at {:.1f} m lies {:.6f} m off",
                    file.string(), comparison.missing_roads, comparison.road, comparison.s, comparison.max_distance_m));
  return fmt::format("{}: read back, {} points of the surface lie within {:.1e} m", file.string(), comparison.points,
                     comparison.max_distance_m);
}

std::string junction_line(const network::JunctionSurfaceSummary& s, const std::string& file) {
  return fmt::format(
      "{}: {} junction surfaces of {:.0f} m2 in {} heights; connecting roads that differed by up to {:.3f} m in one "
      "place lie within {:.3f} m of them (before: {:.3f} m)",
      file, s.junctions, s.area_m2, s.grid_nodes, s.max_disagreement_m, s.max_road_off_after_m,
      s.max_road_off_before_m);
}

nlohmann::json junction_numbers(const network::JunctionSurfaceSummary& s) {
  return {{"surfaces", s.junctions},
          {"area_m2", s.area_m2},
          {"heights", s.grid_nodes},
          {"max_disagreement_m", s.max_disagreement_m},
          {"max_road_off_before_m", s.max_road_off_before_m},
          {"max_road_off_after_m", s.max_road_off_after_m}};
}

StageOutcome outcome_of(const NetworkResult& network, const CrgFilesResult& crg, const std::string& file) {
  const std::vector<roadquery::Road>& roads = network.map.roads;
  double length_m = 0.0;
  for (const roadquery::Road& road : roads) length_m += road.length;
  const auto connecting =
      std::count_if(roads.begin(), roads.end(), [](const roadquery::Road& road) { return road.junction >= 0; });
  nlohmann::json surface_km = nlohmann::json::object();  // of the roads outside junctions
  for (const roadquery::Road& road : roads)
    if (road.junction < 0) {
      nlohmann::json& sum = surface_km[roadquery::to_string(network::surface_of(road))];
      sum = sum.is_null() ? road.length / 1e3 : sum.get<double>() + road.length / 1e3;
    }
  return {.numbers = {{"roads", roads.size()},
                      {"junctions", network.map.junctions.size()},
                      {"length_m", length_m},
                      {"surface_km", std::move(surface_km)},
                      {"crg_files", crg.files},
                      {"max_plan_deviation_m", network.max_plan_deviation_m},
                      {"max_elevation_error_m", network.max_elevation_error_m},
                      {"junction_surfaces", junction_numbers(network.junction_surfaces)}},
          .findings = network.findings,
          .summary = {
              fmt::format("{}: chains of {:.3f} km fitted with {} elements", file, network.chain_length_m / 1e3,
                          network.chain_elements),
              fmt::format("{}: {} roads, {} junctions with {} connecting roads; nodes lie within {:.3f} m of "
                          "the lines and {:.3f} m of the profiles",
                          file, static_cast<std::ptrdiff_t>(roads.size()) - connecting, network.map.junctions.size(),
                          connecting, network.max_plan_deviation_m, network.max_elevation_error_m),
              junction_line(network.junction_surfaces, file)}};
}

void add_verdict(const roadquery::RoadMap& map, StageContext& context, StageOutcome& outcome) {
  const NetworkVerdict verdict =
      judge_network(map, {.threads = context.threads, .exchange = context.exchange}, context.monitor);
  outcome.numbers["verdict"] = to_json(verdict);
  append(outcome.findings, findings_of(verdict));
  outcome.summary.push_back(summary_of(verdict));
}

NetworkResult network_of(const RoadNetwork& roads, const NetworkFiles& files, const RunNetworkOptions& options,
                         StageContext& context) {
  BuildNetworkOptions of_network = options.network;
  of_network.threads = context.threads;
  of_network.exchange = context.exchange;
  if (!options.country.empty()) check_country(options.country);
  const bool is_told = options.driving_side && !options.country.empty();
  const PlaceRules here = is_told || roads.paths.empty() ? PlaceRules{} : rules_at(roads.crs, bounds_of_roads(roads));
  of_network.driving_side = options.driving_side.value_or(here.driving_side);
  of_network.speed_laws = read_speed_laws(catalogue_folder());
  of_network.speed_laws.here = options.country.empty() ? here.country : options.country;
  of_network.road_marks = read_road_marks(catalogue_folder());
  of_network.road_marks.here = of_network.speed_laws.here;
  if (of_network.name.empty()) of_network.name = files.network.stem().string();
  return build_network(roads, of_network, context.monitor);
}
}  // namespace

StageOutcome run_network(const NetworkFiles& files, const RunNetworkOptions& options, StageContext& context) {
  const RoadNetwork roads = io::read_roads(files.roads);
  NetworkResult network = network_of(roads, files, options, context);
  if (network.map.roads.empty())
    throw InputError(files.roads.string(),
                     "no path of it is long enough for a road; has the layer 'nodes' any points?");

  const CrgFilesResult crg = write_surfaces(network, roads, files, options, context.threads);
  if (crg.files > 0)
    context.info(fmt::format("{}: {} OpenCRG surfaces of {:.2f} km of road", crg_folder(files.network).string(),
                             crg.files, crg.length_m / 1e3));
  io::write_opendrive(files.network, network.map,
                      {.minor_version = options.opendrive_minor_version,
                       .absolute = options.absolute,
                       .junction_grids = options.junction_grids});
  if (options.check) context.info(check_file(files.network, network.map));
  if (!files.layers.empty()) io::write_network_layers(files.layers, network.map);
  if (!files.geojson.empty()) io::write_network_geojson(files.geojson, network.map);
  StageOutcome outcome = outcome_of(network, crg, files.network.string());
  if (options.judge) add_verdict(network.map, context, outcome);
  if (!files.findings.empty()) io::write_findings(files.findings, outcome.findings, roads.crs);
  return outcome;
}

void help_network(const NetworkFiles& files, const RunNetworkOptions& options, StageContext& context) {
  const NetworkResult network = network_of(io::read_roads(files.roads), files, options, context);
  if (!options.judge || !options.crg.roads.empty()) return;  // OpenCRG surfaces are of the map that is judged
  (void)judge_network(network.map, {.threads = context.threads, .exchange = context.exchange}, context.monitor);
}

BuildStage network_stage(SiteBuild& build) {
  const Site& site = build.site;
  const bool surfaces = !site.crg.empty();
  const NetworkFiles files{.roads = build.out_dir / "roads.gpkg", .network = build.out_dir / "roads.xodr"};
  const RunNetworkOptions run{.network = {.name = site.name, .weather = site.weather},
                              .driving_side = site.driving_side,
                              .country = site.country,
                              .crg = {.roads = site.crg, .route = site.route},
                              .old_surfaces = OldSurfaces::remove,
                              .opendrive_minor_version = site.opendrive == "1.8" ? 8 : 7,
                              .junction_grids = site.junction_grids,
                              .judge = true};
  return {.name = "network",
          .version = 12,
          .options = {{"name", site.name},
                      {"area.country", site.country},
                      {"refine.driving_side", to_string(site.driving_side)},
                      {"network.crg", site.crg},
                      {"network.opendrive", site.opendrive},
                      {"network.weather", to_string(site.weather)},
                      {"drive.route", surfaces ? site.route : ""},  // counts where surfaces are made of it
                      {"network.junction_grids", site.junction_grids}},
          .reads = {"roads.gpkg"},
          .outputs =
              surfaces ? std::vector<std::string>{"roads.xodr", "roads_crg"} : std::vector<std::string>{"roads.xodr"},
          .run = [=, &build] { return run_network(files, run, build.context); },
          .help = [=, &build] { help_network(files, run, build.context); }};
}

}  // namespace orthodrive
