// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/pipeline/build/plan_build.hpp"

#include <algorithm>
#include <array>

#include "orthodrive/geo/polyline.hpp"
#include "orthodrive/io/raster/raster_io.hpp"
#include "orthodrive/pipeline/sources/sources.hpp"

namespace orthodrive {
namespace {

/// A cost is base + per km2 of area + per megapixel of photo + per km of road.
struct Cost {
  double base, per_km2, per_megapixel, per_road_km;
  [[nodiscard]] double of(const SiteSize& size) const {
    return base + per_km2 * size.area_km2 + per_megapixel * size.megapixels + per_road_km * size.road_km;
  }
};
struct StageCost {
  const char* stage;
  Cost seconds, memory_mb, disk_mb;
};

// By `tools/measure scaling --fit`: synthetic villages, regions and conurbations of 1 to 100 km2 at 0.5 m/px and
// Kvarnbyn and Pardubice (3 and 23 km2 at 0.5 m/px), each from nothing with two threads on the machine below.
// docs/measured/scaling.md has the numbers.
constexpr std::array<StageCost, 7> costs{{
    // stage     seconds                        memory (MB)                   disk (MB)
    {"segment", {0.864, 0.0, 0.197, 0.0376}, {1180, 0, 1.49, 0.12}, {0.0, 0.0, 0.068, 0.2}},
    {"refine", {0.0, 0.0, 0.0157, 0.0519}, {323, 22.2, 0, 0}, {0.13, 0.0, 0.0, 0.131}},
    {"elevate", {0.008, 0.0939, 0.0102, 0.0101}, {297, 5.75, 0, 0.774}, {0.13, 0.0, 0.0, 0.165}},
    {"network", {0.0, 0.0, 0.0, 0.045}, {317, 0, 0.712, 0.825}, {0.0, 0.0, 0.0, 0.054}},
    {"scene", {1.81, 0.0, 0.0436, 0.0732}, {654, 0, 2.71, 0.711}, {5.2, 0.0, 0.23, 0.26}},
    {"drive", {0.563, 0.0, 0.0, 0.0054}, {315, 2.43, 0.225, 0.552}, {5.0, 0.11, 0.0, 0.0}},
    {"report", {0.793, 0.0, 0.0035, 0.008}, {384, 8.73, 0, 0.719}, {5.6, 0.0, 0.0, 0.004}},
}};
/// The machine of these costs with nothing else on it.
constexpr MachineSpeed measured_machine{.seconds_of_one = 0.067, .seconds_of_all = 0.068, .threads = 2};
constexpr double parallel_share = 0.8;  // of the time of two threads

/// Pieces of work a second.
double rate_of_all(const MachineSpeed& machine) { return machine.threads / machine.seconds_of_all; }

double length_km(const RoadNetwork& roads) {
  double sum_m = 0.0;
  for (const RoadPath& path : roads.paths) sum_m += length_m(centerline(path));
  return sum_m / 1e3;
}
}  // namespace

SiteSize size_of(const Site& site) {
  const double gsd_m = io::raster_info(site.photos.front()).gsd_m;
  const Box2 box = bounds_of(site.frame.area.outer);
  Sources sources;
  return {.area_km2 = area_m2(site.frame.area) / 1e6,
          .megapixels = box.width() * box.height() / (gsd_m * gsd_m) / 1e6,
          .road_km = length_km(sources.osm(site.osm, site.frame).roads)};
}

BuildEstimate estimate_build(const SiteSize& size, const MachineSpeed& here) {
  const double slower = (1.0 - parallel_share) * here.seconds_of_one / measured_machine.seconds_of_one +
                        parallel_share * rate_of_all(measured_machine) / rate_of_all(here);
  BuildEstimate all{.speed = 1.0 / slower};
  for (const StageCost& cost : costs) {
    const StageEstimate stage{cost.stage, slower * cost.seconds.of(size), cost.memory_mb.of(size),
                              cost.disk_mb.of(size)};
    all.seconds += stage.seconds;
    all.memory_mb = std::max(all.memory_mb, stage.memory_mb);
    all.disk_mb += stage.disk_mb;
    all.stages.push_back(stage);
  }
  return all;
}

std::string machine_of_costs() { return "2 cores (AMD EPYC), default model"; }

}  // namespace orthodrive
