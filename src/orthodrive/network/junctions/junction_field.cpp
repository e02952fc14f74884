// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/network/junctions/junction_field.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
#include <utility>

#include "orthodrive/math/normal_matrix.hpp"
#include "roadquery/surface/junction_surface.hpp"

namespace orthodrive::network {
namespace {

// A crown keeps its shape but for the ridge, which is rounded so that cars can turn across it; a side road bends over
// 2 m where it meets it.
constexpr double main_smoothing_m = 0.8, straight_smoothing_m = 2.0, turning_smoothing_m = 6.0;
constexpr double entry_smoothing_m = 0.5;      // and no less than the way from the arm's end
constexpr double anchor_smoothing_m = 1000.0;  // to the plane: decides only what nothing else does

double smoothing_of(RoadRole role) {
  switch (role) {
    case RoadRole::arm:
    case RoadRole::beside:
      return 0.0;
    case RoadRole::main:
      return main_smoothing_m;
    case RoadRole::straight:
      return straight_smoothing_m;
    case RoadRole::turning:
      break;
  }
  return turning_smoothing_m;
}

/// The plane z = a + b x + c y of least squares, x and y from `middle`.
struct Plane {
  Vec2 middle;
  double a = 0.0, b = 0.0, c = 0.0;
  [[nodiscard]] double at(Vec2 p) const { return a + b * (p.x - middle.x) + c * (p.y - middle.y); }
};

Plane plane_of(const FieldGrid& grid, const std::vector<NodeTarget>& targets) {
  Plane plane;
  double n = 0.0;
  const auto each = [&](auto&& visit) {
    for (std::size_t i = 0; i < targets.size(); ++i)
      if (std::isfinite(targets[i].smoothing_m)) visit(grid.node(i), targets[i].z);
  };
  each([&](Vec2 p, double z) { plane.middle = plane.middle + p, plane.a += z, n += 1.0; });
  if (n == 0.0) return plane;
  plane.middle = plane.middle * (1.0 / n), plane.a /= n;
  double xx = 0.0, xy = 0.0, yy = 0.0, xz = 0.0, yz = 0.0;
  each([&](Vec2 p, double z) {
    const Vec2 d = p - plane.middle;
    xx += d.x * d.x, xy += d.x * d.y, yy += d.y * d.y, xz += d.x * (z - plane.a), yz += d.y * (z - plane.a);
  });
  const double det = xx * yy - xy * xy;
  if (det <= 1e-6 * (xx + yy) * (xx + yy)) return plane;  // on one line: level across it and along
  plane.b = (xz * yy - yz * xy) / det, plane.c = (yz * xx - xz * xy) / det;
  return plane;
}

/// Rows of the least-squares problem; fixed nodes go to the right side.
class Rows {
 public:
  Rows(const std::vector<NodeTarget>& targets, const std::vector<double>& over, const std::vector<char>& asked)
      : over_(over), unknown_(over.size(), fixed) {
    for (std::size_t i = 0; i < targets.size(); ++i) {
      if (!asked.empty() && asked[i] == 0)
        unknown_[i] = outside;
      else if (targets[i].smoothing_m > 0.0)
        unknown_[i] = jacobian_.columns++;
    }
    jacobian_.row_start = {0};
  }
  struct Term {
    std::size_t node = 0;
    double factor = 0.0;
  };
  void add(std::initializer_list<Term> terms, double right) {
    if (std::any_of(terms.begin(), terms.end(), [&](const Term& term) { return unknown_[term.node] == outside; }))
      return;
    const std::size_t before = jacobian_.column.size();
    for (const Term& term : terms) {
      if (unknown_[term.node] < 0) {
        right -= term.factor * over_[term.node];
        continue;
      }
      jacobian_.column.push_back(unknown_[term.node]);
      jacobian_.value.push_back(term.factor);
    }
    if (jacobian_.column.size() == before) return;
    jacobian_.row_start.push_back(static_cast<int>(jacobian_.column.size()));
    right_.push_back(right);
  }
  /// Heights over the plane of all nodes.
  [[nodiscard]] std::vector<double> solve() const {
    const std::vector<double> x = solve_normal(jacobian_, right_);
    std::vector<double> z = over_;
    for (std::size_t i = 0; i < z.size(); ++i)
      if (unknown_[i] >= 0) z[i] = x[static_cast<std::size_t>(unknown_[i])];
    return z;
  }

