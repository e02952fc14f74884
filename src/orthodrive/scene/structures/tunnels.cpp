// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/scene/structures/tunnels.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string_view>

#include "orthodrive/geo/overlay.hpp"
#include "orthodrive/model/roads/highway_class.hpp"
#include "orthodrive/scene/plan/plan_grid.hpp"

namespace orthodrive::scene {
namespace {

constexpr double tunnel_step_m = 2.0, shortest_roof_m = 6.0, longest_quiet_m = 30.0;
constexpr double walkway_m = 0.75, walkway_rise_m = 0.12, slab_m = 0.4, wall_m = 0.4, parapet_m = 0.3;
constexpr double bevel_m = 0.8;  // of the vault's corners
constexpr double headwall_rise_m = 0.6, headwall_m = 0.5;
constexpr double into_road_m = 0.03, below_road_m = 0.1;  // so that no gap shows between a chord and the exact edge
constexpr double portal_foot_m = 0.3, near_cover_m = 10.0, other_level_m = 1.5, across_step_m = 1.5;
constexpr LinearColor lining = {0.34F, 0.34F, 0.32F}, wall_concrete = {0.33F, 0.32F, 0.30F};

struct Clearance {
  double wanted_m = 4.7, least_m = 3.8;
};

Clearance clearance_of(const roadquery::Road& road) {
  constexpr std::array<std::string_view, 5> paths = {"footway", "path", "cycleway", "steps", "pedestrian"};
  if (std::ranges::find(paths, road.highway) != paths.end()) return {3.0, 2.3};
  if (is_fast_class(road.highway)) return {5.0, 3.8};
  return {};
}

struct Station {
  double s_m = 0.0;
  Vec3 right, left;      ///< edges of the road
  Vec2 across;           ///< from right to left
  double cover_m = 0.0;  ///< least height of the ground over the road, in all the tube's width
  double vault_m = 0.0;  ///< height of the vault over the road
  bool is_open = false, is_under_road = false;

