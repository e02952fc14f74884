// Road queries per second: a point that moves 3 cm from query to query (a tyre at 30 m/s and 1 kHz), and points all
// over a town-sized map.

#include <benchmark/benchmark.h>

#include <cmath>
#include <random>
#include <vector>

#include "roadquery/road_query.hpp"

namespace {

using namespace roadquery;

/// 400 roads of 300 m (line, spiral, arc, spiral) with a height record every 2 m on 4 x 4 km.
RoadMap make_town() {
  std::mt19937 random(1);
  const auto uniform = [&](double low, double high) { return low + (high - low) * (random() / 4294967296.0); };
  RoadMap map;
  for (int id = 0; id < 400; ++id) {
    Road road;
    road.id = id;
    const double k = uniform(-0.02, 0.02);
    PlanElement next{0.0, uniform(0.0, 4000.0), uniform(0.0, 4000.0), uniform(-3.0, 3.0), 75.0, Line{}};
    for (const PlanShape& shape :
         {PlanShape{Line{}}, PlanShape{Spiral{0.0, k}}, PlanShape{Arc{k}}, PlanShape{Spiral{k, 0.0}}}) {
      next.shape = shape;
      road.plan.push_back(next);
      const PlanPoint end = evaluate(next, next.length);
      next = {next.s + next.length, end.x, end.y, end.hdg, next.length, Line{}};
    }
    road.length = next.s;
    for (double s = 0.0; s < road.length; s += 2.0)
      road.elevation.push_back({.s = s, .a = 200.0 + 0.02 * s, .b = 0.02});
    road.superelevation = {{.s = 0.0, .a = 0.02}};
    LaneSection section;
    Lane lane;
    lane.width = {{.s = 0.0, .a = 3.5}};
    lane.id = 1, section.left = {lane};
    lane.id = -1, section.right = {lane};
    road.sections = {section};
    map.roads.push_back(std::move(road));
  }
  return map;
}

const RoadQuery& town() {
  static const RoadQuery query(make_town());
  return query;
}

/// Along the four elements in turn: the mean over a whole road.
void coherent(benchmark::State& state) {
  std::vector<SurfacePoint> track;
  const Road& road = town().map().roads[0];
  for (double s = 1.0; s < road.length - 1.0; s += 0.03) track.push_back(surface_point(road, s, -1.5));
  Cursor cursor;
  std::size_t i = 0, misses = 0;
  for (auto _ : state) {
    const SurfacePoint& p = track[i];
    i = i + 1 < track.size() ? i + 1 : 0;
    const auto hit = town().find(p.x, p.y, p.z, cursor);
    misses += !hit;
    benchmark::DoNotOptimize(hit);
  }
  if (misses > 0) state.SkipWithError("the point left the road");
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK(coherent)->Name("road_query/coherent");

void scattered_on_roads(benchmark::State& state) {
  std::mt19937 random(2);
  std::vector<SurfacePoint> points;
  for (int i = 0; i < 4096; ++i) {
    const Road& road = town().map().roads[random() % town().map().roads.size()];
    points.push_back(surface_point(road, road.length * (random() / 4294967296.0), 2.0));
  }
  std::size_t i = 0;
  for (auto _ : state) {
    const SurfacePoint& p = points[i++ & 4095];
    Cursor cursor;
    benchmark::DoNotOptimize(town().find(p.x, p.y, p.z, cursor));
  }
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK(scattered_on_roads)->Name("road_query/scattered_on_roads");

void scattered_anywhere(benchmark::State& state) {
  std::mt19937 random(3);
  std::vector<std::pair<double, double>> points;
  for (int i = 0; i < 4096; ++i)
    points.emplace_back(4000.0 * (random() / 4294967296.0), 4000.0 * (random() / 4294967296.0));
  std::size_t i = 0;
  for (auto _ : state) {
    const auto& [x, y] = points[i++ & 4095];
    Cursor cursor;
    benchmark::DoNotOptimize(town().find(x, y, 200.0, cursor));
  }
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK(scattered_anywhere)->Name("road_query/scattered_anywhere");

/// Where twelve connecting roads overlap: the slowest place of a map.
void junction(benchmark::State& state) {
  RoadMap map;
  for (int id = 0; id < 12; ++id) {
    Road road = town().map().roads[0];
    const double hdg = 0.5 * id;
    road.id = id;
    road.length = 20.0;
    road.plan = {{0.0, -10.0 * std::cos(hdg), -10.0 * std::sin(hdg), hdg, 20.0, Spiral{0.0, 0.02}}};
    map.roads.push_back(std::move(road));
  }
  const RoadQuery query(map);
  Cursor cursor;
  double x = -2.0;
  for (auto _ : state) {
    x = x < 2.0 ? x + 0.01 : -2.0;
    benchmark::DoNotOptimize(query.find(x, 0.5, 200.0, cursor));
  }
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK(junction)->Name("road_query/junction_of_12");

void spiral_point(benchmark::State& state) {
  const PlanElement spiral{0.0, 0.0, 0.0, 0.3, 80.0, Spiral{0.0, 0.01}};
  double ds = 0.0;
  for (auto _ : state) {
    ds = ds < 79.0 ? ds + 0.03 : 0.0;
    benchmark::DoNotOptimize(evaluate(spiral, ds));
  }
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK(spiral_point)->Name("reference_line/spiral_point");

}  // namespace
