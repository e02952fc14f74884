// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/network/topology/crossing_nodes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>
#include <vector>

#include "orthodrive/model/roads/osm_node_id.hpp"
#include "orthodrive/roads/path_crossings.hpp"
#include "roadquery/surface/blend.hpp"

namespace orthodrive::network {
namespace {

constexpr double shared_reach_m = 20.0;
// Nobody builds a crossing so flat: slip roads whose lines got to the wrong side of each other before they merge.
constexpr double flat_cos = 0.8660, merging_reach_m = 150.0;  // 30 degrees
constexpr double same_place_m = 0.5;                          // a node so near takes the crossing's place

/// A node to be put into a path.
struct Insertion {
  std::size_t path = 0, segment = 0;
  double fraction = 0.0;
  RoadNode node;
};

double mix(double a, double b, double share) { return a + (b - a) * share; }

RoadNode node_between(const RoadPath& path, std::size_t segment, double fraction, Vec2 p, std::int64_t osm_node) {
  const RoadNode &a = path.nodes[segment], &b = path.nodes[segment + 1];
  RoadNode node = fraction < 0.5 ? a : b;
  node.p = p, node.osm_node = osm_node;
  node.kerb_radius_m = 0.0;
  node.s_m = mix(a.s_m, b.s_m, fraction), node.offset_m = mix(a.offset_m, b.offset_m, fraction);
  node.width_m = mix(a.width_m, b.width_m, fraction), node.z_m = mix(a.z_m, b.z_m, fraction);
  node.gradient = mix(a.gradient, b.gradient, fraction), node.banking = mix(a.banking, b.banking, fraction);
  node.crown = mix(a.crown, b.crown, fraction);
  return node;
}

/// Ids of the nodes of a path within reach of a place on it.
std::set<std::int64_t> nodes_near(const RoadPath& path, std::size_t segment, double fraction, double reach_m) {
  const double s = mix(path.nodes[segment].s_m, path.nodes[segment + 1].s_m, fraction);
  std::set<std::int64_t> ids;
  for (const RoadNode& node : path.nodes)
    if (is_osm_node(node.osm_node) && std::abs(node.s_m - s) <= reach_m) ids.insert(node.osm_node);
  return ids;
}

bool is_level(const RoadNetwork& roads, const PathCrossing& crossing) {
  const RoadPath &a = roads.paths[crossing.path_a], &b = roads.paths[crossing.path_b];
  if (a.layer != b.layer || a.bridge != b.bridge || a.tunnel != b.tunnel || crossing.path_a == crossing.path_b)
    return false;
  const auto z = [](const RoadPath& path, std::size_t segment, double fraction) {
    return mix(path.nodes[segment].z_m, path.nodes[segment + 1].z_m, fraction);
  };
  if (!roadquery::is_same_level(z(a, crossing.segment_a, crossing.fraction_a),
                                z(b, crossing.segment_b, crossing.fraction_b)))
    return false;
  const auto along = [](const RoadPath& path, std::size_t segment) {
    return normalized(path.nodes[segment + 1].p - path.nodes[segment].p);
  };
  const bool flat = std::abs(dot(along(a, crossing.segment_a), along(b, crossing.segment_b))) > flat_cos;
  const double reach_m = flat ? merging_reach_m : shared_reach_m;
  const std::set<std::int64_t> of_a = nodes_near(a, crossing.segment_a, crossing.fraction_a, reach_m),
                               of_b = nodes_near(b, crossing.segment_b, crossing.fraction_b, reach_m);
  return std::none_of(of_a.begin(), of_a.end(), [&](std::int64_t id) { return of_b.contains(id); });
}

void insert(RoadPath& path, const Insertion& at) {
  const auto near = [&](const RoadNode& node) {
    return !is_osm_node(node.osm_node) && distance(node.p, at.node.p) < same_place_m;
  };
  RoadNode &before = path.nodes[at.segment], &after = path.nodes[at.segment + 1];
  if (near(before))
    before = at.node;
  else if (near(after))
    after = at.node;
  else
    path.nodes.insert(path.nodes.begin() + static_cast<std::ptrdiff_t>(at.segment) + 1, at.node);
}

}  // namespace

RoadNetwork join_crossings(RoadNetwork roads, Findings& findings) {
  std::int64_t last_id = 0;
  for (const RoadPath& path : roads.paths)
    for (const RoadNode& node : path.nodes) last_id = std::max(last_id, node.osm_node);
  std::vector<Insertion> insertions;
  for (const PathCrossing& crossing : find_crossings(roads)) {
    if (!is_level(roads, crossing)) continue;
    const std::int64_t id = ++last_id;
    const RoadPath &a = roads.paths[crossing.path_a], &b = roads.paths[crossing.path_b];
    insertions.push_back({crossing.path_a, crossing.segment_a, crossing.fraction_a,
                          node_between(a, crossing.segment_a, crossing.fraction_a, crossing.p, id)});
    insertions.push_back({crossing.path_b, crossing.segment_b, crossing.fraction_b,
                          node_between(b, crossing.segment_b, crossing.fraction_b, crossing.p, id)});
    for (const std::int64_t way : {a.osm_id, b.osm_id}) roads.restrictions.push_back({way, id, way, true});
    findings.push_back({Severity::warning, "network.crossing_without_node",
                        fmt::format("ways {} and {} cross on one level without a common node: a crossing of both "
                                    "without turns",
                                    a.osm_id, b.osm_id),
                        crossing.p.x, crossing.p.y});
  }
  // From the back of each path, so that places before stay.
  std::stable_sort(insertions.begin(), insertions.end(), [](const Insertion& a, const Insertion& b) {
    if (a.path != b.path) return a.path < b.path;
    return a.segment != b.segment ? a.segment > b.segment : a.fraction > b.fraction;
  });
  for (const Insertion& at : insertions) insert(roads.paths[at.path], at);
  return roads;
}

}  // namespace orthodrive::network
