// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/evaluate/roads/profile_shape.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "orthodrive/model/roads/osm_node_id.hpp"
#include "orthodrive/roads/path_crossings.hpp"
#include "orthodrive/roads/path_junctions.hpp"

namespace orthodrive {
namespace {

void raise(ProfileKink& kink, double size, Vec2 where) {
  if (size > kink.size) kink = {size, where};
}

/// By how much the slope of a segment differs from the mean of its nodes' gradients. h^2/12 of the change of curvature
/// in a smooth profile; a quarter of a kink in one node, with opposite signs on its two sides.
double misfit(const RoadNode& a, const RoadNode& b) {
  const double run_m = distance(a.p, b.p);
  return run_m > 0.0 ? (b.z_m - a.z_m) / run_m - 0.5 * (a.gradient + b.gradient) : 0.0;
}

void measure_ways(const RoadNetwork& roads, const ScoreRegion& region, ProfileShape& shape) {
  constexpr double least_run_m = 0.1;  // rounding of stored heights shows in nearer nodes
  for (const RoadPath& path : roads.paths)
    for (std::size_t n = 1; n + 1 < path.nodes.size(); ++n) {
      const RoadNode &a = path.nodes[n - 1], &b = path.nodes[n], &c = path.nodes[n + 1];
      if (distance(a.p, b.p) < least_run_m || distance(b.p, c.p) < least_run_m || !region.contains(b.p)) continue;
      raise(shape.along, 2.0 * std::abs(misfit(b, c) - misfit(a, b)), b.p);  // NaN is never larger
    }
}

const RoadNode& node_of(const RoadNetwork& roads, PathEnd end) {
  return end.at_back ? roads.paths[end.path].nodes.back() : roads.paths[end.path].nodes.front();
}

void measure_links(const RoadNetwork& roads, const PathLinks& links, const ScoreRegion& region, ProfileShape& shape) {
  for (const auto& [a, b] : links) {
    const RoadNode &na = node_of(roads, a), &nb = node_of(roads, b);
    if (b < a || !region.contains(na.p)) continue;
    const double sign = a.at_back != b.at_back ? 1.0 : -1.0;  // ends of the same kind face each other
    raise(shape.along, std::abs(na.gradient - sign * nb.gradient), na.p);
  }
}

/// Least squares for the plane through the gradients of all arms, hardly tilted where they leave it open.
void measure_junction(const RoadNetwork& roads, const PathJunction& junction, ProfileShape& shape) {
  constexpr double open = 1e-9;
  double xx = open, xy = 0.0, yy = open, xg = 0.0, yg = 0.0;
  const auto gradient = [&](const JunctionArm& arm) { return roads.paths[arm.path].nodes[arm.node].gradient; };
  for (const JunctionArm& arm : junction.arms) {
    const Vec2 t = arm.direction;
    xx += t.x * t.x, xy += t.x * t.y, yy += t.y * t.y, xg += t.x * gradient(arm), yg += t.y * gradient(arm);
  }
  const double det = xx * yy - xy * xy;
  const Vec2 tilt{(yy * xg - xy * yg) / det, (xx * yg - xy * xg) / det};
  for (const JunctionArm& arm : junction.arms)
    raise(shape.junction, std::abs(gradient(arm) - dot(tilt, arm.direction)), junction.p);
}

void measure_steps(const RoadNetwork& roads, const ScoreRegion& region, ProfileShape& shape) {
  struct Range {
    double low_m = INFINITY, high_m = -INFINITY;
    Vec2 p;
  };
  std::map<std::int64_t, Range> at;
  for (const RoadPath& path : roads.paths)
    for (const RoadNode& node : path.nodes) {
      if (!is_osm_node(node.osm_node) || std::isnan(node.z_m) || !region.contains(node.p)) continue;
      Range& range = at[node.osm_node];
      range = {std::min(range.low_m, node.z_m), std::max(range.high_m, node.z_m), node.p};
    }
  for (const auto& [id, range] : at) raise(shape.step_m, range.high_m - range.low_m, range.p);
}

void measure_clearance(const RoadNetwork& roads, const ScoreRegion& region, ProfileShape& shape) {
  constexpr double two_levels_m = 1.0;
  for (const PathCrossing& crossing : find_crossings(roads)) {
    if (!region.contains(crossing.p)) continue;
    const auto height = [&](std::size_t path, std::size_t segment, double fraction) {
      const RoadNode* node = &roads.paths[path].nodes[segment];
      return node[0].z_m + fraction * (node[1].z_m - node[0].z_m);
    };
    const double room_m = std::abs(height(crossing.path_a, crossing.segment_a, crossing.fraction_a) -
                                   height(crossing.path_b, crossing.segment_b, crossing.fraction_b));
    if (std::isnan(room_m)) continue;
    if (roads.paths[crossing.path_a].layer == roads.paths[crossing.path_b].layer && room_m < two_levels_m) {
      ++shape.level_crossings;
    } else {
      shape.min_clearance_m = shape.crossings == 0 ? room_m : std::min(shape.min_clearance_m, room_m);
      ++shape.crossings;
    }
  }
}

}  // namespace

ProfileShape measure_profile_shape(const RoadNetwork& roads, const ScoreRegion& region) {
  ProfileShape shape;
  const PathLinks links = link_path_ends(roads);
  measure_ways(roads, region, shape);
  measure_links(roads, links, region, shape);
  for (const PathJunction& junction : find_junctions(roads, links)) {
    if (!region.contains(junction.p)) continue;
    ++shape.junctions;
    measure_junction(roads, junction, shape);
  }
  measure_steps(roads, region, shape);
  measure_clearance(roads, region, shape);
  return shape;
}

}  // namespace orthodrive
