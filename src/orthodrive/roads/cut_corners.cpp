// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/roads/cut_corners.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "orthodrive/model/roads/osm_node_id.hpp"
#include "orthodrive/roads/ring_paths.hpp"

namespace orthodrive {
namespace {

/// A node of a path. Interior ones have two arms there.
struct Visit {
  std::size_t path = 0, node = 0;
};
using Visits = std::map<std::int64_t, std::vector<Visit>>;

Visits visits_of(const RoadNetwork& roads) {
  Visits visits;
  for (std::size_t p = 0; p < roads.paths.size(); ++p)
    for (std::size_t i = 0; i < roads.paths[p].nodes.size(); ++i)
      if (const std::int64_t id = roads.paths[p].nodes[i].osm_node; is_osm_node(id)) visits[id].push_back({p, i});
  return visits;
}

MeetingEnd arm_of(const RoadPath& path, std::size_t node, bool forward, const ContinuationRule& rule) {
  Polyline line;
  if (forward)
    for (std::size_t i = node; i < path.nodes.size(); ++i) line.push_back(path.nodes[i].p);
  else
    for (std::size_t i = node + 1; i-- > 0;) line.push_back(path.nodes[i].p);
  return {direction_into(line, rule), &path, -1, !forward};
}

bool is_corner(const RoadNetwork& roads, const std::vector<Visit>& visits, const Visit& own,
               const ContinuationRule& rule) {
  const RoadPath& path = roads.paths[own.path];
  std::vector<MeetingEnd> arms{arm_of(path, own.node, false, rule), arm_of(path, own.node, true, rule)};
  if (bend_rad(arms[0], arms[1]) < rule.max_bend_rad) return false;
  for (const Visit& other : visits) {
    if (other.path == own.path && other.node == own.node) continue;
    const RoadPath& by = roads.paths[other.path];
    if (other.node > 0) arms.push_back(arm_of(by, other.node, false, rule));
    if (other.node + 1 < by.nodes.size()) arms.push_back(arm_of(by, other.node, true, rule));
  }
  const auto partner = pair_ends(arms, false, rule);
  return partner[0] || partner[1];
}

RoadPath part_of(const RoadPath& path, std::size_t first, std::size_t last) {
  RoadPath part = path;
  part.nodes.assign(path.nodes.begin() + static_cast<std::ptrdiff_t>(first),
                    path.nodes.begin() + static_cast<std::ptrdiff_t>(last) + 1);
  const double begin_m = part.nodes.front().s_m;
  for (RoadNode& node : part.nodes) node.s_m -= begin_m;
  return part;
}

}  // namespace

void cut_at_corners(RoadNetwork& roads, const ContinuationRule& rule) {
  const Visits visits = visits_of(roads);
  const std::vector<int> rings = rings_of_paths(roads);
  std::vector<std::vector<std::size_t>> corners(roads.paths.size());  // nodes of each path, ascending
  for (const auto& [id, at] : visits)
    for (const Visit& visit : at) {
      const bool inside = visit.node > 0 && visit.node + 1 < roads.paths[visit.path].nodes.size();
      if (at.size() > 1 && inside && rings[visit.path] < 0 && is_corner(roads, at, visit, rule))
        corners[visit.path].push_back(visit.node);
    }
  std::vector<RoadPath> paths;
  std::map<std::int64_t, int> parts;
  for (std::size_t p = 0; p < roads.paths.size(); ++p) {
    std::ranges::sort(corners[p]);
    std::size_t first = 0;
    corners[p].push_back(roads.paths[p].nodes.size() - 1);
    for (const std::size_t last : corners[p]) {
      paths.push_back(part_of(roads.paths[p], first, last));
      paths.back().part = parts[paths.back().osm_id]++;
      first = last;
    }
  }
  roads.paths = std::move(paths);
}

}  // namespace orthodrive