  [[nodiscard]] bool is_roofed() const { return !is_open || is_under_road; }
  /// `off_m` beyond the road's edge, `rise_m` over it.
  [[nodiscard]] Vec3 on_right(double off_m, double rise_m) const {
    return {right.x - across.x * off_m, right.y - across.y * off_m, right.z + rise_m};
  }
  [[nodiscard]] Vec3 on_left(double off_m, double rise_m) const {
    return {left.x + across.x * off_m, left.y + across.y * off_m, left.z + rise_m};
  }
  [[nodiscard]] Vec3 beside(bool is_left, double off_m, double rise_m) const {
    return is_left ? on_left(off_m, rise_m) : on_right(off_m, rise_m);
  }
};

Vec2 plan_of_tunnel(const Vec3& p) { return {p.x, p.y}; }

/// Looks from one side of the tube to the other.
void look_up(const TunnelInput& input, const Clearance& clearance, Station& station) {
  const double half_m = walkway_m + wall_m,
               width_m = distance(plan_of_tunnel(station.right), plan_of_tunnel(station.left)) + 2.0 * half_m;
  const int steps = std::max(1, static_cast<int>(std::ceil(width_m / across_step_m)));
  station.cover_m = std::numeric_limits<double>::infinity();
  double under_m = station.cover_m;
  for (int k = 0; k <= steps; ++k) {
    const double off_m = width_m * k / steps - half_m;
    const Vec2 p = plan_of_tunnel(station.right) + station.across * off_m;
    const double share = std::clamp(off_m / (width_m - 2.0 * half_m), 0.0, 1.0);
    const double floor_m = station.right.z + (station.left.z - station.right.z) * share;
    station.cover_m = std::min(station.cover_m, input.ground.height_m(p) - floor_m);
    if (const auto road = input.roads.sample(p, 0.0); road && road->z_m - floor_m > other_level_m)
      under_m = std::min(under_m, road->z_m - floor_m);
  }
  station.is_open = station.cover_m < clearance.least_m + slab_m;
  station.is_under_road = std::isfinite(under_m);
  station.vault_m = std::min(clearance.wanted_m, (station.is_open ? under_m : station.cover_m) - slab_m);
}

std::vector<Station> stations_of(const TunnelInput& input, std::size_t road) {
  const roadquery::Road& tunnel = input.query.map().roads[road];
  const Clearance clearance = clearance_of(tunnel);
  const int steps = std::max(1, static_cast<int>(std::ceil(tunnel.length / tunnel_step_m)));
  std::vector<Station> stations;
  for (int i = 0; i <= steps; ++i) {
    const double s = tunnel.length * i / steps;
    const auto cut = input.query.section(road, s);
    if (!cut) continue;
    Station& station = stations.emplace_back();
    station.s_m = s;
    station.right = {cut->right[0], cut->right[1], cut->right[2]};
    station.left = {cut->left[0], cut->left[1], cut->left[2]};
    station.across = normalized(plan_of_tunnel(station.left) - plan_of_tunnel(station.right));
    look_up(input, clearance, station);
  }
  // The slab below a road ends beside it.
  std::vector<bool> is_under(stations.size());
  for (std::size_t i = 0; i < stations.size(); ++i) is_under[i] = stations[i].is_under_road;
  for (std::size_t i = 0; i < stations.size(); ++i) {
    if (is_under[i]) continue;
    for (const std::size_t k : {i - 1, i + 1}) {
      if (k >= stations.size() || !is_under[k]) continue;
      stations[i].is_under_road = true;
      if (stations[i].is_open) stations[i].vault_m = stations[k].vault_m;
    }
  }
  // A roof of a few metres between two openings is none; one under a road stays.
  for (std::size_t i = 0; i < stations.size();) {
    std::size_t end = i;
    while (end < stations.size() && !stations[end].is_open) ++end;
    const bool is_between = i > 0 && end < stations.size() && end > i;
    if (is_between && stations[end].s_m - stations[i - 1].s_m < shortest_roof_m)
      for (std::size_t k = i; k < end; ++k) stations[k].is_open = true;
    i = std::max(end, i + 1);
  }
  return stations;
}

/// Between two stations.
struct TunnelPiece {
  const Station &from, &to;
  bool is_first = false, is_last = false;  ///< of the road
  [[nodiscard]] bool is_open() const { return from.is_open || to.is_open; }
  [[nodiscard]] bool is_roofed() const { return from.is_roofed() && to.is_roofed(); }
  [[nodiscard]] Vec2 middle() const {
    return (plan_of_tunnel(from.right) + plan_of_tunnel(from.left) + plan_of_tunnel(to.right) +
            plan_of_tunnel(to.left)) *
           0.25;
  }
};

/// With the points of joints at the ends of the road, so that it has edges in common with the road beyond.
Polygon opening_of(const TunnelPiece& piece, std::span<const Vec2> at_start, std::span<const Vec2> at_end) {
  const auto corner = [](const Station& s, bool is_left) {
    return snap_to_grid(plan_of_tunnel(s.beside(is_left, walkway_m, 0.0)));
  };
  const Vec2 from_right = corner(piece.from, false), from_left = corner(piece.from, true),
             to_right = corner(piece.to, false), to_left = corner(piece.to, true);
  Ring ring = convex_hull({from_right, from_left, to_right, to_left});
  if (piece.is_first) insert_between(ring, from_left, from_right, {at_start.rbegin(), at_start.rend()});
  if (piece.is_last) insert_between(ring, to_right, to_left, {at_end.begin(), at_end.end()});
  return {std::move(ring), {}};
}

class TunnelFaces {
 public:
  TunnelFaces(const TunnelInput& input, const RoadLevel& level) : input_(input), level_(level) {}

  void add(const TunnelPiece& piece) {
    for (const bool is_left : {false, true}) {
      if (!is_free_beside(piece, is_left)) continue;
      add_walkway(piece, is_left);
      if (piece.is_open()) add_wall(piece, is_left);
      if (piece.is_roofed()) add_side(piece, is_left);
    }
    if (piece.is_roofed()) add_vault(piece);
  }

