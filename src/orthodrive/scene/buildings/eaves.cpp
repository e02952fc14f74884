// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/scene/buildings/eaves.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>

#include "orthodrive/scene/plan/plan_grid.hpp"

namespace orthodrive::scene {
namespace {

using Key = std::array<double, 2>;
Key key_of(const Vec3& p) { return {p.x, p.y}; }

Vec2 outwards_of(const Ring& ring, std::size_t edge) {
  return left_normal(normalized(ring[(edge + 1) % ring.size()] - ring[edge])) * -1.0;
}

/// Where the lines beside two edges that meet in a corner meet, from there.
Vec2 corner_step(Vec2 n, double n_m, Vec2 m, double m_m) {
  constexpr double parallel = 0.1;  // sine
  const double sine = cross(n, m);
  if (std::abs(sine) < parallel) return (n + m) * (0.5 * std::min(n_m, m_m));
  // d with dot(d, n) = n_m and dot(d, m) = m_m
  return {(n_m * m.y - m_m * n.y) / sine, (m_m * n.x - n_m * m.x) / sine};
}

/// How the points of the slopes' border move in plan; nothing for those inside.
class Steps {
 public:
  Steps(const Ring& outer, std::span<const double> out_m) : outer_(outer), out_m_(out_m) {
    for (std::size_t i = 0; i < outer.size(); ++i) {
      const std::size_t before = (i + outer.size() - 1) % outer.size();
      corners_[{outer[i].x, outer[i].y}] =
          corner_step(outwards_of(outer, before), out_m[before], outwards_of(outer, i), out_m[i]);
    }
  }
  [[nodiscard]] Vec2 at(const Vec3& p) const {
    if (const auto corner = corners_.find(key_of(p)); corner != corners_.end()) return corner->second;
    constexpr double on_edge_m = 4.0 * plan_grid_m;
    for (std::size_t i = 0; i < outer_.size(); ++i) {
      const Vec2 a = outer_[i], b = outer_[(i + 1) % outer_.size()], u = normalized(b - a), d = Vec2{p.x, p.y} - a;
      if (std::abs(cross(u, d)) < on_edge_m && dot(u, d) > 0.0 && dot(u, d) < distance(a, b))
        return outwards_of(outer_, i) * out_m_[i];
    }
    return {};
  }

