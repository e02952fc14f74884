// SPDX-License-Identifier: Apache-2.0
// Refinement of roads against the size of the area and the number of nodes: labels of a synthetic village, repeated
// until there are 400 megapixels, and as many of its roads as a case asks for. The reference took 37 minutes for 17,714
// nodes. Usage: bench_refine [megapixels] [nodes ...]; prints a line a case: nodes, kilometres, seconds, nodes a
// second, peak memory of the process. OSM is the truth with a node every 20 m, moved by a smooth field of some 2 m.

#include <fmt/format.h>
#include <sys/resource.h>

#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <vector>

#include "orthodrive/refine/refine_roads.hpp"
#include "orthodrive/synth/make_site.hpp"

namespace {

using namespace orthodrive;

constexpr int node_step = 20;  // truth has a node a metre

struct Area {
  RoadEvidence evidence;
  RoadNetwork osm;  // of one tile after the other
};

Vec2 disturbance(Vec2 p) {
  return {2.0 * std::sin(p.x / 90.0 + p.y / 160.0), 2.0 * std::cos(p.y / 110.0 - p.x / 210.0)};
}

RoadPath moved_way(const RoadPath& way, Vec2 by, int tile) {
  constexpr std::int64_t ids_per_tile = 1'000'000;
  RoadPath path = way;
  path.osm_id += tile * ids_per_tile;
  path.nodes.clear();
  for (std::size_t i = 0; i < way.nodes.size(); ++i) {
    const RoadNode& node = way.nodes[i];
    if (i % node_step != 0 && i + 1 != way.nodes.size() && node.osm_node <= 0) continue;
    const Vec2 p = node.p + by;
    path.nodes.push_back({.p = p + disturbance(p),
                          .osm_node = node.osm_node > 0 ? node.osm_node + tile * ids_per_tile : 0,
                          .width_m = default_width_m(way.highway, way.lanes, way.oneway)});
  }
  return path;
}

Area tile_village(double megapixels) {
  SynthSite site = make_preset(Preset::village, {.size_m = 800.0, .seed = 99});
  const Raster<std::uint8_t>& labels = site.labels.labels;
  const int per_side = std::max(1, static_cast<int>(std::ceil(std::sqrt(megapixels * 1e6) / labels.width)));
  Area area{.evidence = {}, .osm = {.crs = site.crs, .paths = {}}};
  {
    LabelMap tiled{site.crs, site.labels.frame, Raster<std::uint8_t>(per_side * labels.width, per_side * labels.height),
                   site.labels.classes};
    tiled.frame.width *= per_side, tiled.frame.height *= per_side;
    for (int row = 0; row < tiled.labels.height; ++row)
      for (int tile = 0; tile < per_side; ++tile)
        std::copy_n(&labels.at(0, row % labels.height), labels.width, &tiled.labels.at(tile * labels.width, row));
    area.evidence = road_evidence(tiled);
  }
  const double edge_m = labels.width * site.labels.frame.gsd_m;
  for (int tile = 0; tile < per_side * per_side; ++tile)
    for (const RoadPath& way : site.roads.paths) {
      const int row = tile / per_side, col = tile % per_side;
      area.osm.paths.push_back(moved_way(way, {col * edge_m, -row * edge_m}, tile));
    }
  return area;
}

RoadNetwork first_roads(const RoadNetwork& all, double nodes, const RefineRoadsOptions& options) {
  RoadNetwork roads{.crs = all.crs, .paths = {}};
  double length = 0.0;
  for (const RoadPath& path : all.paths) {
    if (length >= nodes * options.spacing_m) break;
    roads.paths.push_back(path);
    length += length_m(centerline(path));
  }
  return roads;
}

double peak_gb() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) * 1024.0 / 1e9;
}

}  // namespace

int main(int argc, char** argv) {
  const double megapixels = argc > 1 ? std::stod(argv[1]) : 400.0;
  std::vector<double> cases;
  for (int i = 2; i < argc; ++i) cases.push_back(std::stod(argv[i]));
  if (cases.empty()) cases = {4429, 8857, 17714, 35428, 70856};
  const Area area = tile_village(megapixels);
  const RefineRoadsOptions options;
  fmt::print("{:.0f} megapixels\n", area.evidence.frame.width * 1e-6 * area.evidence.frame.height);
  for (const double wanted : cases) {
    const RoadNetwork osm = first_roads(area.osm, wanted, options);
    const auto start = std::chrono::steady_clock::now();
    const RefinedRoads result = refine_roads(osm, area.evidence, options);
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    std::size_t nodes = 0;
    double length = 0.0;
    for (const RoadPath& path : result.roads.paths) nodes += path.nodes.size(), length += length_m(centerline(path));
    fmt::print("{:7} nodes {:7.1f} km {:7.2f} s {:8.0f} nodes/s {:5.2f} GB\n", nodes, length / 1000.0, seconds,
               static_cast<double>(nodes) / seconds, peak_gb());
  }
}