  /// Across at a station, seen from the open side: `ahead`: the tube lies ahead of it along the road.
  void add_portal(const Station& station, Vec2 along, bool ahead) {
    const Vec2 inwards = ahead ? along : along * -1.0;
    double top_z = -std::numeric_limits<double>::infinity();
    for (double share = 0.0; share <= 1.0; share += 0.25) {
      const Vec3 a = station.on_right(walkway_m + wall_m, 0.0), b = station.on_left(walkway_m + wall_m, 0.0);
      for (const double in_m : {0.0, headwall_m})
        top_z =
            std::max(top_z, input_.ground.height_m(plan_of_tunnel(a) + (plan_of_tunnel(b) - plan_of_tunnel(a)) * share +
                                                   inwards * in_m));
    }
    top_z = std::max(top_z, std::max(station.right.z, station.left.z) + station.vault_m + slab_m) + headwall_rise_m;
    const double vault_m = station.vault_m, side_m = vault_m - bevel_m, edge_m = walkway_m + wall_m;
    const std::array<Vec3, 8> low = {
        station.on_right(edge_m, -portal_foot_m),      station.on_right(walkway_m, -portal_foot_m),
        station.on_right(walkway_m, side_m),           station.on_right(walkway_m - bevel_m, vault_m),
        station.on_left(walkway_m - bevel_m, vault_m), station.on_left(walkway_m, side_m),
        station.on_left(walkway_m, -portal_foot_m),    station.on_left(edge_m, -portal_foot_m)};
    const auto top = [&](Vec3 p) { return Vec3{p.x, p.y, top_z}; };
    const auto back = [&](Vec3 p) { return Vec3{p.x + inwards.x * headwall_m, p.y + inwards.y * headwall_m, p.z}; };
    for (std::size_t k = 0; k + 1 < low.size(); ++k) {
      if (plan_of_tunnel(low[k]) == plan_of_tunnel(low[k + 1])) continue;
      // From right to left; against the road that is from left to right.
      quad(ahead, {low[k + 1], low[k], top(low[k]), top(low[k + 1])}, wall_concrete);
      quad(ahead, {back(low[k]), back(low[k + 1]), back(top(low[k + 1])), back(top(low[k]))}, wall_concrete);
    }
    const Vec3 right = low.front(), left = low.back();
    quad(ahead, {top(left), top(right), back(top(right)), back(top(left))}, wall_concrete);
    quad(ahead, {right, back(right), back(top(right)), top(right)}, wall_concrete);
    quad(ahead, {back(left), left, top(left), back(top(left))}, wall_concrete);
  }

  std::vector<StructureFace> all;

 private:
  void quad(bool as_it_is, std::array<Vec3, 4> corners, const LinearColor& color) {
    if (!as_it_is) std::ranges::reverse(corners);
    all.push_back({.corners = corners, .color = color});
  }

  [[nodiscard]] bool is_paved(Vec2 p, double z) const {
    constexpr double same_floor_m = 2.0;
    const auto near = [&](const RoadLevel& level) {
      const auto on = level.sample(p, 0.0);
      return on && std::abs(on->z_m - z) < same_floor_m;
    };
    return near(input_.roads) || near(level_);
  }

  [[nodiscard]] bool is_free_beside(const TunnelPiece& piece, bool is_left) const {
    for (const double off_m : {0.3, walkway_m}) {
      const Vec3 a = piece.from.beside(is_left, off_m, 0.0), b = piece.to.beside(is_left, off_m, 0.0);
      for (const double share : {0.1, 0.5, 0.9})
        if (is_paved(plan_of_tunnel(a) + (plan_of_tunnel(b) - plan_of_tunnel(a)) * share, a.z + (b.z - a.z) * share))
          return false;
    }
    return true;
  }

