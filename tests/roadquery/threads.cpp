// SPDX-License-Identifier: Apache-2.0
// One map, four threads, each with its own cursors: the same answers as of one thread, and no data race that
// ThreadSanitizer sees (this program and the library are built with it). Usage: test_roadquery_threads NETWORK
// TERRAIN.asc

#include <array>
#include <cmath>
#include <cstdio>
#include <thread>
#include <vector>

#include "roadquery/roadquery.h"

namespace {

/// Sum of all that comes back from points on and off the road.
double use(const rq_map* map) {
  rq_cursor cursor = RQ_CURSOR_START;
  double sum = 0.0;
  for (int i = 0; i < 5000; ++i) {
    const double x = -20.0 + 0.03 * i, y = 50.0 + 60.0 * std::sin(0.01 * i);
    rq_hit hit{};
    rq_patch patch{};
    rq_pose pose{};
    rq_lane lanes[4];
    double z = 0.0;
    sum += rq_query(map, &cursor, x, y, 20.0, RQ_ALL, &hit) + hit.z + hit.normal[0];
    sum += rq_height(map, &cursor, x, y, NAN, &z) + z;
    sum += rq_contact_patch(map, &cursor, x, y, 20.0, 0.1 * i, 0.3, 0.2, 0, 0, &patch) + patch.z;
    sum += rq_position(map, 7, 0.03 * i, 1.0, &pose) + pose.z;
    sum += rq_terrain_height(map, x, y, &z) + rq_lanes_at(map, 7, 0.03 * i, lanes, 4);
  }
  return sum;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  rq_options options = RQ_OPTIONS_DEFAULT;
  options.terrain_file = argv[2];
  rq_map* map = nullptr;
  char problem[256];
  if (rq_load(argv[1], &options, &map, problem, sizeof problem) != RQ_OK) {
    std::fprintf(stderr, "%s\n", problem);
    return 1;
  }
  std::array<double, 4> sums{};
  std::vector<std::thread> threads;
  for (double& sum : sums) threads.emplace_back([&sum, map] { sum = use(map); });
  for (std::thread& thread : threads) thread.join();
  const double alone = use(map);
  rq_free(map);
  for (const double sum : sums)
    if (sum != alone) {
      std::fprintf(stderr, "a thread's answers add up to %.17g, not %.17g\n", sum, alone);
      return 1;
    }
  std::printf("four threads agree: %.3f\n", alone);
  return 0;
}
