// SPDX-License-Identifier: Apache-2.0
#include "roadquery/surface/junction_surface.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <unordered_map>
#include <unordered_set>

#include "roadquery/surface/blend.hpp"
#include "roadquery/surface/road_surface.hpp"
#include "roadquery/surface/short_ways.hpp"
#include "roadquery/surface/surface_gradient.hpp"

namespace roadquery {
namespace {

/// Two numbers at once.
using NodePair = double __attribute__((vector_size(16)));
NodePair load_node_pair(const double* at) {
  NodePair loaded;
  __builtin_memcpy(&loaded, at, sizeof loaded);
  return loaded;
}

/// Weights of four neighbouring nodes and their derivatives, u in [0, 1] between the second and the third, in x and y.
struct Weights {
  NodePair value[4], slope[4];
};

Weights catmull_rom(NodePair u) {
  const NodePair u2 = u * u, u3 = u2 * u;
  return {{-0.5 * u + u2 - 0.5 * u3, 1.0 - 2.5 * u2 + 1.5 * u3, 0.5 * u + 2.0 * u2 - 1.5 * u3, 0.5 * (u3 - u2)},
          {-0.5 + 2.0 * u - 1.5 * u2, -5.0 * u + 4.5 * u2, 0.5 + 4.0 * u - 4.5 * u2, 1.5 * u2 - u}};
}

/// Where a coordinate lies among `count` nodes: the node before it and the way on, both within the nodes.
struct SurfaceCell {
  int node = 0;
  double u = 0.0;
};

SurfaceCell cell_at(double offset_m, double spacing_m, int count) {
  // Comparisons that are false for NaN end at the first node.
  const double at = offset_m / spacing_m, last = static_cast<double>(std::max(count - 1, 0));
  const double inside = at > 0.0 ? std::min(at, last) : 0.0;
  const int node = std::min(static_cast<int>(inside), std::max(count - 2, 0));
  return {node, inside - node};
}

/// From rows of four nodes.
JunctionHeight bicubic(const double* const (&rows)[4], NodePair u, double inverse_spacing) {
  const Weights w = catmull_rom(u);
  NodePair value[2] = {}, slope[2] = {};  // of the four columns, by y
  for (int j = 0; j < 4; ++j) {
    const NodePair v = {w.value[j][1], w.value[j][1]}, s = {w.slope[j][1], w.slope[j][1]};
    for (int i = 0; i < 2; ++i) {
      const NodePair z = load_node_pair(rows[j] + 2 * i);
      value[i] += v * z, slope[i] += s * z;
    }
  }
  const auto sum = [](const NodePair(&of_x)[4], const NodePair(&of)[2]) {
    const NodePair products = NodePair{of_x[0][0], of_x[1][0]} * of[0] + NodePair{of_x[2][0], of_x[3][0]} * of[1];
    return products[0] + products[1];
  };
  return {sum(w.value, value), sum(w.slope, value) * inverse_spacing, sum(w.value, slope) * inverse_spacing};
}

JunctionHeight field_at(const JunctionField& surface, double x, double y) {
  if (surface.columns < 1 || surface.rows < 1) return {std::numeric_limits<double>::quiet_NaN(), 0.0, 0.0};
  const SurfaceCell column = cell_at(x - surface.x, surface.spacing_m, surface.columns);
  const SurfaceCell row = cell_at(y - surface.y, surface.spacing_m, surface.rows);
  const NodePair u = {column.u, row.u};
  const double inverse_spacing = 1.0 / surface.spacing_m;
  const int c0 = column.node - 1, r0 = row.node - 1;
  const auto line = [&](int r) { return surface.z + static_cast<std::ptrdiff_t>(r) * surface.columns; };
  if (c0 >= 0 && r0 >= 0 && c0 + 4 <= surface.columns && r0 + 4 <= surface.rows) {
    const double* first = line(r0) + c0;
    const std::ptrdiff_t next = surface.columns;
    return bicubic({first, first + next, first + 2 * next, first + 3 * next}, u, inverse_spacing);
  }
  double nodes[4][4];  // beyond its edges the field goes on as at them
  for (int j = 0; j < 4; ++j)
    for (int i = 0; i < 4; ++i)
      nodes[j][i] = line(std::clamp(r0 + j, 0, surface.rows - 1))[std::clamp(c0 + i, 0, surface.columns - 1)];
  return bicubic({nodes[0], nodes[1], nodes[2], nodes[3]}, u, inverse_spacing);
}

/// 1 - S(distance / transition) and its derivative by the distance.
struct Falloff {
  double value = 0.0, slope = 0.0;
};

Falloff falloff(double distance_m, double reach_m) {
  const double u = distance_m / reach_m;
  if (u <= 0.0) return {1.0, 0.0};
  if (!(u < 1.0)) return {0.0, 0.0};
  return {1.0 - u * u * u * (10.0 + u * (6.0 * u - 15.0)), -30.0 * u * u * (1.0 - u) * (1.0 - u) / reach_m};
}

/// Where a strip begins beside the end of its reference line, and how that changes to the left; its height and the
/// slopes along these axes at some place.
struct Strip {
  double begin_m = 0.0, slant = 0.0;
  JunctionHeight height;
};

/// At `in_m` into the junction, `left_m` beside the strip's line.
Strip strip_at(const JunctionArm& arm, double in_m, double left_m) {
  std::size_t k = 1;
  while (k + 1 < arm.places.size() && arm.places[k].left_m < left_m) ++k;
  const JunctionArm::Place &a = arm.places[k - 1], &b = arm.places[k];
  const double width = b.left_m - a.left_m, dz = (b.z - a.z) / width, dg = (b.dz_dinwards - a.dz_dinwards) / width;
  const double from = left_m - a.left_m, gradient = a.dz_dinwards + dg * from;
  const double slant = (b.in_m - a.in_m) / width, begin_m = a.in_m + slant * from, inside_m = in_m - begin_m;
  return {begin_m, slant, {a.z + dz * from + gradient * inside_m, gradient, dz + dg * inside_m - gradient * slant}};
}

JunctionHeight in_plan(const JunctionHeight& local, const JunctionArm& arm) {
  return {local.z, arm.in_x * local.dz_dx - arm.in_y * local.dz_dy, arm.in_y * local.dz_dx + arm.in_x * local.dz_dy};
}

/// Share of an arm in proportion to the field's (l_i) and its surface, with their slopes in x and y.
struct ArmAt {
  JunctionHeight share, height;
};

bool arm_at(const JunctionArm& arm, double x, double y, ArmAt& at) {
  if (arm.places.size() < 2) return false;
  const double dx = x - arm.x, dy = y - arm.y;
  const double in_m = arm.in_x * dx + arm.in_y * dy;
  if (!(std::abs(in_m) < junction_transition_m + arm.slant_m)) return false;
  const double left_m = arm.in_x * dy - arm.in_y * dx;
  const Strip strip = strip_at(arm, in_m, left_m);
  const double inside_m = in_m - strip.begin_m;
  const double right_edge_m = arm.places.front().left_m, left_edge_m = arm.places.back().left_m;
  const double beside_m = std::max({right_edge_m - left_m, left_m - left_edge_m, 0.0});
  const Falloff along = falloff(std::abs(inside_m), junction_transition_m), across = falloff(beside_m, beside_arm_m);
  const double weight = along.value * across.value;
  if (weight <= 0.0) return false;
  constexpr double least = 1e-9;  // keeps the share finite on the end line
  const double rest = 1.0 - weight + least, slope = (1.0 + least) / (rest * rest);
  const double along_slope = inside_m < 0.0 ? -along.slope : along.slope;
  const double across_slope = left_m < right_edge_m ? -across.slope : across.slope;
  at.share = in_plan({weight / rest, slope * along_slope * across.value,
                      slope * (along.value * across_slope - strip.slant * along_slope * across.value)},
                     arm);
  at.height = in_plan(strip.height, arm);
  return true;
}

/// Where the cross section of a carriageway may bend: its edges, the reference line and the starts of the lateral
/// shapes.
std::vector<double> bends_across(const Road& road, double s, double curvature) {
  constexpr double between_m = 2.0, widest_m = 2000.0;  // a wider road is refused later
  const Edges edges = carriageway_edges(road, s);
  std::vector<double> ts = {edges.right_t, edges.left_t};
  const auto add = [&](double t) {
    if (t > edges.right_t && t < edges.left_t) ts.push_back(t);
  };
  add(0.0);
  const auto after =
      std::upper_bound(road.shape.begin(), road.shape.end(), s, [](double v, const ShapeCubic& q) { return v < q.s; });
  const double from = after == road.shape.begin() ? s : (after - 1)->s;
  const double to = after == road.shape.end() ? s : after->s;
  for (const ShapeCubic& q : road.shape)
    if (q.s == from || q.s == to) add(q.t);
  std::sort(ts.begin(), ts.end());
  // Where the end lies in a bend the slope changes with t a little less than linearly.
  const std::vector<double> bends = ts;
  for (std::size_t i = 1; i < bends.size(); ++i) {
    const double width = bends[i] - bends[i - 1];
    const int parts = curvature == 0.0 ? 1 : static_cast<int>(std::ceil(std::min(widest_m, width) / between_m));
    for (int k = 1; k < parts; ++k) ts.push_back(bends[i - 1] + width * k / parts);
  }
  std::sort(ts.begin(), ts.end());
  return ts;
}

}  // namespace

bool contains(const JunctionSurface& surface, double x, double y) {
  bool inside = false;
  const auto& ring = surface.boundary;
  for (std::size_t i = 0, before = ring.size() - 1; i < ring.size(); before = i++) {
    const auto &a = ring[before], &b = ring[i];
    if ((a[1] > y) == (b[1] > y)) continue;
    if (x < a[0] + (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0])) inside = !inside;
  }
  return inside;
}

