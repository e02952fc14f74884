// SPDX-License-Identifier: Apache-2.0
// OpenCRG heights a second: a point that moves along a measured-like grid (1 cm rows and columns on a bend), by (u, v)
// and by (x, y), points all over it, and the road query with and without such a file laid on its road.

#include <benchmark/benchmark.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>
#include <vector>

#include "roadquery/crg/crg_grid.hpp"
#include "roadquery/crg/road_crgs.hpp"
#include "roadquery/query/road_query.hpp"

namespace {

using namespace roadquery;

constexpr std::size_t points = 100000;

/// 10 m of a bend of 30 m radius, 1001 x 341 values.
CrgFile cobbles() {
  std::mt19937 random(1);
  CrgFile file;
  CrgSurface& s = file.surface;
  s.u_increment_m = 0.01;
  for (int j = 0; j < 341; ++j) s.v_m.push_back(-1.7 + 0.01 * j);
  for (int i = 0; i < 1001; ++i) {
    s.phi_rad.push_back(0.01 / 30.0 * i), s.slope.push_back(0.02), s.banking.push_back(0.01);
    for (int j = 0; j < 341; ++j) s.grid_m.push_back(0.02 * (random() / 4294967296.0));
  }
  integrate_reference_line(s, 0.0, 0.0, 0.0);
  return file;
}

struct Track {
  std::vector<double> u, v, x, y;
};

Track track_on(const CrgSurface& s, bool in_order) {
  std::mt19937 random(2);
  Track track;
  for (std::size_t k = 0; k < points; ++k) {
    const double share = in_order ? (static_cast<double>(k) + 0.5) / points : random() / 4294967296.0;
    const double row = share * static_cast<double>(s.rows() - 1),
                 v = in_order ? 1.2 * std::sin(9.0 * share) : -1.6 + 3.2 * (random() / 4294967296.0);
    const std::size_t i = std::min(static_cast<std::size_t>(row), s.rows() - 2);
    const double along = s.u_increment_m * (row - static_cast<double>(i)), c = std::cos(s.phi_rad[i + 1]),
                 n = std::sin(s.phi_rad[i + 1]);
    track.u.push_back(s.u_start_m + s.u_increment_m * row), track.v.push_back(v);
    track.x.push_back(s.x_m[i] + along * c - v * n), track.y.push_back(s.y_m[i] + along * n + v * c);
  }
  return track;
}

void crg_height_at_uv(benchmark::State& state, bool in_order) {
  const CrgFile file = cobbles();
  const CrgGrid grid(file);
  const Track track = track_on(file.surface, in_order);
  std::size_t k = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(grid.evaluate(track.u[k], track.v[k], CrgPart::whole));
    k = k + 1 < points ? k + 1 : 0;
  }
}

void crg_height_at_xy(benchmark::State& state) {
  const CrgFile file = cobbles();
  const CrgGrid grid(file);
  const Track track = track_on(file.surface, true);
  std::size_t k = 0;
  double u = 0.0;
  for (auto _ : state) {
    if (const auto place = grid.place(track.x[k], track.y[k], u)) {
      u = place->u_m;
      benchmark::DoNotOptimize(grid.evaluate(place->u_m, place->v_m, CrgPart::whole));
    }
    k = k + 1 < points ? k + 1 : 0;
  }
}

/// A straight road of 200 m, and on it a text file with 0.5 m rows and 0.5 m columns.
RoadMap road_with_file(const std::filesystem::path& folder, const char* mode) {
  std::filesystem::create_directories(folder);
  std::ofstream out(folder / "a.crg");
  out << "$ROAD_CRG\nREFERENCE_LINE_INCREMENT = 0.5\nLONG_SECTION_V_INCREMENT = 0.5\n$KD_DEFINITION\n#:LRFI\n";
  for (int j = 1; j <= 17; ++j) out << "D:long section " << j << ",m\n";
  out << "$$$$\n";
  for (int i = 0; i <= 400; ++i)
    for (int j = 0; j < 17; ++j)
      out << (((i + j) % 2) != 0 ? "  0.001000" : "  0.002000") << (j % 8 == 7 || j == 16 ? "\n" : "");
  Road road;
  road.length = 200.0;
  road.plan = {{0.0, 0.0, 0.0, 0.0, 200.0, Line{}}};
  Lane lane;
  lane.width = {{.s = 0.0, .a = 3.5}};
  LaneSection section;
  lane.id = 1, section.left = {lane};
  lane.id = -1, section.right = {lane};
  road.sections = {section};
  if (*mode != 0) road.surface = {{.file = "a.crg", .s_end = 200.0, .mode = mode}};
  RoadMap map;
  map.roads = {road};
  return map;
}

void road_query(benchmark::State& state, const char* mode) {
  const std::filesystem::path folder = std::filesystem::temp_directory_path() / "bench_crg";
  RoadMap map = road_with_file(folder, mode);
  load_crgs(map, (folder / "roads.xodr").string());
  std::filesystem::remove_all(folder);
  const RoadQuery query(std::move(map));
  Cursor cursor;
  double x = 0.0, z = 0.0;
  for (auto _ : state) {
    const auto hit = query.find(x, -1.5, z, cursor);
    if (hit) z = hit->z;
    x = x + 0.03 < 200.0 ? x + 0.03 : 0.0;
  }
}

void crg_make_ready(benchmark::State& state) {
  const CrgFile file = cobbles();
  for (auto _ : state) benchmark::DoNotOptimize(CrgGrid(file));
}

BENCHMARK(crg_make_ready);
BENCHMARK_CAPTURE(crg_height_at_uv, in_order, true);
BENCHMARK_CAPTURE(crg_height_at_uv, anywhere, false);
BENCHMARK(crg_height_at_xy);
BENCHMARK_CAPTURE(road_query, without_file, "");
BENCHMARK_CAPTURE(road_query, attached, "attached");
BENCHMARK_CAPTURE(road_query, genuine, "genuine");

}  // namespace
