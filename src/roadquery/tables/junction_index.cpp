// SPDX-License-Identifier: Apache-2.0
#include "roadquery/tables/junction_index.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <unordered_map>

namespace roadquery {
namespace {

constexpr double widest_junction_m = 5000.0;

void check_bounds(const Junction& junction, const JunctionSurface& surface) {
  double west = std::numeric_limits<double>::infinity(), south = west, east = -west, north = -west;
  bool are_places = true;
  for (const auto& [x, y] : surface.boundary) {
    are_places = are_places && std::max(std::abs(x), std::abs(y)) <= 1e9 && !std::isnan(x + y);
    west = std::min(west, x), east = std::max(east, x);
    south = std::min(south, y), north = std::max(north, y);
  }
  if (!(are_places && east - west <= widest_junction_m && north - south <= widest_junction_m))
    throw std::runtime_error("junction " + std::to_string(junction.id) + " has a boundary wider than 5 km");
}

/// Rises with y, so that a strip has all edges that pass one of its points.
template <typename Area>
std::uint32_t strip_of(const Area& area, double y) {
  return static_cast<std::uint32_t>(std::clamp((y - area.south) * area.strips_per_m, 0.0, area.strips - 1.0));
}

/// Calls visit(strip) for the strips that an edge passes.
template <typename Area, typename Edge, typename Visit>
void for_strips(const Area& area, const Edge& edge, const Visit& visit) {
  const std::uint32_t last = strip_of(area, std::max(edge.y0, edge.y1));
  for (std::uint32_t k = strip_of(area, std::min(edge.y0, edge.y1)); k <= last; ++k) visit(k);
}

/// Calls mark(column, row) for cells of a field that an edge passes, or that an arm counts in.
template <typename Mark>
class CellMarker {
 public:
  CellMarker(const JunctionSurface& surface, const Mark& mark)
      : surface_(surface), mark_(mark), per_m_(1.0 / surface.spacing_m) {}

  void add_edge(const std::array<double, 2>& from, const std::array<double, 2>& to) {
    constexpr double rounding = 1e-3;  // of a cell
    const double x0 = (from[0] - surface_.x) * per_m_, y0 = (from[1] - surface_.y) * per_m_;
    const double x1 = (to[0] - surface_.x) * per_m_, y1 = (to[1] - surface_.y) * per_m_;
    const int last = cell(std::max(y0, y1) + rounding, surface_.rows);
    for (int row = cell(std::min(y0, y1) - rounding, surface_.rows); row <= last; ++row) {
      // The part of the edge in this row of cells; the first and the last row hold what lies beyond as well.
      const auto along = [&](double y) { return std::clamp(y1 == y0 ? 0.0 : (y - y0) / (y1 - y0), 0.0, 1.0); };
      const bool is_level = std::abs(y1 - y0) < 2.0 * rounding;
      const double a = is_level ? 0.0 : along(row - rounding), b = is_level ? 1.0 : along(row + 1.0 + rounding);
      const double xa = x0 + a * (x1 - x0), xb = x0 + b * (x1 - x0);
      const int end = cell(std::max(xa, xb) + rounding, surface_.columns);
      for (int column = cell(std::min(xa, xb) - rounding, surface_.columns); column <= end; ++column)
        mark_(column, row);
    }
  }
  void add_arm(const JunctionArm& arm) {
    if (arm.places.size() < 2) return;
    const double around = surface_.spacing_m;  // more than from a cell's middle to its corner
    const double right = arm.places.front().left_m - beside_arm_m - around,
                 left = arm.places.back().left_m + beside_arm_m + around,
                 in = junction_transition_m + arm.slant_m + around;
    const double reach = in + std::max(std::abs(right), std::abs(left));
    const int last_row = cell((arm.y + reach - surface_.y) * per_m_, surface_.rows),
              last_column = cell((arm.x + reach - surface_.x) * per_m_, surface_.columns);
    for (int row = cell((arm.y - reach - surface_.y) * per_m_, surface_.rows); row <= last_row; ++row)
      for (int column = cell((arm.x - reach - surface_.x) * per_m_, surface_.columns); column <= last_column;
           ++column) {
        const double dx = surface_.x + (column + 0.5) * surface_.spacing_m - arm.x,
                     dy = surface_.y + (row + 0.5) * surface_.spacing_m - arm.y;
        const double in_m = arm.in_x * dx + arm.in_y * dy, left_m = arm.in_x * dy - arm.in_y * dx;
        if (!(std::abs(in_m) > in || left_m < right || left_m > left)) mark_(column, row);
      }
  }

