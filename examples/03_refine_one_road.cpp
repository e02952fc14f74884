// SPDX-License-Identifier: Apache-2.0
// OpenStreetMap has a road 3 m beside where the photo shows it, and guesses its width. Paints a label map with a true
// road of 7 m width, gives refine_roads() the displaced line with 5.5 m, and prints what is left of both errors. No
// files.
//
// Read first: src/orthodrive/refine/refine_roads.hpp (options in, result out: every stage looks like this),
// src/orthodrive/model/roads/road_network.hpp. Next: 04_build_one_tile.cpp.

#include <cmath>
#include <cstdio>

#include "orthodrive/refine/refine_roads.hpp"

using namespace orthodrive;

namespace {

const Crs crs{"EPSG:32633"};
const Vec2 origin{500000.0, 5500000.0};

/// The true centre line: a gentle wave of 300 m.
Vec2 true_place(double x_m) { return origin + Vec2{x_m, 100.0 + 8.0 * std::sin(x_m / 60.0)}; }

/// Grass with a road in it, half a metre a pixel.
LabelMap paint_labels(double width_m) {
  constexpr std::uint8_t road = 1, grass = 5;  // of the default class table
  LabelMap map{crs,
               {origin.x, origin.y + 200.0, 0.5, 600, 400},
               Raster<std::uint8_t>(600, 400, 1, grass),
               default_class_table()};
  Polyline line;
  for (double x = 0.0; x <= 300.0; x += 1.0) line.push_back(true_place(x));
  RoadPath path;
  for (const Vec2& p : line) path.nodes.push_back({.p = p, .width_m = width_m});
  for (const Ring& cell : surface_cells(path)) fill_polygon(map.labels, map.frame, Polygon{cell, {}}, road);
  return map;
}

/// What a mapper drew: a node every 20 m, 3 m to the north.
RoadNetwork draw_osm() {
  RoadPath path{.osm_id = 1, .highway = "residential"};
  for (double x = 0.0; x <= 300.0; x += 20.0)
    path.nodes.push_back({.p = true_place(x) + Vec2{0.0, 3.0}, .width_m = 5.5});
  return {crs, {path}, {}};
}

void print_errors(const char* what, const RoadPath& path) {
  Polyline truth;
  for (double x = 0.0; x <= 300.0; x += 1.0) truth.push_back(true_place(x));
  double offset_m = 0.0, width_m = 0.0;
  for (const RoadNode& node : path.nodes) {
    offset_m += project_onto(truth, node.p).distance_m;
    width_m += node.width_m;
  }
  const auto n = static_cast<double>(path.nodes.size());
  std::printf("%-8s %3zu nodes, %.2f m beside the road, %.2f m wide\n", what, path.nodes.size(), offset_m / n,
              width_m / n);
}

}  // namespace

int main() {
  const LabelMap labels = paint_labels(7.0);
  const RoadNetwork osm = draw_osm();
  const RefinedRoads refined = refine_roads(osm, labels, {.search_radius_m = 8.0});
  print_errors("map:", osm.paths.front());
  print_errors("refined:", refined.roads.paths.front());
  std::printf("%s after %d iterations\n", refined.solve.converged ? "converged" : "not converged",
              refined.solve.iterations);
  for (const Finding& finding : refined.findings)
    std::printf("%s: %s\n", finding.code.c_str(), finding.message.c_str());
  return refined.solve.converged ? 0 : 1;
}