  /// Faces along a profile of places seen from inside, which goes up on the right.
  void sweep(const TunnelPiece& piece, bool is_left, std::span<const Vec2> profile) {
    for (std::size_t k = 0; k + 1 < profile.size(); ++k) {
      const auto at = [&](const Station& s, std::size_t i) { return s.beside(is_left, profile[i].x, profile[i].y); };
      quad(!is_left, {at(piece.to, k), at(piece.from, k), at(piece.from, k + 1), at(piece.to, k + 1)}, lining);
    }
  }
  void add_walkway(const TunnelPiece& piece, bool is_left) {
    const std::array<Vec2, 3> kerb = {
        Vec2{-into_road_m, -below_road_m}, {-into_road_m, walkway_rise_m}, {walkway_m, walkway_rise_m}};
    sweep(piece, is_left, kerb);
    const auto end = [&](const Station& s, bool as_it_is) {
      const auto at = [&](double off_m, double rise_m) { return s.beside(is_left, off_m, rise_m); };
      quad(as_it_is,
           {at(walkway_m, -portal_foot_m), at(-into_road_m, -portal_foot_m), at(-into_road_m, walkway_rise_m),
            at(walkway_m, walkway_rise_m)},
           lining);
    };
    // Seen from the road before its start, the right side lies on the right.
    if (piece.is_first) end(piece.from, is_left);
    if (piece.is_last) end(piece.to, !is_left);
  }
  /// With the vault's bevelled corner: its height differs from station to station.
  void add_side(const TunnelPiece& piece, bool is_left) {
    const auto at = [&](const Station& s) {
      return std::array{s.beside(is_left, walkway_m, -portal_foot_m), s.beside(is_left, walkway_m, s.vault_m - bevel_m),
                        s.beside(is_left, walkway_m - bevel_m, s.vault_m)};
    };
    const auto from = at(piece.from), to = at(piece.to);
    for (std::size_t k = 0; k < 2; ++k) quad(!is_left, {to[k], from[k], from[k + 1], to[k + 1]}, lining);
  }
  void add_vault(const TunnelPiece& piece) {
    const auto right = [](const Station& s) { return s.on_right(walkway_m - bevel_m, s.vault_m); };
    const auto left = [](const Station& s) { return s.on_left(walkway_m - bevel_m, s.vault_m); };
    quad(true, {right(piece.to), right(piece.from), left(piece.from), left(piece.to)}, lining);
    if (!piece.is_open()) return;
    // The slab's upper side, beside the road that it lies under.
    const auto outer = [](const Station& s, bool is_left) {
      return s.beside(is_left, walkway_m + wall_m, s.vault_m + slab_m);
    };
    quad(true, {outer(piece.from, false), outer(piece.to, false), outer(piece.to, true), outer(piece.from, true)},
         wall_concrete);
  }
  /// From below road and ground to a little over both.
  void add_wall(const TunnelPiece& piece, bool is_left) {
    struct Section {
      std::array<Vec3, 4> corners;  // inner foot, inner top, outer top, outer foot
    };
    const auto section = [&](const Station& s) {
      const double floor_z = s.beside(is_left, 0.0, 0.0).z;
      const Vec3 inner = s.beside(is_left, walkway_m, 0.0), outer = s.beside(is_left, walkway_m + wall_m, 0.0);
      const double inner_z = input_.ground.height_m(plan_of_tunnel(inner)),
                   outer_z = input_.ground.height_m(plan_of_tunnel(outer));
      const double high = std::max(inner_z, outer_z), step = std::abs(high - floor_z);
      const double top = std::max(high, floor_z) + std::min(parapet_m, 0.05 + parapet_m * step);
      const double foot = std::min({floor_z, inner_z, outer_z}) - portal_foot_m;
      return Section{
          {Vec3{inner.x, inner.y, foot}, {inner.x, inner.y, top}, {outer.x, outer.y, top}, {outer.x, outer.y, foot}}};
    };
    const Section from = section(piece.from), to = section(piece.to);
    for (std::size_t k = 0; k < 3; ++k)
      quad(!is_left, {to.corners[k], from.corners[k], from.corners[k + 1], to.corners[k + 1]}, wall_concrete);
    if (piece.is_first)
      quad(!is_left, {from.corners[0], from.corners[3], from.corners[2], from.corners[1]}, wall_concrete);
    if (piece.is_last) quad(!is_left, {to.corners[0], to.corners[1], to.corners[2], to.corners[3]}, wall_concrete);
  }

