// SPDX-License-Identifier: Apache-2.0
// How fast is the road query on a map? CPU time through libroadquery's functions, which are not inlined.
//
//   bench_road_query MAP.xodr [POINTS]     routes along the links, any order, the worst of POINTS queries
//   bench_road_query --overlap             where twelve turning roads overlap
//   bench_road_query --tile MAP.xodr KM    the map again and again beside itself until KM of road: load and memory
//
// Prints one line a number: name value.

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <fstream>
#include <map>
#include <random>
#include <stdexcept>
#include <string>
#include <utility>

#include "roadquery/query/road_query.hpp"

namespace {

using namespace roadquery;
using Points = std::vector<std::array<double, 3>>;

double cpu_s() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

double memory_mb(const char* key) {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);)
    if (line.rfind(key, 0) == 0) return std::strtod(line.c_str() + std::strlen(key) + 1, nullptr) / 1024.0;
  return std::nan("");
}

double total_km(const RoadMap& map) {
  double sum = 0.0;
  for (const Road& road : map.roads) sum += 1e-3 * road.length;
  return sum;
}

/// Points every 3 cm (30 m/s at 1 kHz) in the first lane, from the longest road along the links, at every junction onto
/// the connecting road that was used least; where the network ends it goes on at another road.
Points drive(const RoadMap& map, double length_m) {
  std::map<int, std::size_t> index;
  for (std::size_t i = 0; i < map.roads.size(); ++i) index[map.roads[i].id] = i;
  std::map<int, const Junction*> junctions;
  for (const Junction& junction : map.junctions) junctions[junction.id] = &junction;
  std::vector<int> used(map.roads.size(), 0);
  std::mt19937 random(1);
  const auto longer = [](const Road& a, const Road& b) { return a.length < b.length; };
  std::size_t at = static_cast<std::size_t>(std::ranges::max_element(map.roads, longer) - map.roads.begin());
  bool forwards = true;
  Points points;
  for (double driven_m = 0.0; driven_m < length_m;) {
    const Road& road = map.roads[at];
    ++used[at];
    driven_m += std::max(road.length, 0.1);
    for (double s = 0.01; s < road.length && !road.sections.empty(); s += 0.03) {
      const Edges edges = road_edges(road, forwards ? s : road.length - s);
      const double t = forwards ? std::max(-1.5, 0.5 * edges.right_t) : std::min(1.5, 0.5 * edges.left_t);
      const SurfacePoint p = surface_point(road, forwards ? s : road.length - s, t);
      points.push_back({p.x, p.y, p.z});
    }
    const RoadLink& link = forwards ? road.successor : road.predecessor;
    std::size_t next = map.roads.size();
    bool next_forwards = true;
    if (link.kind == LinkKind::road && index.contains(link.id))
      next = index[link.id], next_forwards = link.contact == ContactPoint::start;
    if (link.kind == LinkKind::junction && junctions.contains(link.id)) {
      for (const Connection& c : junctions[link.id]->connections) {
        if (c.incoming_road != road.id || !index.contains(c.connecting_road)) continue;
        const std::size_t candidate = index[c.connecting_road];
        if (next == map.roads.size() || used[candidate] < used[next])
          next = candidate, next_forwards = c.contact == ContactPoint::start;
      }
    }
    if (next == map.roads.size() || used[next] > 20) next = random() % map.roads.size(), next_forwards = true;
    at = next, forwards = next_forwards;
  }
  return points;
}

Points scatter(const RoadMap& map, std::size_t count) {
  std::mt19937_64 random(2);
  const auto uniform = [&] { return static_cast<double>(random()) / 18446744073709551616.0; };
  std::vector<double> lengths;
  lengths.reserve(map.roads.size());
  for (const Road& road : map.roads) lengths.push_back((lengths.empty() ? 0.0 : lengths.back()) + road.length);
  Points points;
  while (points.size() < count) {
    const auto r =
        static_cast<std::size_t>(std::ranges::upper_bound(lengths, uniform() * lengths.back()) - lengths.begin());
    if (r >= map.roads.size() || map.roads[r].sections.empty()) continue;
    const Road& road = map.roads[r];
    const double s = uniform() * road.length;
    const Edges edges = road_edges(road, s);
    const SurfacePoint p = surface_point(road, s, edges.right_t + uniform() * (edges.left_t - edges.right_t));
    points.push_back({p.x, p.y, p.z});
  }
  return points;
}

/// Least and middle CPU time a point of several runs.
template <typename Run>
void time_runs(const char* name, std::size_t points, const Run& run) {
  std::vector<double> ns;
  for (int i = 0; i < 7; ++i) {
    const double before = cpu_s();
    run();
    ns.push_back(1e9 * (cpu_s() - before) / static_cast<double>(points));
  }
  std::ranges::sort(ns);
  std::printf("%s_ns_least %.1f\n%s_ns_middle %.1f\n", name, ns.front(), name, ns[ns.size() / 2]);
}

/// Height, then with normal and material, then all of a hit, in driving order. Returns how many points missed.
std::size_t time_parts(const std::string& name, const RoadQuery& query, const Points& route) {
  std::size_t missed = 0;
  time_runs((name + "_z").c_str(), route.size(), [&] {
    Cursor cursor;
    for (const auto& p : route) missed += query.find_height(p[0], p[1], p[2], cursor) ? 0 : 1;
  });
  for (const auto& [what, parts] : {std::pair("_normal", hit_normal | hit_material), {"_all", +hit_all}}) {
    time_runs((name + what).c_str(), route.size(), [&, parts = parts] {
      Cursor cursor;
      for (const auto& p : route) missed += query.find(p[0], p[1], p[2], cursor, parts) ? 0 : 1;
    });
  }
  return missed;
}