 private:
  /// Of NaN the first one.
  static int cell(double at, int count) {
    return at > 0.0 ? static_cast<int>(std::min(at, static_cast<double>(count - 1))) : 0;
  }
  const JunctionSurface& surface_;
  const Mark& mark_;
  double per_m_;
};

bool is_usable(const JunctionSurface& surface) {
  constexpr double most_m = 1e9;
  return surface.columns >= 4 && surface.rows >= 4 && surface.spacing_m > 0.0 &&
         surface.z.size() == static_cast<std::size_t>(surface.columns) * static_cast<std::size_t>(surface.rows) &&
         std::all_of(surface.z.begin(), surface.z.end(), [](double z) { return std::abs(z) <= most_m; });
}

}  // namespace

JunctionIndex::JunctionIndex(const RoadMap& map) {
  if (std::none_of(map.junctions.begin(), map.junctions.end(), surface_of)) return;
  std::unordered_map<int, std::uint32_t> index;
  for (const Junction& junction : map.junctions) {
    if (const JunctionSurface* surface = surface_of(junction)) {
      check_bounds(junction, *surface);
      index.emplace(junction.id, static_cast<std::uint32_t>(areas_.size()));
      add(*surface);
    } else {
      areas_.emplace_back();
    }
  }
  roads_.resize(map.junctions.size());
  for (std::uint32_t r = 0; r < map.roads.size(); ++r)
    if (const auto found = index.find(map.roads[r].junction); found != index.end()) roads_[found->second].push_back(r);
}

void JunctionIndex::add(const JunctionSurface& surface) {
  Area area;
  area.x = surface.x, area.y = surface.y, area.spacing_m = surface.spacing_m;
  area.columns = surface.columns, area.rows = surface.rows;
  area.z = static_cast<std::uint32_t>(z_.size());
  z_.insert(z_.end(), surface.z.begin(), surface.z.end());
  area.arms = static_cast<std::uint32_t>(arms_.size()),
  area.arm_count = static_cast<std::uint32_t>(surface.arms.size());
  arms_.insert(arms_.end(), surface.arms.begin(), surface.arms.end());
  area.inverse_spacing = 1.0 / surface.spacing_m;
  cut_into_strips(surface.boundary, area);
  area.inner = static_cast<std::uint32_t>(inner_.size());
  areas_.push_back(area);
  find_inner(surface, static_cast<std::uint32_t>(areas_.size() - 1));
}

void JunctionIndex::find_inner(const JunctionSurface& surface, std::uint32_t junction) {
  const std::size_t first = inner_.size();
  inner_.resize(first + surface.z.size(), unknown);
  if (!is_usable(surface)) return;
  const auto cell_of = [&](int column, int row) {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(surface.columns) + static_cast<std::size_t>(column);
  };
  std::vector<bool> on_boundary(surface.z.size(), false);
  const auto pass = [&](int column, int row) { on_boundary[cell_of(column, row)] = true; };
  const auto& ring = surface.boundary;
  for (std::size_t i = 0, before = ring.size() - 1; i < ring.size(); before = i++)
    CellMarker(surface, pass).add_edge(ring[before], ring[i]);
  for (int row = 1; row + 2 < surface.rows; ++row) {
    bool known = false, inside = false;  // what one cell is the next one is, unless the boundary passes between
    for (int column = 1; column + 2 < surface.columns; ++column) {
      if (on_boundary[cell_of(column, row)]) {
        known = false;
        continue;
      }
      if (!known)
        inside = contains(junction, surface.x + (column + 0.5) * surface.spacing_m,
                          surface.y + (row + 0.5) * surface.spacing_m);
      known = true;
      inner_[first + cell_of(column, row)] = inside ? no_arm : unknown;
    }
  }
  constexpr std::size_t most_arms = 255 - first_arm;
  for (std::size_t k = 0; k < surface.arms.size(); ++k) {
    const auto count = [&](int column, int row) {
      std::uint8_t& inner = inner_[first + cell_of(column, row)];
      if (inner == no_arm && k < most_arms)
        inner = static_cast<std::uint8_t>(first_arm + k);
      else if (inner != unknown)
        inner = several_arms;
    };
    CellMarker(surface, count).add_arm(surface.arms[k]);
  }
}

void JunctionIndex::cut_into_strips(std::span<const std::array<double, 2>> ring, Area& area) {
  constexpr double strip_m = 1.0;
  constexpr std::size_t most_in_strips = 16;  // times the edges: memory stays linear whatever the ring looks like
  area.west = area.south = std::numeric_limits<double>::infinity(), area.east = area.north = -area.west;
  std::vector<Edge> all;
  for (std::size_t i = 0, before = ring.size() - 1; i < ring.size(); before = i++) {
    all.push_back({ring[before][0], ring[before][1], ring[i][0], ring[i][1]});
    area.west = std::min(area.west, ring[i][0]), area.east = std::max(area.east, ring[i][0]);
    area.south = std::min(area.south, ring[i][1]), area.north = std::max(area.north, ring[i][1]);
  }
  area.strips = static_cast<std::uint32_t>(std::clamp((area.north - area.south) / strip_m, 1.0, 4096.0));
  std::vector<std::uint32_t> begin;
  for (;; area.strips /= 2) {
    area.strips_per_m = area.north > area.south ? area.strips / (area.north - area.south) : 0.0;
    begin.assign(area.strips + 1, 0);
    for (const Edge& edge : all) for_strips(area, edge, [&](std::uint32_t k) { ++begin[k + 1]; });
    for (std::uint32_t k = 0; k < area.strips; ++k) begin[k + 1] += begin[k];
    if (area.strips == 1 || begin.back() <= most_in_strips * all.size()) break;
  }
  const auto base = static_cast<std::uint32_t>(edges_.size());
  area.first_strip = static_cast<std::uint32_t>(strip_begin_.size());
  for (const std::uint32_t b : begin) strip_begin_.push_back(base + b);
  edges_.resize(edges_.size() + begin.back());
  for (const Edge& edge : all) for_strips(area, edge, [&](std::uint32_t k) { edges_[base + begin[k]++] = edge; });
}

bool JunctionIndex::contains(std::uint32_t junction, double x, double y) const {
  constexpr double rounding_m = 1e-6;  // of where an edge is crossed
  const Area& area = areas_[junction];
  if (!(x >= area.west - rounding_m && x <= area.east + rounding_m && y >= area.south && y <= area.north)) return false;
  const std::uint32_t* strip = &strip_begin_[area.first_strip + strip_of(area, y)];
  bool inside = false;
  for (std::uint32_t i = strip[0]; i < strip[1]; ++i) {
    const Edge& e = edges_[i];
    if ((e.y0 > y) == (e.y1 > y)) continue;
    if (x < e.x0 + (y - e.y0) / (e.y1 - e.y0) * (e.x1 - e.x0)) inside = !inside;
  }
  return inside;
}

JunctionOver JunctionIndex::over(std::uint32_t junction, double x, double y) const {
  const Area& area = areas_[junction];
  const double column = (x - area.x) * area.inverse_spacing, row = (y - area.y) * area.inverse_spacing;
  if (column >= 0.0 && row >= 0.0 && column < area.columns - 1 && row < area.rows - 1) {
    const int c = static_cast<int>(column), r = static_cast<int>(row);
    const std::uint32_t node =
        static_cast<std::uint32_t>(r) * static_cast<std::uint32_t>(area.columns) + static_cast<std::uint32_t>(c);
    if (const std::uint8_t inner = inner_[area.inner + node]; inner != unknown) {
      const JunctionHeight field = evaluate_nodes(z_.data() + area.z + node - area.columns - 1, area.columns,
                                                  column - c, row - r, area.inverse_spacing);
      if (inner == no_arm) return {junction, field};
      const JunctionArm* arms = arms_.data() + area.arms;
      const std::span<const JunctionArm> near =
          inner == several_arms ? std::span(arms, area.arm_count) : std::span(arms + (inner - first_arm), 1);
      return {junction, blend_arms(field, near, x, y)};
    }
  }
  if (!contains(junction, x, y)) return {};
  const JunctionHeight at = evaluate(JunctionField{area.x,
                                                   area.y,
                                                   area.spacing_m,
                                                   area.columns,
                                                   area.rows,
                                                   z_.data() + area.z,
                                                   {arms_.data() + area.arms, area.arm_count}},
                                     x, y);
  return std::isfinite(at.z) ? JunctionOver{junction, at} : JunctionOver{};
}

JunctionOver JunctionIndex::over(const Cell& cell, double x, double y, double z_hint) const {
  JunctionOver best;
  const auto distance = [&](double z) { return std::isnan(z_hint) ? -z : std::abs(z - z_hint); };
  for (const CellEntry& entry : cell.junctions()) {
    const JunctionOver one = over(entry.first, x, y);
    if (one.junction == no_index) continue;
    if (best.junction == no_index || distance(one.at.z) < distance(best.at.z)) best = one;
  }
  return best;
}

void JunctionIndex::fetch_first(const Cell& cell) const {
  for (const CellEntry& entry : cell.junctions()) {
    const char* area = reinterpret_cast<const char*>(&areas_[entry.first]);  // NOLINT
    __builtin_prefetch(area), __builtin_prefetch(area + 64);
  }
}

void JunctionIndex::fetch_second(const Cell& cell, double x, double y) const {
  for (const CellEntry& entry : cell.junctions()) {
    const Area& area = areas_[entry.first];
    const std::uint32_t strip = area.first_strip + strip_of(area, y);
    __builtin_prefetch(&edges_[std::min<std::size_t>(strip_begin_[strip], edges_.size() - 1)]);
    const double column = std::clamp((x - area.x) / area.spacing_m - 1.0, 0.0, std::max(area.columns - 1.0, 0.0));
    const double row = std::clamp((y - area.y) / area.spacing_m - 1.0, 0.0, std::max(area.rows - 1.0, 0.0));
    const double* z = z_.data() + area.z + static_cast<std::size_t>(row) * static_cast<std::size_t>(area.columns) +
                      static_cast<std::size_t>(column);
    for (int k = 0; k < 4; ++k) __builtin_prefetch(z + k * area.columns);
    for (std::uint32_t k = 0; k < std::min(area.arm_count, 4U); ++k) __builtin_prefetch(&arms_[area.arms + k]);
  }
}

}  // namespace roadquery