  const TunnelInput& input_;
  const RoadLevel& level_;
};

/// The union less the roads on the ground; component by component, so that no overlay is large.
MultiPolygon openings_of(const std::vector<Polygon>& pieces, const RoadLevel& roads, const MultiPolygon& area) {
  if (pieces.empty()) return {};
  MultiPolygon openings;
  for (const Polygon& part : union_of(pieces, plan_grid_m)) {
    const MultiPolygon paved = roads.paved_near(bounds_of(part.outer).grown(1.0), {});
    MultiPolygon left = {part};
    if (!paved.empty()) left = difference_of(left, union_of(paved, plan_grid_m), plan_grid_m);
    left = intersection_of(left, area, plan_grid_m);
    openings.insert(openings.end(), left.begin(), left.end());
  }
  return openings;
}

/// Long stretches without a roof, told at 15 m from where they begin.
void find_open_stretches(const roadquery::Road& road, const std::vector<Station>& stations, Findings& findings) {
  for (std::size_t i = 0; i < stations.size();) {
    std::size_t end = i;
    while (end < stations.size() && !stations[end].is_roofed()) ++end;
    if (end > i && stations[end - 1].s_m - stations[i].s_m >= longest_quiet_m) {
      std::size_t k = i;
      while (stations[k].s_m - stations[i].s_m < 0.5 * longest_quiet_m) ++k;
      findings.push_back({Severity::warning, "scene.tunnel_without_cover",
                          fmt::format("tunnel road {} lies less than its height below the ground and is drawn as an "
                                      "open cutting for more than {:.0f} m",
                                      road.id, longest_quiet_m),
                          stations[k].right.x, stations[k].right.y});
    }
    i = std::max(end, i + 1);
  }
}

}  // namespace

Tunnels build_tunnels(const TunnelInput& input, const MultiPolygon& area) {
  Tunnels result;
  std::vector<Polygon> open;
  for (const RoadLevel& level : input.tunnels) {
    TunnelFaces faces(input, level);
    for (const roadquery::Road* road : level.roads()) {
      const auto index = static_cast<std::size_t>(road - input.query.map().roads.data());
      const auto stations = stations_of(input, index);
      if (stations.size() < 2) continue;
      bool was_roofed = stations.front().is_roofed();
      const auto along_at = [&](std::size_t i) { return left_normal(stations[i].across) * -1.0; };
      for (std::size_t i = 0; i + 1 < stations.size(); ++i) {
        const TunnelPiece piece{stations[i], stations[i + 1], i == 0, i + 2 == stations.size()};
        if (piece.is_open()) {
          Polygon opening = opening_of(piece, input.joints.across(index).start, input.joints.across(index).end);
          if (opening.outer.size() >= 3) open.push_back(std::move(opening));
        }
        if (!input.area.contains(piece.middle())) {
          was_roofed = stations[i + 1].is_roofed();
          continue;
        }
        faces.add(piece);
        if (was_roofed != piece.is_roofed()) faces.add_portal(stations[i], along_at(i), piece.is_roofed());
        was_roofed = piece.is_roofed();
        if (piece.is_last && !was_roofed && stations[i + 1].is_roofed())
          faces.add_portal(stations[i + 1], along_at(i + 1), true);
        for (const double share : {0.0, 0.5, 1.0})
          if (!stations[i].is_open && stations[i].cover_m < near_cover_m)
            result.ground_points.push_back(plan_of_tunnel(stations[i].on_right(walkway_m, 0.0)) * (1.0 - share) +
                                           plan_of_tunnel(stations[i].on_left(walkway_m, 0.0)) * share);
      }
      find_open_stretches(*road, stations, result.findings);
    }
    result.faces.insert(result.faces.end(), faces.all.begin(), faces.all.end());
  }
  sort_by_place(result.faces);  // which levels tunnels make depends on how many are laid out
  result.openings = openings_of(open, input.roads, area);
  return result;
}

}  // namespace orthodrive::scene
