// SPDX-License-Identifier: Apache-2.0
// Heights and network against the length of the roads: a town of streets every 100 m, every seventh one a tertiary road
// that others pass under where both are, on hills seen through a grid of 10 m with noise. Nodes every 2 m. Usage:
// bench_heights [kilometres ...]; a line a case: km, nodes, seconds of elevate and of network, peak memory of the
// process.

#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <ctime>
#include <string>
#include <vector>

#include "orthodrive/core/memory.hpp"
#include "orthodrive/core/random.hpp"
#include "orthodrive/elevate/elevate_roads.hpp"
#include "orthodrive/network/build_network.hpp"

namespace {

using namespace orthodrive;

const Crs crs{"EPSG:32633"};
constexpr double block_m = 100.0, spacing_m = 2.0;
constexpr int fast_every = 7;

double hills_m(Vec2 p) {
  return 200.0 + 12.0 * std::sin(p.x / 310.0) * std::cos(p.y / 270.0) + 3.0 * std::sin(p.x / 90.0 + p.y / 70.0);
}

/// One way a street and direction, with a shared node at each crossing but those of two tertiary roads.
RoadNetwork make_town(int streets) {
  RoadNetwork roads{crs, {}};
  const double length_m = (streets - 1) * block_m;
  const int nodes = static_cast<int>(length_m / spacing_m), nodes_per_block = static_cast<int>(block_m / spacing_m);
  for (const bool north : {false, true})
    for (int street = 0; street < streets; ++street) {
      RoadPath path{.osm_id = (north ? 100000 : 0) + street + 1,
                    .highway = street % fast_every == 3 ? "tertiary" : "residential"};
      for (int i = 0; i <= nodes; ++i) {
        const double along = i * spacing_m, across = street * block_m;
        RoadNode node{.p = north ? Vec2{across, along} : Vec2{along, across}, .s_m = along, .width_m = 6.0};
        const int other = i / nodes_per_block;
        const bool fast_crossing = street % fast_every == 3 && other % fast_every == 3;
        if (i % nodes_per_block == 0 && !fast_crossing)
          node.osm_node = 1 + (north ? static_cast<std::int64_t>(other) * streets + street
                                     : static_cast<std::int64_t>(street) * streets + other);
        path.nodes.push_back(std::move(node));
      }
      roads.paths.push_back(std::move(path));
    }
  return roads;
}

HeightGrid make_dtm(double size_m) {
  constexpr double gsd_m = 10.0, margin_m = 50.0;
  const int n = static_cast<int>((size_m + 2.0 * margin_m) / gsd_m);
  HeightGrid grid{crs, {-margin_m, size_m + margin_m, gsd_m, n, n}, Raster<float>(n, n)};
  Random random(1);
  for (int row = 0; row < n; ++row)
    for (int col = 0; col < n; ++col)
      grid.height_m.at(col, row) = static_cast<float>(hills_m(grid.frame.center_of(col, row)) + 0.1 * random.normal());
  return grid;
}

/// Wall clock and processor time: they differ on a machine that is shared.
class Stopwatch {
 public:
  [[nodiscard]] std::string text() const {
    return fmt::format("{:.1f} s ({:.1f} s CPU)",
                       std::chrono::duration<double>(std::chrono::steady_clock::now() - wall_).count(),
                       static_cast<double>(std::clock() - cpu_) / CLOCKS_PER_SEC);
  }

 private:
  std::chrono::steady_clock::time_point wall_ = std::chrono::steady_clock::now();
  std::clock_t cpu_ = std::clock();
};

}  // namespace

int main(int argc, char** argv) {
  std::vector<double> cases;
  for (int i = 1; i < argc; ++i) cases.push_back(std::stod(argv[i]));
  if (cases.empty()) cases = {10.0, 100.0, 1000.0};
  for (const double km : cases) {
    // 2 n streets of (n - 1) blocks
    const int streets = std::max(2, static_cast<int>(std::lround(0.5 + std::sqrt(0.25 + 500.0 * km / block_m))));
    const RoadNetwork roads = make_town(streets);
    const HeightGrid dtm = make_dtm((streets - 1) * block_m);
    std::size_t nodes = 0;
    for (const RoadPath& path : roads.paths) nodes += path.nodes.size();
    reset_peak_memory();
    const Stopwatch elevate;
    const ElevateRoadsResult heights = elevate_roads(roads, {dtm}, {}, {});
    const std::string elevate_time = elevate.text();
    const Stopwatch build;
    const NetworkResult network = build_network(heights.roads);
    fmt::print("{:.0f} km, {} nodes: elevate {}, {} iterations, {} findings; network {}, {} roads; peak {:.2f} GB\n",
               2.0 * streets * (streets - 1) * block_m / 1000.0, nodes, elevate_time, heights.solve.iterations,
               heights.findings.size(), build.text(), network.map.roads.size(),
               static_cast<double>(peak_memory_bytes()) / 1e9);
  }
}