 private:
  const Ring& outer_;
  std::span<const double> out_m_;
  std::map<Key, Vec2> corners_;
};

double height_on(const std::array<Vec3, 3>& t, Vec2 p) {
  const Vec3 a = t[1] - t[0], b = t[2] - t[0];
  const Vec2 d = p - Vec2{t[0].x, t[0].y};
  const double det = a.x * b.y - a.y * b.x;
  return t[0].z + a.z * (d.x * b.y - d.y * b.x) / det + b.z * (a.x * d.y - a.y * d.x) / det;
}

double plan_area(const std::array<Vec3, 3>& t) {
  return (t[1].x - t[0].x) * (t[2].y - t[0].y) - (t[1].y - t[0].y) * (t[2].x - t[0].x);
}

Vec2 plan_of_eave(const Vec3& p) { return {p.x, p.y}; }

bool is_on_line(const Vec3& p, const Vec3& a, const Vec3& b) {
  return std::abs(cross(normalized(plan_of_eave(b) - plan_of_eave(a)), plan_of_eave(p) - plan_of_eave(a))) <
         2.0 * plan_grid_m;
}

/// Puts points into an edge of one of the triangles.
void split_edge(const Vec3& from, const Vec3& to, const std::vector<Vec3>& between,
                std::vector<std::array<Vec3, 3>>& triangles) {
  const auto is = [](const Vec3& p, const Vec3& q) { return p.x == q.x && p.y == q.y && p.z == q.z; };
  for (std::size_t i = 0; i < triangles.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3 a = triangles[i][k], b = triangles[i][(k + 1) % 3], c = triangles[i][(k + 2) % 3];
      if (!is(a, from) || !is(b, to)) continue;
      triangles[i] = {a, between.front(), c};
      for (std::size_t n = 0; n < between.size(); ++n)
        triangles.push_back({between[n], n + 1 < between.size() ? between[n + 1] : b, c});
      return;
    }
}

using Border = std::map<std::array<Key, 2>, std::array<Vec3, 2>>;  // edges of one triangle
struct Moved {
  Vec3 at;
  int planes = 0;
};
using MovedPoints = std::map<Key, Moved>;
constexpr double least_eave_m2 = 1e-4;

Border border_of(const Roof& roof) {
  Border border;
  for (const auto& slope : roof.slopes)
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3 a = slope[k], b = slope[(k + 1) % 3];
      if (border.erase({key_of(b), key_of(a)}) == 0) border[{key_of(a), key_of(b)}] = {a, b};
    }
  return border;
}

/// Where the points of the border go: out by the steps, at the mean height of the planes that meet there.
MovedPoints moved_points(const Roof& roof, const Border& border, const Steps& steps) {
  MovedPoints moved;
  for (const auto& [unused, edge] : border)
    for (const Vec3& p : edge) {
      const Vec2 q = snap_to_grid(Vec2{p.x, p.y} + steps.at(p));
      moved[key_of(p)] = {{q.x, q.y, 0.0}};
    }
  for (const auto& slope : roof.slopes)
    for (const Vec3& p : slope)
      if (const auto found = moved.find(key_of(p)); found != moved.end()) {
        found->second.at.z += height_on(slope, {found->second.at.x, found->second.at.y});
        ++found->second.planes;
      }
  for (auto& [unused, m] : moved) m.at.z /= m.planes;
  return moved;
}

/// The slopes with moved points; false where one would have no area.
bool move_slopes(const Roof& roof, const MovedPoints& moved, Eaves& eaves) {
  for (auto slope : roof.slopes) {
    for (Vec3& p : slope)
      if (const auto found = moved.find(key_of(p)); found != moved.end()) p = found->second.at;
    if (plan_area(slope) < least_eave_m2) return false;
    eaves.slopes.push_back(slope);
  }
  return true;
}

struct Quad {
  Vec3 a, b, b_out, a_out;
  [[nodiscard]] bool a_moves() const { return key_of(a) != key_of(a_out); }
  [[nodiscard]] bool b_moves() const { return key_of(b) != key_of(b_out); }
};

/// What is below the eaves, edge by edge; nothing where an edge would turn over.
std::optional<std::vector<Quad>> quads_below(const Border& border, const MovedPoints& moved, Eaves& eaves) {
  std::vector<Quad> below;
  for (const auto& [unused, edge] : border) {
    const Quad quad{edge[0], edge[1], moved.at(key_of(edge[1])).at, moved.at(key_of(edge[0])).at};
    const auto& [a, b, b_out, a_out] = quad;
    if (!quad.a_moves() && !quad.b_moves()) continue;
    if (dot(plan_of_eave(b) - plan_of_eave(a), plan_of_eave(b_out) - plan_of_eave(a_out)) <= 0.0) return std::nullopt;
    if (is_on_line(a_out, a, b) && is_on_line(b_out, a, b)) {
      // Eaves beside this edge have made the slope's border longer, along the wall that goes on below a part of it.
      const Vec2 along = plan_of_eave(b) - plan_of_eave(a);
      if (dot(plan_of_eave(a_out) - plan_of_eave(a), along) > 0.0 ||
          dot(plan_of_eave(b_out) - plan_of_eave(b), along) < 0.0)
        return std::nullopt;
      std::vector<Vec3> between;
      if (quad.a_moves()) between.push_back(a);
      if (quad.b_moves()) between.push_back(b);
      split_edge(a_out, b_out, between, eaves.slopes);
      continue;
    }
    below.push_back(quad);
  }
  return below;
}

/// A diagonal of the slope above would be an edge of four triangles: then the soffit has the other one.
void add_soffits(const std::vector<Quad>& below, Eaves& eaves) {
  std::set<std::array<Key, 2>> edges;
  for (const auto& slope : eaves.slopes)
    for (std::size_t k = 0; k < 3; ++k) edges.insert({key_of(slope[k]), key_of(slope[(k + 1) % 3])});
  for (const Quad& quad : below) {
    const auto& [a, b, b_out, a_out] = quad;
    const std::array<Key, 2> diagonal = {key_of(a), key_of(b_out)};
    if (quad.a_moves() && quad.b_moves() && (edges.contains(diagonal) || edges.contains({diagonal[1], diagonal[0]}))) {
      eaves.soffits.push_back({a, b, a_out});
      eaves.soffits.push_back({b, b_out, a_out});
      continue;
    }
    if (quad.b_moves()) eaves.soffits.push_back({a, b, b_out});
    if (quad.a_moves()) eaves.soffits.push_back({a, b_out, a_out});
  }
}

}  // namespace

Eaves with_eaves(const Roof& roof, const Ring& outer, std::span<const double> out_m) {
  Eaves as_it_is{roof.slopes, {}};
  if (std::ranges::all_of(out_m, [](double m) { return m == 0.0; })) return as_it_is;
  const Border border = border_of(roof);
  const MovedPoints moved = moved_points(roof, border, Steps(outer, out_m));
  Eaves eaves;
  if (!move_slopes(roof, moved, eaves)) return as_it_is;
  const auto below = quads_below(border, moved, eaves);
  if (!below) return as_it_is;
  add_soffits(*below, eaves);
  for (const auto& soffit : eaves.soffits)
    if (plan_area(soffit) > -least_eave_m2) return as_it_is;
  return eaves;
}

}  // namespace orthodrive::scene
