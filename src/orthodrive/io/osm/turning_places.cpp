// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/io/osm/turning_places.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

namespace orthodrive::io {
namespace {
constexpr double turning_circle_m = 12.0,
                 turning_loop_m = 18.0;  // RASt 06, 6.1.2.2: cars turn on 12 m, lorries on 18 m
constexpr double widest_circle_m = 60.0;
constexpr double passing_m = 5.5, passing_half_m = 7.5, passing_slope = 0.5;  // width gained per metre of way
constexpr double node_step_m = 2.0;
constexpr double beyond_share = 0.9;  // of the radius: a road cannot end in a point
constexpr double least_gain_m = 0.5;  // circles hardly wider than the road are none

/// The width of the paved place at a distance from its middle. A circle's mouth opens by 45 degrees to each side.
double place_width_m(const TurningPlace& place, double from_middle_m, bool beyond) {
  const double d = std::abs(from_middle_m);
  if (!place.is_circle) return passing_m - passing_slope * std::max(0.0, d - passing_half_m);
  const double radius = 0.5 * place.diameter_m, mouth = radius * std::numbers::sqrt2 / 2.0;
  if (beyond || d <= mouth) return 2.0 * std::sqrt(std::max(0.0, radius * radius - d * d));
  return 2.0 * mouth - 2.0 * (d - mouth);
}

/// Nodes between the others, node_step_m apart, where the place is wider than the road.
void put_in_nodes(RoadPath& path, double from_s, double to_s) {
  std::vector<RoadNode> nodes;
  for (std::size_t i = 0; i < path.nodes.size(); ++i) {
    if (i > 0) {
      const RoadNode a = path.nodes[i - 1], &b = path.nodes[i];
      const double length = b.s_m - a.s_m;
      const int steps = static_cast<int>(std::ceil(length / node_step_m));
      for (int k = 1; k < steps; ++k) {
        const double u = static_cast<double>(k) / steps, s = a.s_m + u * length;
        if (s < from_s || s > to_s) continue;
        RoadNode node = a;
        node.p = a.p + (b.p - a.p) * u;
        node.osm_node = 0, node.s_m = s;
        node.width_m = a.width_m + u * (b.width_m - a.width_m);
        nodes.push_back(node);
      }
    }
    nodes.push_back(path.nodes[i]);
  }
  path.nodes = std::move(nodes);
}

/// A road that ends at the middle of a circle goes on straight beyond it.
void go_beyond(const TurningPlace& place, const Polygon& area, RoadPath& path) {
  const std::size_t last = path.nodes.size() - 1;
  const Vec2 direction = normalized(path.nodes[last].p - path.nodes[last - 1].p);
  RoadNode node = path.nodes[last];
  node.p = node.p + direction * (beyond_share * 0.5 * place.diameter_m);
  if (!contains(area, node.p)) return;
  node.osm_node = 0;
  path.nodes.push_back(node);
}

void widen_place(const TurningPlace& place, const Polygon& area, bool dead_end, std::size_t at, RoadPath& path) {
  const double road_m = path.nodes[at].width_m, widest = place.is_circle ? place.diameter_m : passing_m;
  if (widest < road_m + least_gain_m) return;
  const bool at_start = dead_end && at == 0;
  if (at_start) std::reverse(path.nodes.begin(), path.nodes.end()), at = path.nodes.size() - 1;
  if (dead_end && place.is_circle) go_beyond(place, area, path);
  measure_path(path);
  const double middle = path.nodes[at].s_m,
               reach = place.is_circle ? place.diameter_m : passing_half_m + 2.0 * passing_m;
  put_in_nodes(path, middle - reach, middle + reach);
  for (RoadNode& node : path.nodes) {
    const double d = node.s_m - middle;
    if (std::abs(d) <= reach) node.width_m = std::max(road_m, place_width_m(place, d, dead_end && d > 0.0));
  }
  if (at_start) std::reverse(path.nodes.begin(), path.nodes.end());
  measure_path(path);
}
}  // namespace

std::optional<TurningPlace> turning_place(std::int64_t osm_node, const OsmTags& tags) {
  const std::string highway = tag_value(tags, "highway");
  if (highway == "passing_place") return TurningPlace{osm_node, false, 0.0};
  if (highway != "turning_circle" && highway != "turning_loop") return std::nullopt;
  TurningPlace place{osm_node, true, highway == "turning_loop" ? turning_loop_m : turning_circle_m};
  for (const char* key : {"diameter", "width"})
    if (const double tagged = parse_width_m(tag_value(tags, key)); tagged > 0.0) {
      place.diameter_m = std::min(tagged, widest_circle_m);
      break;
    }
  return place;
}

void widen_at(const std::vector<TurningPlace>& places, const Polygon& area, RoadNetwork& roads) {
  if (places.empty()) return;
  std::map<std::int64_t, int> uses;  // of nodes by paths: an end that no other path has is a dead end
  for (const RoadPath& path : roads.paths)
    for (const RoadNode& node : path.nodes) ++uses[node.osm_node];
  std::map<std::int64_t, TurningPlace> place_of;
  for (const TurningPlace& place : places) place_of.emplace(place.osm_node, place);
  for (RoadPath& path : roads.paths) {
    std::vector<std::int64_t> here;
    for (const RoadNode& node : path.nodes)
      if (node.osm_node != 0 && place_of.contains(node.osm_node)) here.push_back(node.osm_node);
    for (const std::int64_t id : here) {
      const auto node = std::ranges::find(path.nodes, id, &RoadNode::osm_node);
      if (node == path.nodes.end()) continue;
      const auto at = static_cast<std::size_t>(node - path.nodes.begin());
      const bool is_end = at == 0 || at + 1 == path.nodes.size();
      widen_place(place_of.at(id), area, is_end && uses[id] == 1, at, path);
    }
  }
}

}  // namespace orthodrive::io