 private:
  static constexpr int fixed = -1, outside = -2;
  SparseJacobian jacobian_;
  std::vector<double> right_;
  const std::vector<double>& over_;
  std::vector<int> unknown_;
};

void add_bending(const FieldGrid& grid, Rows& rows) {
  const auto columns = static_cast<std::size_t>(grid.columns), lines = static_cast<std::size_t>(grid.rows);
  const double k = 1.0 / grid.spacing_m, twist = std::sqrt(2.0) * k;
  for (std::size_t r = 0; r < lines; ++r)
    for (std::size_t c = 0; c < columns; ++c) {
      const std::size_t i = r * columns + c;
      if (c > 0 && c + 1 < columns) rows.add({{i - 1, k}, {i, -2.0 * k}, {i + 1, k}}, 0.0);
      if (r > 0 && r + 1 < lines) rows.add({{i - columns, k}, {i, -2.0 * k}, {i + columns, k}}, 0.0);
      if (c + 1 < columns && r + 1 < lines)
        rows.add({{i, twist}, {i + 1, -twist}, {i + columns, -twist}, {i + columns + 1, twist}}, 0.0);
    }
}

}  // namespace

std::vector<double> bend_least(const FieldGrid& grid, const std::vector<NodeTarget>& targets,
                               const std::vector<char>& asked) {
  const auto is_asked = [&](std::size_t i) { return asked.empty() || asked[i] != 0; };
  const Plane plane = plane_of(grid, targets);
  std::vector<double> over(targets.size(), 0.0);
  bool all_fixed = true;
  for (std::size_t i = 0; i < targets.size(); ++i) {
    if (std::isfinite(targets[i].smoothing_m)) over[i] = targets[i].z - plane.at(grid.node(i));
    all_fixed = all_fixed && (targets[i].smoothing_m == 0.0 || !is_asked(i));
  }
  std::vector<double> z = over;
  if (!all_fixed) {
    Rows rows(targets, over, asked);
    add_bending(grid, rows);
    for (std::size_t i = 0; i < targets.size(); ++i) {
      const auto spring = [&](double smoothing) { return grid.spacing_m / (smoothing * smoothing); };
      if (targets[i].smoothing_m == 0.0 || !is_asked(i)) continue;
      rows.add({{i, spring(anchor_smoothing_m)}}, 0.0);
      if (std::isfinite(targets[i].smoothing_m))
        rows.add({{i, spring(targets[i].smoothing_m)}}, spring(targets[i].smoothing_m) * over[i]);
    }
    z = rows.solve();
  }
  for (std::size_t i = 0; i < z.size(); ++i) z[i] += plane.at(grid.node(i));
  return z;
}

FieldRoad over_grid(const FieldGrid& grid, const RoadCover& cover, RoadRole role, const std::vector<char>& asked) {
  FieldRoad road{role, {}};
  const auto nodes = [&](double from, double to, int count) {
    const auto at = [&](double v) { return std::clamp(static_cast<int>(v / grid.spacing_m), 0, count - 1); };
    return std::pair(at(from - 1.0), at(to + 1.0));  // the bounds hold corners, not the arcs between
  };
  const Box2& box = cover.bounds();
  const auto [column0, column1] = nodes(box.min_x - grid.origin.x, box.max_x - grid.origin.x, grid.columns);
  const auto [row0, row1] = nodes(box.min_y - grid.origin.y, box.max_y - grid.origin.y, grid.rows);
  for (int r = row0; r <= row1; ++r)
    for (int c = column0; c <= column1; ++c) {
      const auto i = static_cast<std::size_t>(r) * static_cast<std::size_t>(grid.columns) + static_cast<std::size_t>(c);
      if (!asked.empty() && asked[i] == 0) continue;
      if (const auto place = cover.find(grid.node(i), false)) road.nodes.push_back({i, cover.height(*place)});
    }
  return road;
}

namespace {

/// The strip of the arm that begins nearest to p.
NodeTarget entry_target(const std::vector<roadquery::JunctionArm>& entries, Vec2 p) {
  NodeTarget target;
  double nearest = roadquery::junction_transition_m;
  for (const roadquery::JunctionArm& arm : entries) {
    if (arm.places.size() < 2) continue;
    const Vec2 in{arm.in_x, arm.in_y}, d = p - Vec2{arm.x, arm.y};
    const double in_m = dot(in, d), left_m = cross(in, d), inside_m = in_m - roadquery::arm_begin(arm, left_m);
    if (inside_m < 0.0 || inside_m > nearest || left_m < arm.places.front().left_m || left_m > arm.places.back().left_m)
      continue;
    nearest = inside_m;
    target = {roadquery::arm_height(arm, in_m, left_m), std::max(inside_m, entry_smoothing_m)};
  }
  return target;
}

}  // namespace

std::vector<NodeTarget> field_targets(const FieldGrid& grid, const std::vector<FieldRoad>& roads,
                                      const std::vector<roadquery::JunctionArm>& entries) {
  struct Strongest {
    RoadRole role = RoadRole::turning;
    double sum = 0.0, count = 0.0;
  };
  std::vector<Strongest> strongest(grid.size());
  for (const FieldRoad& road : roads)
    for (const FieldRoad::Node& at : road.nodes) {
      Strongest& node = strongest[at.node];
      if (node.count > 0.0 && road.role > node.role) continue;
      if (node.count == 0.0 || road.role < node.role) node = {road.role, 0.0, 0.0};
      node.sum += at.z, node.count += 1.0;
    }
  std::vector<NodeTarget> targets(grid.size());
  for (std::size_t i = 0; i < targets.size(); ++i) {
    const Strongest& node = strongest[i];
    if (node.count > 0.0) targets[i] = {node.sum / node.count, smoothing_of(node.role)};
    if (node.count > 0.0 && node.role < RoadRole::turning) continue;
    if (const NodeTarget entry = entry_target(entries, grid.node(i)); std::isfinite(entry.smoothing_m))
      targets[i] = entry;
  }
  return targets;
}

}  // namespace orthodrive::network