JunctionHeight evaluate(const JunctionField& surface, double x, double y) {
  return blend_arms(field_at(surface, x, y), surface.arms, x, y);
}

JunctionHeight blend_arms(const JunctionHeight& field, std::span<const JunctionArm> arms, double x, double y) {
  // Sums of shares and of shares times heights over the field: of differences, for the sake of rounding.
  bool is_alone = true;
  double shares = 1.0, dshares_dx = 0.0, dshares_dy = 0.0;
  JunctionHeight sum;
  ArmAt at;
  for (const JunctionArm& arm : arms) {
    if (!arm_at(arm, x, y, at)) continue;
    is_alone = false;
    const double over = at.height.z - field.z;
    shares += at.share.z, dshares_dx += at.share.dz_dx, dshares_dy += at.share.dz_dy;
    sum.z += at.share.z * over;
    sum.dz_dx += at.share.dz_dx * over + at.share.z * (at.height.dz_dx - field.dz_dx);
    sum.dz_dy += at.share.dz_dy * over + at.share.z * (at.height.dz_dy - field.dz_dy);
  }
  if (is_alone) return field;
  const double over = sum.z / shares;
  return {field.z + over, field.dz_dx + (sum.dz_dx - over * dshares_dx) / shares,
          field.dz_dy + (sum.dz_dy - over * dshares_dy) / shares};
}

