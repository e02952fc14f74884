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

// Fitted by hand to builds of the village (1 km2 at 0.2 m/px), Kvarnbyn (3.1 km2 at 0.52 m/px) and, for what grows with
// size, Pardubice (23 km2), each from nothing with two threads on the machine below. docs/build.md has the numbers.
constexpr int measured_threads = 2;
constexpr std::array<StageCost, 7> costs{{
    // stage     seconds                    memory (MB)                disk (MB)
    {"segment", {0.5, 0.0, 0.43, 0.0}, {1350, 0, 4, 0.0}, {0.5, 0.0, 0.6, 0.0}},
    {"refine", {0.3, 0.0, 0.04, 0.07}, {200, 0, 6, 1.0}, {0.2, 0.0, 0.0, 0.12}},
    {"elevate", {0.15, 0.0, 0.0, 0.025}, {230, 0, 0, 0.6}, {0.2, 0.0, 0.0, 0.16}},
    {"network", {0.05, 0.0, 0.0, 0.12}, {230, 0, 0, 1.2}, {0.0, 0.0, 0.0, 0.12}},
    {"scene", {0.3, 1.0, 0.36, 0.08}, {420, 0, 8, 1.5}, {1.0, 3.0, 0.2, 0.2}},
    {"drive", {1.2, 0.0, 0.0, 0.015}, {240, 0, 0, 1.2}, {7.0, 0.0, 0.0, 0.0}},
    {"report", {0.5, 0.0, 0.12, 0.02}, {250, 0, 10, 0.5}, {4.0, 0.0, 0.0, 0.02}},
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

std::string machine_of_costs() { return "2 cores (AMD EPYC), default model"; }

}  // namespace orthodrive
