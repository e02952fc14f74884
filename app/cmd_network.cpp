// orthodrive network: roads with widths and heights as OpenDRIVE.

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <memory>

#include "commands.hpp"
#include "orthodrive/core/error.hpp"
#include "orthodrive/evaluate/compare_surfaces.hpp"
#include "orthodrive/io/network_layers.hpp"
#include "orthodrive/io/opendrive_io.hpp"
#include "orthodrive/io/vector_io.hpp"
#include "orthodrive/network/build_network.hpp"
#include "orthodrive/pipeline/crg_files.hpp"
#include "orthodrive/pipeline/road_relief.hpp"

namespace orthodrive::app {
namespace {

struct NetworkCommand {
  std::filesystem::path roads, out, findings, layers, geojson;
  BuildNetworkOptions options;
  std::string opendrive = "1.7", crg_format = "KRBI";
  bool absolute = false;
  CrgFilesOptions crg;
  bool check = false;
};

/// Reads the file back: what simulators get has to be the surface that was built.
void check_file(const std::filesystem::path& file, const roadquery::RoadMap& built, Monitor& monitor) {
  constexpr double same_m = 1e-3;
  const SurfaceComparison comparison = compare_surfaces(built, roadquery::read_opendrive(file.string()));
  if (comparison.missing_roads > 0 || !(comparison.max_distance_m <= same_m))
    throw Error(
        fmt::format("{}: read back, {} roads are missing and the surface of road {} at {:.1f} m lies {:.6f} m off",
                    file.string(), comparison.missing_roads, comparison.road, comparison.s, comparison.max_distance_m));
  monitor.info(fmt::format("{}: read back, {} points of the surface lie within {:.1e} m", file.string(),
                           comparison.points, comparison.max_distance_m));
}

void run(const NetworkCommand& command, const Context& context) {
  BuildNetworkOptions options = command.options;
  options.threads = context.threads;
  if (options.name.empty()) options.name = command.out.stem().string();
  const RoadNetwork roads = io::read_roads(command.roads);
  NetworkResult result = build_network(roads, options, context.monitor);
  if (result.map.roads.empty())
    throw InputError(command.roads.string(), "no path of it is long enough for a road; has the layer 'nodes' any points?");
  CrgFilesOptions crg = command.crg;
  crg.format = crg_format_of(command.crg_format);
  crg.threads = context.threads;
  const RoadRelief relief(roads, crg.roads.empty() ? std::vector<RoughnessStretch>{} : io::read_roughness(command.roads),
                          2.0 * std::max(crg.u_step_m, crg.v_step_m));
  crg.relief_of = [&](const roadquery::Road& road) { return relief.of(result.map, road); };
  if (const CrgFilesResult surfaces = write_crg_files(result.map, command.out, crg); surfaces.files > 0)
    context.monitor->info(fmt::format("{}: {} OpenCRG surfaces of {:.2f} km of road", crg_folder(command.out).string(),
                                      surfaces.files, surfaces.length_m / 1e3));
  io::write_opendrive(command.out, result.map, {.minor_version = command.opendrive == "1.8" ? 8 : 7, .absolute = command.absolute});
  if (command.check) check_file(command.out, result.map, *context.monitor);
  if (!command.layers.empty()) io::write_network_layers(command.layers, result.map);
  if (!command.geojson.empty()) io::write_network_geojson(command.geojson, result.map);
  if (!command.findings.empty()) io::write_findings(command.findings, result.findings, roads.crs);
  std::map<std::string, int> counts;
  for (const Finding& finding : result.findings) ++counts[finding.code];
  for (const auto& [code, count] : counts) context.monitor->info(fmt::format("{}: {} places", code, count));
  const auto connecting = std::count_if(result.map.roads.begin(), result.map.roads.end(),
                                        [](const roadquery::Road& road) { return road.junction >= 0; });
  context.monitor->info(fmt::format("{}: chains of {:.3f} km fitted with {} elements", command.out.string(),
                                    result.chain_length_m / 1e3, result.chain_elements));
  context.monitor->info(fmt::format(
      "{}: {} roads, {} junctions with {} connecting roads; nodes lie within {:.3f} m of the lines and {:.3f} m of the profiles",
      command.out.string(), static_cast<std::ptrdiff_t>(result.map.roads.size()) - connecting, result.map.junctions.size(),
      connecting, result.max_plan_deviation_m, result.max_elevation_error_m));
}

}  // namespace

void add_network(CLI::App& app, Context& context) {
  auto command = std::make_shared<NetworkCommand>();
  CLI::App* cmd = app.add_subcommand("network", "Write roads as OpenDRIVE 1.7 or 1.8: lines, arcs and clothoids, profiles, lanes, junctions.");
  cmd->add_option("--roads", command->roads, "roads with widths and heights (GeoPackage of refine and elevate)")->required();
  cmd->add_option("-o,--output", command->out, "OpenDRIVE file to write (.xodr)")->required();
  cmd->add_option("--findings", command->findings, "also write what was odd, as GeoJSON points");
  cmd->add_option("--opendrive", command->opendrive, "version of the file")->check(CLI::IsMember({"1.7", "1.8"}))->capture_default_str();
  cmd->add_flag("--absolute", command->absolute,
                "write coordinates of the CRS, for readers that get the header's <offset> wrong (SUMO 1.15)");
  cmd->add_flag("--check", command->check, "read the file back; an error when its surface is not the same within 1 mm");
  cmd->add_option("--layers", command->layers, "also write reference lines, lanes and junctions as a GeoPackage");
  cmd->add_option("--geojson", command->geojson, "also write the same as GeoJSON (WGS84)");
  cmd->add_option("--crg", command->crg.roads,
                  "also write OpenCRG surfaces of these roads into NAME_crg/ beside the output and refer to them:\n"
                  "ids of roads, way/ID of OSM ways, all-of-route, all; separated by commas")
      ->delimiter(',');
  cmd->add_option("--route", command->crg.route, "for all-of-route: as --route of drive")->capture_default_str();
  cmd->add_option("--crg-format", command->crg_format, "KRBI, KDBI (binary, 4 or 8 bytes a value), LRFI or LDFI (text)")
      ->capture_default_str();
  cmd->add_option("--crg-u-step", command->crg.u_step_m, "m, largest step of the grid along the road")
      ->check(CLI::Range(0.01, 10.0))
      ->capture_default_str();
  cmd->add_option("--crg-v-step", command->crg.v_step_m, "m, step of the grid across the road")
      ->check(CLI::Range(0.01, 5.0))
      ->capture_default_str();
  command->options.name.clear();
  cmd->add_option("--name", command->options.name, "name in the header; default: the name of the output file");
  const auto tolerance = [&](const char* flag, double& value, const char* text) {
    cmd->add_option(flag, value, text)->check(CLI::PositiveNumber)->capture_default_str();
  };
  tolerance("--plan-tolerance", command->options.plan_tolerance_m, "m, largest distance of a node from the reference line");
  tolerance("--elevation-tolerance", command->options.elevation_tolerance_m, "m, largest height error at a node");
  tolerance("--banking-tolerance", command->options.banking_tolerance_rad, "rad, largest superelevation error at a node");
  tolerance("--width-tolerance", command->options.width_tolerance_m, "m, largest width error at a node");
  cmd->add_flag("--left-hand-traffic", command->options.left_hand_traffic, "drive on the left");
  cmd->footer(
      "Reads roads.gpkg (layers centrelines, nodes and, for OpenCRG, roughness). Writes one OpenDRIVE file in the CRS of the roads. Roads without\n"
      "heights lie flat at z = 0. Where roughness was measured (`elevate --log`) OpenCRG surfaces have it: waves of two steps of\n"
      "the grid and longer, so give --crg-u-step 0.1 for all that tyres feel. Takes three seconds and 300 MB for 250 km of roads; a kilometre of OpenCRG surface a\n"
      "quarter of a second and half a megabyte.\n\n"
      "Examples:\n"
      "  orthodrive network --roads out/roads.gpkg -o out/roads.xodr\n"
      "  orthodrive network --roads roads.gpkg -o roads.xodr --elevation-tolerance 0.01 --findings odd.geojson\n"
      "  orthodrive network --roads roads.gpkg -o roads.xodr --opendrive 1.8 --layers network.gpkg --crg way/26182390");
  cmd->callback([command, &context] { run(*command, context); });
}

}  // namespace orthodrive::app