JunctionHeight evaluate_nodes(const double* first, int columns, double u_x, double u_y, double inverse_spacing) {
  const std::ptrdiff_t next = columns;
  return bicubic({first, first + next, first + 2 * next, first + 3 * next}, NodePair{u_x, u_y}, inverse_spacing);
}

double arm_height(const JunctionArm& arm, double in_m, double left_m) { return strip_at(arm, in_m, left_m).height.z; }

double arm_begin(const JunctionArm& arm, double left_m) { return strip_at(arm, 0.0, left_m).begin_m; }

namespace {
/// Sidewalks, kerbs (borders with heights), gores. Shoulders, parking strips and flush borders are carriageway.
bool is_beside_carriageway(const Lane& lane) {
  return lane.type == LaneType::sidewalk || (lane.type == LaneType::border && !lane.heights.empty()) ||
         lane.type == LaneType::none || lane.type == LaneType::other;
}

/// Roads that are closed to cars have lanes of type "other" alone: those are their carriageway.
bool has_carriageway(const LaneSection& section) {
  const auto is_part = [](const Lane& lane) { return !is_beside_carriageway(lane); };
  return std::any_of(section.left.begin(), section.left.end(), is_part) ||
         std::any_of(section.right.begin(), section.right.end(), is_part);
}
}  // namespace

Edges carriageway_edges(const Road& road, double s) {
  s = std::clamp(s, 0.0, road.length);
  const LaneSection& section = section_at(road, s);
  const double offset = evaluate(road.lane_offset, s);
  const bool closed = !has_carriageway(section);
  const auto width_m = [&](const std::vector<Lane>& lanes) {
    double width = 0.0;
    for (const Lane& lane : lanes) {
      if (is_beside_carriageway(lane) && !(closed && lane.type == LaneType::other)) break;
      width += lane_width(lane, s - section.s);
    }
    return width;
  };
  return {offset + width_m(section.left), offset - width_m(section.right)};
}

JunctionArm junction_arm(const Road& road, ContactPoint end) {
  const bool at_end = end == ContactPoint::end;
  const double s = at_end ? road.length : 0.0, sign = at_end ? 1.0 : -1.0;
  const PlanPoint reference = reference_point(road, s);
  JunctionArm arm{reference.x, reference.y, sign * std::cos(reference.hdg), sign * std::sin(reference.hdg), {}};
  for (const double t : bends_across(road, s, reference.curvature)) {
    const SurfacePoint point = surface_point(road, s, t, reference);
    const double dx = point.x - reference.x, dy = point.y - reference.y;
    const double left = std::cos(reference.hdg) * dy - std::sin(reference.hdg) * dx;
    const double in_m = arm.in_x * dx + arm.in_y * dy;
    arm.places.push_back({sign * left, point.z, sign * gradient_towards(point, reference.hdg), in_m});
    arm.slant_m = std::max(arm.slant_m, std::abs(in_m));
  }
  if (!at_end) std::reverse(arm.places.begin(), arm.places.end());
  const auto same = [](const auto& p, const auto& q) { return q.left_m - p.left_m < 1e-6; };
  arm.places.erase(std::unique(arm.places.begin(), arm.places.end(), same), arm.places.end());
  if (arm.places.size() < 2) arm.places.clear();
  return arm;
}

