// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/pipeline/commands/run_fmu.hpp"

#include <fmt/format.h>

#include <set>

#include "orthodrive/core/error.hpp"
#include "orthodrive/core/find_resource.hpp"
#include "orthodrive/io/opendrive/fmu_io.hpp"
#include "orthodrive/pipeline/files/read_network.hpp"
#include "roadquery/query/ground_query.hpp"
#include "vehicle/read_car.hpp"

namespace orthodrive {
namespace fs = std::filesystem;

namespace {

fs::path shared_library(const std::string& identifier) {
  return find_resource(library_folders(), "fmu/" + identifier + ".so", "the FMU's shared library",
                       "build the target fmu_roads or fmu_car");
}

/// Returns what was odd in the roads.
Findings add_network(const FmuFiles& files, std::vector<io::FmuResource>& resources) {
  roadquery::GroundStage stage{};
  const roadquery::GroundQuery ground =
      roadquery::read_ground({.network = files.network.string(), .terrain = files.terrain.string()}, stage);
  resources.push_back({"roads.xodr", files.network});
  if (!files.terrain.empty()) resources.push_back({"terrain.asc", files.terrain});
  std::set<std::string> surfaces;
  for (const roadquery::Road& road : ground.roads().map().roads)
    for (const roadquery::SurfaceCrg& crg : road.surface) surfaces.insert(crg.file);
  for (const std::string& name : surfaces) {
    const fs::path relative = fs::path(name).lexically_normal();
    if (relative.is_absolute() || relative.begin()->string() == "..")
      throw InputError(
          files.network.string(),
          fmt::format("names the OpenCRG file {}, which does not lie beside or below it: it cannot be packed", name));
    resources.push_back({relative.generic_string(), files.network.parent_path() / relative});
  }
  return reading_findings(ground.roads().map());
}

fs::path car_file(const std::string& car) {
  if (fs::path(car).extension() == ".toml" || fs::exists(car)) return car;
  return find_resource(resource_folders("models/vehicles", "models/vehicles"), car + ".toml", "no such car",
                       "give the name of a preset, or a file");
}

}  // namespace

StageOutcome run_fmu(const FmuFiles& files, const FmuOptions& options, StageContext&) {
  std::vector<io::FmuResource> resources;
  Findings findings;
  if (!files.network.empty()) findings = add_network(files, resources);
  const fmu::ModelKind& kind = files.car.empty() ? fmu::road_model() : fmu::car_model();
  if (!files.car.empty()) {
    const fs::path file = car_file(files.car);
    (void)vehicle::read_car(file);
    resources.push_back({"car.toml", file});
  }
  io::write_fmu(files.fmu, kind, options.fmi_version, shared_library(kind.identifier), resources);
  return {.numbers = {{"variables", kind.variables.size()}},
          .findings = std::move(findings),
          .summary = {fmt::format("{}: {} (FMI {}.0), {} variables, {} files packed", files.fmu.string(),
                                  kind.identifier, options.fmi_version, kind.variables.size(), resources.size())}};
}

}  // namespace orthodrive