void measure_worst(const RoadQuery& query, const Points& points, std::size_t count) {
  std::vector<double> us;
  us.reserve(count);
  Cursor cursor;
  for (std::size_t i = 0; i < count; ++i) {
    const auto& p = points[i % points.size()];
    cursor = {};
    const auto before = std::chrono::steady_clock::now();
    const auto hit = query.find(p[0], p[1], p[2], cursor);
    const auto after = std::chrono::steady_clock::now();
    us.push_back(hit ? std::chrono::duration<double, std::micro>(after - before).count() : 0.0);
  }
  // What takes long again is the query's; what does not is another process's.
  std::vector<std::size_t> order(count);
  for (std::size_t i = 0; i < count; ++i) order[i] = i;
  const std::size_t slow = std::min<std::size_t>(1000, count);
  std::partial_sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(slow), order.end(),
                    [&](std::size_t a, std::size_t b) { return us[a] > us[b]; });
  double worst = 0.0;
  for (std::size_t k = 0; k < slow; ++k) {
    const auto& p = points[order[k] % points.size()];
    double least = us[order[k]];
    for (int again = 0; again < 5; ++again) {
      cursor = {};
      const auto before = std::chrono::steady_clock::now();
      (void)query.find(p[0], p[1], p[2], cursor);
      least =
          std::min(least, std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - before).count());
    }
    worst = std::max(worst, least);
  }
  std::printf("worst_us_first_time %.2f\nworst_us_least_of_six %.2f\n", us[order[0]], worst);
}

void measure_site(const char* path, std::size_t count) {
  const double start = cpu_s();
  RoadMap map = read_opendrive(path);
  const double read = cpu_s();
  const RoadQuery query(std::move(map));
  std::printf("road_km %.1f\nread_s %.2f\nbake_s %.2f\nstations %zu\n", total_km(query.map()), read - start,
              cpu_s() - read, query.baked().stations.size());
  const Points route = drive(query.map(), 10000.0), any = scatter(query.map(), std::min<std::size_t>(count, 1'000'000));
  std::size_t missed = time_parts("route", query, route);
  time_runs("any_order", any.size(), [&] {
    for (const auto& p : any) {
      Cursor cursor;
      missed += query.find(p[0], p[1], p[2], cursor) ? 0 : 1;
    }
  });
  std::printf("missed %zu\n", missed);
  measure_worst(query, any, count);
}

/// Roads of 20 m through one place, every one of them turning, two lanes each: a junction without a surface of its own.
void measure_overlap() {
  RoadMap map;
  for (int id = 0; id < 12; ++id) {
    const double hdg = 0.5 * id;
    Road road;
    road.id = id, road.length = 20.0;
    road.plan = {{0.0, -10.0 * std::cos(hdg), -10.0 * std::sin(hdg), hdg, 20.0, Spiral{0.0, 0.02}}};
    road.elevation = {{.s = 0.0, .a = 200.0 - 0.02 * 10.0, .b = 0.02}};
    road.superelevation = {{.s = 0.0, .a = 0.02}};
    LaneSection section;
    Lane lane;
    lane.width = {{.s = 0.0, .a = 3.5}};
    lane.id = 1, section.left = {lane};
    lane.id = -1, section.right = {lane};
    road.sections = {section};
    map.roads.push_back(std::move(road));
  }
  const RoadQuery query(std::move(map));
  Points points;
  for (int i = 0; i < 100000; ++i) points.push_back({-2.0 + 0.01 * (i % 400), 0.5, 200.0});
  if (time_parts("overlap", query, points) > 0) throw std::runtime_error("a point of the overlap was missed");
}

void measure_tiled(const char* path, double km) {
  const RoadMap tile = read_opendrive(path);
  RoadMap map;
  int copy = 0;
  for (double have = 0.0; have < km; have += total_km(tile), ++copy) {
    const int id = copy * 1'000'000;
    for (Road road : tile.roads) {
      road.id += id;
      if (road.junction >= 0) road.junction += id;
      for (PlanElement& e : road.plan) e.x += 20000.0 * copy;
      map.roads.push_back(std::move(road));
    }
  }
  std::printf("road_km %.1f\nmap_mb %.0f\n", total_km(map), memory_mb("VmRSS:"));
  const double before = cpu_s();
  const RoadQuery query(std::move(map));
  std::printf("bake_s %.2f\nstations %zu\nall_mb %.0f\npeak_mb %.0f\n", cpu_s() - before, query.baked().stations.size(),
              memory_mb("VmRSS:"), memory_mb("VmHWM:"));
}

}  // namespace

int main(int argc, char** argv) {
  try {
    if (argc == 4 && std::strcmp(argv[1], "--tile") == 0) {
      measure_tiled(argv[2], std::strtod(argv[3], nullptr));
    } else if (argc == 2 && std::strcmp(argv[1], "--overlap") == 0) {
      measure_overlap();
    } else if (argc == 2 || argc == 3) {
      measure_site(argv[1], argc == 3 ? std::strtoull(argv[2], nullptr, 10) : 1'000'000);
    } else {
      std::fprintf(stderr, "usage: bench_road_query MAP.xodr [POINTS] | --overlap | --tile MAP.xodr KM\n");
      return 2;
    }
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 2;
  }
  return 0;
}