namespace {

/// The end of a road that is linked to a junction.
struct PavedEnd {
  JunctionArm arm;
  int junction = 0;
};

/// Both ends of all roads that are linked to junctions with a surface, but for ways that two surfaces cover.
std::vector<PavedEnd> ends_at_junctions(const RoadMap& map, const std::unordered_set<int>& with_surface) {
  std::vector<PavedEnd> ends;
  std::unordered_set<int> covered;
  for (const ShortWay& way : short_ways(map))
    if (with_surface.contains(way.junctions[0]) && with_surface.contains(way.junctions[1]))
      for (const std::size_t i : way.roads) covered.insert(map.roads[i].id);
  const auto add = [&](const Road& road, const RoadLink& link, ContactPoint end) {
    if (link.kind == LinkKind::junction && with_surface.contains(link.id))
      ends.push_back({junction_arm(road, end), link.id});
  };
  for (const Road& road : map.roads) {
    if (road.junction >= 0 || road.sections.empty() || covered.contains(road.id)) continue;
    add(road, road.predecessor, ContactPoint::start);
    add(road, road.successor, ContactPoint::end);
  }
  return ends;
}

/// Whether some place where the arm counts lies inside the surface, on its level.
bool reaches_into(const JunctionArm& arm, const JunctionSurface& surface) {
  constexpr int across = 8, along = 4;
  if (arm.places.size() < 2) return false;
  const double right = arm.places.front().left_m - beside_arm_m, left = arm.places.back().left_m + beside_arm_m;
  for (int k = 0; k <= along; ++k)
    for (int i = 0; i <= across; ++i) {
      const double left_m = right + (left - right) * i / across;
      const double in_m = arm_begin(arm, left_m) + junction_transition_m * k / along;
      const double x = arm.x + arm.in_x * in_m - arm.in_y * left_m, y = arm.y + arm.in_y * in_m + arm.in_x * left_m;
      if (contains(surface, x, y) && is_same_level(field_at(field_of(surface), x, y).z, arm_height(arm, in_m, left_m)))
        return true;
    }
  return false;
}

}  // namespace

void join_arms(RoadMap& map) {
  std::unordered_set<int> with_surface;
  for (const Junction& junction : map.junctions)
    if (junction.surface) with_surface.insert(junction.id);
  const std::vector<PavedEnd> ends = ends_at_junctions(map, with_surface);
  std::vector<std::size_t> by_x(ends.size());
  std::iota(by_x.begin(), by_x.end(), std::size_t{0});
  std::sort(by_x.begin(), by_x.end(), [&](std::size_t a, std::size_t b) { return ends[a].arm.x < ends[b].arm.x; });
  std::unordered_map<int, std::vector<std::size_t>> linked;
  for (std::size_t i = 0; i < ends.size(); ++i) linked[ends[i].junction].push_back(i);
  constexpr double reach_m = 30.0;  // of a road's edge from its reference line
  for (Junction& junction : map.junctions) {
    if (!junction.surface) continue;
    JunctionSurface& surface = *junction.surface;
    surface.arms.clear();
    double west = std::numeric_limits<double>::infinity(), south = west, east = -west, north = -west;
    for (const auto& [x, y] : surface.boundary)
      west = std::min(west, x), east = std::max(east, x), south = std::min(south, y), north = std::max(north, y);
    std::vector<std::size_t> own = linked[junction.id];
    auto at = std::lower_bound(by_x.begin(), by_x.end(), west - reach_m,
                               [&](std::size_t i, double x) { return ends[i].arm.x < x; });
    for (; at != by_x.end() && ends[*at].arm.x <= east + reach_m; ++at) {
      const PavedEnd& end = ends[*at];
      if (end.junction == junction.id || end.arm.y < south - reach_m || end.arm.y > north + reach_m) continue;
      if (reaches_into(end.arm, surface)) own.push_back(*at);
    }
    std::sort(own.begin(), own.end());
    for (const std::size_t i : own) surface.arms.push_back(ends[i].arm);
  }
}

}  // namespace roadquery
