#include "orthodrive/pipeline/plan_build.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "orthodrive/core/parallel.hpp"
#include "orthodrive/geo/polyline.hpp"
#include "orthodrive/io/raster_io.hpp"
#include "orthodrive/pipeline/sources.hpp"

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
// Pardubice (23 km2 at 0.46 m/px), each from nothing with two threads on the machine below. docs/measured/scaling.md
// has the numbers.
constexpr int measured_threads = 2;
constexpr std::array<StageCost, 7> costs{{
    // stage     seconds                        memory (MB)                   disk (MB)
    {"segment", {1.1, 0.0, 0.34, 0.059}, {1180, 0, 2.1, 0.15}, {0.0, 0.0, 0.068, 0.2}},
    {"refine", {0.0, 0.0, 0.0, 0.144}, {262, 21, 0, 0.064}, {0.13, 0.0, 0.0, 0.131}},
    {"elevate", {0.0, 0.055, 0.0, 0.047}, {237, 6.7, 0, 0.47}, {0.13, 0.0, 0.0, 0.165}},
    {"network", {0.0, 0.0, 0.0, 0.075}, {241, 3.8, 0, 0.75}, {0.0, 0.0, 0.0, 0.054}},
    {"scene", {3.2, 0.0, 0.093, 0.108}, {481, 0, 2.9, 0.5}, {5.2, 0.0, 0.23, 0.26}},
    {"drive", {1.25, 0.0, 0.0, 0.0073}, {243, 4.2, 0, 0.5}, {5.0, 0.11, 0.0, 0.0}},
    {"report", {1.5, 0.0, 0.0078, 0.0087}, {343, 6.7, 0.6, 0.25}, {5.6, 0.0, 0.0, 0.004}},
}};
constexpr double parallel_share = 0.8;  // of the time of two threads

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

BuildEstimate estimate_build(const SiteSize& size, int threads) {
  const double slower = 1.0 - parallel_share + parallel_share * measured_threads / worker_count(threads);
  BuildEstimate all;
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

std::string machine_of_costs() { return "2 cores (Intel Xeon), default model"; }

}  // namespace orthodrive
