// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/io/opendrive/opendrive_junction.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <unordered_map>

#include "roadquery/surface/junction_surface.hpp"

namespace orthodrive::io {
namespace {

using roadquery::ContactPoint;
using roadquery::JunctionArm;
using roadquery::JunctionSurface;
using roadquery::Road;
using Point = std::array<double, 2>;

/// The end of a road that is linked to a junction.
struct Arm {
  int road = 0;
  ContactPoint contact = ContactPoint::start;
  JunctionArm line;
};

/// By junction.
std::unordered_map<int, std::vector<Arm>> arms_of(const roadquery::RoadMap& map) {
  std::unordered_map<int, std::vector<Arm>> arms;
  const auto add = [&](const Road& road, const roadquery::RoadLink& link, ContactPoint end) {
    if (link.kind == roadquery::LinkKind::junction)
      arms[link.id].push_back({road.id, end, roadquery::junction_arm(road, end)});
  };
  for (const Road& road : map.roads) {
    if (road.junction >= 0 || road.sections.empty()) continue;
    add(road, road.predecessor, ContactPoint::start);
    add(road, road.successor, ContactPoint::end);
  }
  return arms;
}

/// Whether a place of the ring lies on the end line of an arm. The ring overlaps the arms by 1.5 cm
/// (docs/junctions.md); where a kerb meets the edge of an arm at a small angle its corner lies further off along the
/// line.
bool is_on(const JunctionArm& arm, const Point& p) {
  constexpr double off_m = 0.03, beside_m = 0.1;
  if (arm.places.empty()) return false;
  const double dx = p[0] - arm.x, dy = p[1] - arm.y;
  const double in_m = arm.in_x * dx + arm.in_y * dy, left_m = arm.in_x * dy - arm.in_y * dx;
  return std::abs(in_m - roadquery::arm_begin(arm, left_m)) < off_m && left_m > arm.places.front().left_m - beside_m &&
         left_m < arm.places.back().left_m + beside_m;
}

/// The left or right edge of an arm at its end, as seen into the junction.
Point corner_of(const JunctionArm& arm, bool left) {
  const JunctionArm::Place& at = left ? arm.places.back() : arm.places.front();
  return {arm.x + arm.in_x * at.in_m - arm.in_y * at.left_m, arm.y + arm.in_y * at.in_m + arm.in_x * at.left_m};
}

constexpr int no_arm = -1;

/// A run of edges of the ring: from vertex `first`, `edges` on.
struct Run {
  std::size_t first = 0, edges = 0;
  int arm = no_arm;
  double length_m = 0.0;
};

double edge_length(const std::vector<Point>& ring, std::size_t i) {
  const Point &a = ring[i % ring.size()], &b = ring[(i + 1) % ring.size()];
  return std::hypot(b[0] - a[0], b[1] - a[1]);
}

/// The arm that each edge of the ring lies on.
std::vector<int> arms_of_edges(const std::vector<Point>& ring, const std::vector<Arm>& arms) {
  std::vector<int> result(ring.size(), no_arm);
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const Point &a = ring[i], &b = ring[(i + 1) % ring.size()];
    for (std::size_t k = 0; k < arms.size() && result[i] == no_arm; ++k)
      if (is_on(arms[k].line, a) && is_on(arms[k].line, b)) result[i] = static_cast<int>(k);
  }
  return result;
}

/// Equal neighbours as runs, all round the ring.
std::vector<Run> runs_of(const std::vector<Point>& ring, const std::vector<int>& arms) {
  const std::size_t n = ring.size();
  std::size_t begin = 0;  // a place where a run begins
  while (begin < n && arms[begin] == arms[(begin + n - 1) % n]) ++begin;
  if (begin == n) begin = 0;
  std::vector<Run> runs;
  for (std::size_t k = 0; k < n; ++k) {
    const std::size_t i = (begin + k) % n;
    if (runs.empty() || runs.back().arm != arms[i]) runs.push_back({i, 0, arms[i], 0.0});
    ++runs.back().edges;
    runs.back().length_m += edge_length(ring, i);
  }
  return runs;
}

/// Leaves each arm its longest run; the others belong to the kerb.
void keep_longest(const std::vector<Run>& runs, std::vector<int>& arms) {
  for (const Run& run : runs) {
    if (run.arm == no_arm) continue;
    const bool is_longest = std::all_of(runs.begin(), runs.end(), [&](const Run& other) {
      return other.arm != run.arm || other.length_m < run.length_m || &other == &run;
    });
    for (std::size_t k = 0; !is_longest && k < run.edges; ++k) arms[(run.first + k) % arms.size()] = no_arm;
  }
}

/// The places of a run of the ring, from the corner of the arm before to that of the arm behind it.
std::vector<Point> places_of(const JunctionSurface& surface, const Run& run, const JunctionArm* before,
                             const JunctionArm* behind) {
  std::vector<Point> places;
  for (std::size_t k = 0; k <= run.edges; ++k)
    places.push_back(surface.boundary[(run.first + k) % surface.boundary.size()]);
  if (before) places.front() = corner_of(*before, false);
  if (behind) places.back() = corner_of(*behind, true);
  return places;
}

Road kerb_along(const JunctionSurface& surface, const std::vector<Point>& places, int junction, int id) {
  Road road;
  road.id = id;
  road.junction = junction;
  for (std::size_t k = 0; k + 1 < places.size(); ++k) {
    const Point &a = places[k], &b = places[k + 1];
    const double length = std::hypot(b[0] - a[0], b[1] - a[1]);
    if (!(length > 0.0)) continue;
    const double z = roadquery::evaluate(surface, a[0], a[1]).z;
    const double gradient = (roadquery::evaluate(surface, b[0], b[1]).z - z) / length;
    road.plan.push_back({road.length, a[0], a[1], std::atan2(b[1] - a[1], b[0] - a[0]), length, roadquery::Line{}});
    road.elevation.push_back({road.length, z, gradient, 0.0, 0.0});
    road.length += length;
  }
  road.sections.emplace_back();
  return road;
}

JunctionBoundary boundary_of(int junction, const JunctionSurface& surface, const std::vector<Arm>& arms, int first_id) {
  std::vector<int> arm_of_edge = arms_of_edges(surface.boundary, arms);
  keep_longest(runs_of(surface.boundary, arm_of_edge), arm_of_edge);
  JunctionBoundary boundary;
  const std::vector<Run> runs = runs_of(surface.boundary, arm_of_edge);
  const auto line_of = [&](std::size_t k) {
    const int arm = runs[k % runs.size()].arm;
    return arm == no_arm ? nullptr : &arms[static_cast<std::size_t>(arm)].line;
  };
  for (std::size_t k = 0; k < runs.size(); ++k) {
    const Run& run = runs[k];
    if (run.arm != no_arm) {
      const Arm& arm = arms[static_cast<std::size_t>(run.arm)];
      boundary.segments.push_back({true, arm.road, arm.contact});
      continue;
    }
    const int id = first_id + static_cast<int>(boundary.kerbs.size());
    const std::vector<Point> places = places_of(surface, run, line_of(k + runs.size() - 1), line_of(k + 1));
    boundary.kerbs.push_back(kerb_along(surface, places, junction, id));
    boundary.segments.push_back({false, id, ContactPoint::start});
  }
  return boundary;
}

}  // namespace

std::vector<JunctionBoundary> junction_boundaries(const roadquery::RoadMap& map) {
  const std::unordered_map<int, std::vector<Arm>> arms = arms_of(map);
  std::vector<JunctionBoundary> boundaries;
  // CARLA takes a junction's id for a road's if there is such a road.
  int next_id = 0;
  if (!map.roads.empty()) next_id = std::max(next_id, map.roads.back().id + 1);
  if (!map.junctions.empty()) next_id = std::max(next_id, map.junctions.back().id + 1);
  for (const roadquery::Junction& junction : map.junctions) {
    JunctionBoundary& boundary = boundaries.emplace_back();
    if (!junction.surface) continue;
    const auto found = arms.find(junction.id);
    boundary =
        boundary_of(junction.id, *junction.surface, found == arms.end() ? std::vector<Arm>{} : found->second, next_id);
    next_id += static_cast<int>(boundary.kerbs.size());
  }
  return boundaries;
}

}  // namespace orthodrive::io
