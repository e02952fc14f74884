// SPDX-License-Identifier: Apache-2.0
#pragma once
// Exact little scenes: roads of known line and width painted into labels, and the OSM that a mapper would have drawn.

#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "orthodrive/model/rasters/rasters.hpp"
#include "orthodrive/model/roads/road_network.hpp"

namespace orthodrive::test {

constexpr std::uint8_t label_ground = 0, label_road = 1, label_parking = 2, label_vegetation = 4, label_grass = 5;

struct TrueRoad {
  Polyline line;  ///< dense
  double width_m = 6.0;
};

struct RoadScene {
  std::vector<TrueRoad> truth;
  LabelMap labels;
  RoadNetwork osm;
};

inline RoadScene make_scene(double size_m, double gsd_m = 0.5) {
  RoadScene scene;
  const Crs crs{"EPSG:32633"};
  const int pixels = static_cast<int>(size_m / gsd_m);
  scene.labels = {crs,
                  {500000.0, 5500000.0 + size_m, gsd_m, pixels, pixels},
                  Raster<std::uint8_t>(pixels, pixels, 1, label_grass),
                  default_class_table()};
  scene.osm.crs = crs;
  return scene;
}

inline Vec2 at(double x, double y) { return {500000.0 + x, 5500000.0 + y}; }

/// Every `step_m` of a curve p(s), s in [0, length].
inline Polyline trace(double length_m, const std::function<Vec2(double)>& p, double step_m = 0.5) {
  Polyline line;
  const int steps = static_cast<int>(std::ceil(length_m / step_m));
  for (int i = 0; i <= steps; ++i) line.push_back(p(length_m * i / steps));
  return line;
}

inline Polyline straight(Vec2 a, Vec2 b) {
  return trace(distance(a, b), [&](double s) { return a + (b - a) * (s / distance(a, b)); });
}

inline void paint(LabelMap& labels, const Ring& ring, std::uint8_t label) {
  fill_polygon(labels.labels, labels.frame, Polygon{ring, {}}, label);
}

inline void paint_disc(LabelMap& labels, Vec2 center, double radius_m, std::uint8_t label) {
  Ring ring;
  for (int k = 0; k < 24; ++k)
    ring.push_back(center + Vec2{radius_m * std::cos(k * M_PI / 12), radius_m * std::sin(k * M_PI / 12)});
  paint(labels, ring, label);
}

/// Adds a true road and paints it segment by segment (a whole ring may cross itself).
inline void add_truth(RoadScene& scene, Polyline line, double width_m) {
  const std::vector<double> half(line.size(), 0.5 * width_m);
  const std::vector<Vec2> t = tangents(line);
  for (std::size_t i = 0; i + 1 < line.size(); ++i) {
    const Vec2 a = left_normal(t[i]) * (0.5 * width_m), b = left_normal(t[i + 1]) * (0.5 * width_m);
    paint(scene.labels, {line[i] - a, line[i + 1] - b, line[i + 1] + b, line[i] + a}, label_road);
  }
  scene.truth.push_back({std::move(line), width_m});
}

struct Mapper {
  double node_spacing_m = 25.0;
  std::function<double(double)> offset_m = [](double) { return 0.0; };  ///< of s, positive left
};

/// The nodes that a mapper would click for a true line.
inline std::vector<RoadNode> map_line(const Polyline& truth, const Mapper& mapper, double width_m) {
  const double total = length_m(truth);
  const int steps = std::max(1, static_cast<int>(std::lround(total / mapper.node_spacing_m)));
  const std::vector<double> s = arc_lengths_m(truth);
  const std::vector<Vec2> t = tangents(truth);
  std::vector<RoadNode> nodes;
  for (int k = 0; k <= steps; ++k) {
    const double at_s = total * k / steps;
    std::size_t i = 0;
    while (i + 1 < s.size() && s[i] < at_s - 1e-9) ++i;
    nodes.push_back({.p = truth[i] + left_normal(t[i]) * mapper.offset_m(at_s), .width_m = width_m});
  }
  return nodes;
}

inline void add_way(RoadScene& scene, std::int64_t osm_id, std::vector<RoadNode> nodes,
                    const std::string& highway = "residential") {
  RoadPath path;
  path.osm_id = osm_id;
  path.highway = highway;
  path.nodes = std::move(nodes);
  scene.osm.paths.push_back(std::move(path));
}

struct RoadError {
  double mean_offset_m = 0.0, max_offset_m = 0.0, mean_width_m = 0.0, max_width_m = 0.0;
  int count = 0;
};

/// At places of the path at least `margin_m` from its ends: distance to the true line and difference of the width.
inline RoadError compare(const RoadPath& path, const TrueRoad& truth, double margin_m = 0.0) {
  RoadError error;
  const double total = length_m(centerline(path));
  const std::vector<double> s = arc_lengths_m(centerline(path));
  for (std::size_t i = 0; i < path.nodes.size(); ++i) {
    const RoadNode& node = path.nodes[i];
    if (s[i] < margin_m || s[i] > total - margin_m) continue;
    const double offset = project_onto(truth.line, node.p).distance_m, width = std::abs(node.width_m - truth.width_m);
    error.mean_offset_m += offset, error.mean_width_m += width, ++error.count;
    error.max_offset_m = std::max(error.max_offset_m, offset), error.max_width_m = std::max(error.max_width_m, width);
  }
  if (error.count > 0) error.mean_offset_m /= error.count, error.mean_width_m /= error.count;
  return error;
}

}  // namespace orthodrive::test
