// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/pipeline/stages/crg_files.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <set>

#include "orthodrive/core/atomic_file.hpp"
#include "orthodrive/core/error.hpp"
#include "orthodrive/core/parallel.hpp"
#include "orthodrive/drive/routes/route.hpp"
#include "orthodrive/io/opendrive/opencrg_io.hpp"
#include "orthodrive/network/crg/sample_crg.hpp"
#include "orthodrive/network/crg/sample_friction.hpp"
#include "orthodrive/pipeline/stages/choose_roads.hpp"

namespace orthodrive {
namespace {
namespace fs = std::filesystem;
using roadquery::Road;

std::set<std::size_t> choose(const roadquery::RoadMap& map, const CrgFilesOptions& options) {
  std::set<std::size_t> chosen;
  for (const std::string& item : options.roads) {
    if (item == "all") {
      for (std::size_t i = 0; i < map.roads.size(); ++i) chosen.insert(i);
    } else if (item == "all-of-route") {
      for (const RouteStep& step : find_route(map, {.route = options.route}).steps)
        chosen.insert(static_cast<std::size_t>(step.road));
    } else {
      chosen.merge(choose_roads(map, item, "--crg", ", all-of-route or all"));
    }
  }
  return chosen;
}

}  // namespace

CrgFormat crg_format_of(const std::string& name) {
  std::string upper = name;
  for (char& c : upper) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  for (const CrgFormat format : {CrgFormat::lrfi, CrgFormat::ldfi, CrgFormat::krbi, CrgFormat::kdbi})
    if (upper == name_of(format)) return format;
  throw OptionError(fmt::format("OpenCRG format '{}' is not one of LRFI, LDFI (text), KRBI, KDBI (binary)", name));
}

fs::path crg_folder(const fs::path& xodr) { return xodr.parent_path() / (xodr.stem().string() + "_crg"); }

CrgFilesResult write_crg_files(roadquery::RoadMap& map, const fs::path& xodr, const CrgFilesOptions& options) {
  const std::set<std::size_t> chosen = choose(map, options);
  if (chosen.empty()) return {};
  const std::vector<std::size_t> roads(chosen.begin(), chosen.end());
  const fs::path target = crg_folder(xodr);
  AtomicFile folder(target);
  fs::create_directories(folder.path());
  parallel_for(roads.size(), options.threads, [&](std::size_t i) {
    Road& road = map.roads[roads[i]];
    constexpr double tolerance_m = 0.0005;  // so that the file is the road within a millimetre everywhere
    SampleCrgOptions sampling{options.u_step_m, options.v_step_m, options.format, {}, tolerance_m};
    if (options.relief_of) sampling.relief_m = options.relief_of(road);
    CrgSurface surface = sample_crg(road, sampling);
    surface.comment = fmt::format("road {} of {}\nheights in metres, x and y in {}", road.id, xodr.filename().string(),
                                  map.geo_reference.empty() ? "the coordinates of that file" : "its geoReference");
    const std::string name = fmt::format("road_{}.crg", road.id);
    io::write_crg(folder.path() / name, surface, options.format);
    road.surface = {crg_reference(road, surface, target.filename().string() + "/" + name)};
    if (!options.friction) return;
    CrgSurface friction = sample_friction(road);
    friction.comment = fmt::format("friction of road {} of {}, no heights", road.id, xodr.filename().string());
    const std::string friction_name = fmt::format("road_{}_friction.crg", road.id);
    io::write_crg(folder.path() / friction_name, friction, options.format);
    road.surface.push_back(friction_reference(road, target.filename().string() + "/" + friction_name));
  });
  folder.commit();
  CrgFilesResult result;
  for (const std::size_t i : roads) ++result.files, result.length_m += map.roads[i].length;
  return result;
}

}  // namespace orthodrive
