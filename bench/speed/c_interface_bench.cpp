// SPDX-License-Identifier: Apache-2.0
// What a query costs a simulator: through libroadquery.so, not inlined, on a network of a site. CPU time of one core,
// the least of several rounds.
//
//   bench_c_interface NETWORK.xodr
//
// Prints one line a number: name value.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "roadquery/roadquery.h"

namespace {

struct Point {
  double x, y, z;
};

/// Along the middle of the rightmost driving lane of every road, a point each 3 cm: a tyre at 30 m/s and 1 kHz.
std::vector<Point> driven(const rq_map* map, std::size_t most) {
  std::vector<Point> points;
  for (int32_t i = 0; i < rq_road_count(map) && points.size() < most; ++i) {
    rq_road road;
    rq_lane lanes[32];
    rq_pose pose;
    if (rq_get_road(map, i, &road) != 1) continue;
    for (double s = 0.1; s < road.length - 0.1 && points.size() < most; s += 0.03) {
      const int32_t count = std::min(rq_lanes_at(map, road.id, s, lanes, 32), 32);
      const rq_lane* lane =
          std::find_if(lanes, lanes + count, [](const rq_lane& l) { return l.type == RQ_LANE_DRIVING; });
      if (lane == lanes + count) break;
      if (rq_position(map, road.id, s, 0.5 * (lane->t_left + lane->t_right), &pose) > 0)
        points.push_back({pose.x, pose.y, pose.z});
    }
  }
  return points;
}

double cpu_s() {
  timespec t;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

template <typename Ask>
void measure(const char* what, const std::vector<Point>& points, const Ask& ask) {
  double least_ns = 1e30, sum = 0.0;
  long missed = 0;
  for (int round = 0; round < 9; ++round) {
    rq_cursor cursor = RQ_CURSOR_START;
    const double begin = cpu_s();
    for (const Point& p : points) missed += !ask(p, cursor, sum);
    least_ns = std::min(least_ns, 1e9 * (cpu_s() - begin) / static_cast<double>(points.size()));
  }
  std::printf("%s_ns %.1f\n%s_missed %ld\n", what, least_ns, what, missed);
  if (!std::isfinite(sum)) std::puts("a height is none");
}

void measure_all(const rq_map* map, const char* order, const std::vector<Point>& points, bool keep_cursor) {
  const auto name = [order](const char* what) { return std::string(order) + "_" + what; };
  const auto start = [keep_cursor](rq_cursor& cursor) {
    if (!keep_cursor) cursor = RQ_CURSOR_START;
  };
  measure(name("z").c_str(), points, [&](const Point& p, rq_cursor& cursor, double& sum) {
    double z = 0.0;
    start(cursor);
    const bool found = rq_height(map, &cursor, p.x, p.y, p.z, &z) > 0;
    sum += z;
    return found;
  });
  for (const auto& [what, flags] : {std::pair("normal", RQ_NORMAL | RQ_MATERIAL), {"all", RQ_ALL}}) {
    measure(name(what).c_str(), points, [&, flags = flags](const Point& p, rq_cursor& cursor, double& sum) {
      rq_hit hit;
      start(cursor);
      if (rq_query(map, &cursor, p.x, p.y, p.z, static_cast<unsigned>(flags), &hit) <= 0) return false;
      sum += hit.z + hit.normal[0];
      return true;
    });
  }
}

}  // namespace

int main(int argc, char** argv) {
  rq_map* map = nullptr;
  char problem[256];
  if (argc != 2) return 2;
  const double begin = cpu_s();
  if (rq_load(argv[1], nullptr, &map, problem, sizeof problem) != RQ_OK) {
    std::fprintf(stderr, "%s\n", problem);
    return 1;
  }
  std::printf("load_s %.2f\n", cpu_s() - begin);
  std::vector<Point> points = driven(map, 1000000);
  if (points.empty()) return 1;
  std::printf("points %zu\n", points.size());
  measure_all(map, "driving", points, true);
  std::shuffle(points.begin(), points.end(), std::mt19937(1));
  measure_all(map, "any", points, false);
  rq_free(map);
  return 0;
}
