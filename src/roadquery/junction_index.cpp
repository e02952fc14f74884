#include "roadquery/junction_index.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

namespace roadquery {
namespace {

constexpr double junction_cell_m = 16.0;
constexpr double widest_junction_m = 5000.0;

std::int32_t cell_of(double v) { return static_cast<std::int32_t>(std::floor(v / junction_cell_m)); }

struct Bounds {
  double west = std::numeric_limits<double>::infinity(), south = west, east = -west, north = -west;
};
Bounds bounds_of(const Junction& junction) {
  Bounds b;
  for (const auto& [x, y] : junction.surface->boundary) {
    b.west = std::min(b.west, x), b.east = std::max(b.east, x);
    b.south = std::min(b.south, y), b.north = std::max(b.north, y);
  }
  if (!(b.east - b.west <= widest_junction_m && b.north - b.south <= widest_junction_m &&
        std::max(std::abs(b.west), std::abs(b.south)) <= 1e9))
    throw std::runtime_error("junction " + std::to_string(junction.id) + " has a boundary wider than 5 km");
  return b;
}

}  // namespace

JunctionIndex::JunctionIndex(const RoadMap& map, BakedRoads& roads) : roads_(map.junctions.size()) {
  for (std::uint32_t i = 0; i < map.junctions.size(); ++i) {
    const Junction& junction = map.junctions[i];
    if (!junction.surface || junction.surface->boundary.size() < 3) continue;
    const Bounds b = bounds_of(junction);
    for (std::int32_t row = cell_of(b.south); row <= cell_of(b.north); ++row)
      for (std::int32_t column = cell_of(b.west); column <= cell_of(b.east); ++column)
        cells_.push_back({row, column, i});
  }
  std::sort(cells_.begin(), cells_.end());
  if (cells_.empty()) return;
  for (const Junction& junction : map.junctions) {
    std::vector<std::uint32_t>& own = roads_[static_cast<std::size_t>(&junction - map.junctions.data())];
    for (std::uint32_t r = 0; r < map.roads.size(); ++r)
      if (junction.surface && map.roads[r].junction == junction.id) own.push_back(r);
  }
  for (Station& q : roads.stations) {
    const double reach = q.half_m * 1.5 + roads.stretches[q.lanes].reach_m;
    bool is_near = false;
    for (std::int32_t row = cell_of(q.y - reach); row <= cell_of(q.y + reach); ++row) {
      for (std::int32_t column = cell_of(q.x - reach); column <= cell_of(q.x + reach); ++column) {
        const auto at = first_at(row, column);
        is_near = is_near || (at != cells_.end() && at->row == row && at->column == column);
      }
    }
    if (is_near) q.free_right = 1, q.free_left = -1;
  }
}

std::vector<JunctionIndex::CellJunction>::const_iterator JunctionIndex::first_at(std::int32_t row,
                                                                                 std::int32_t column) const {
  return std::lower_bound(cells_.begin(), cells_.end(), CellJunction{row, column, 0});
}

JunctionOver JunctionIndex::over(const RoadMap& map, double x, double y, double z_hint) const {
  JunctionOver best;
  if (!(std::abs(x) < 1e9 && std::abs(y) < 1e9)) return best;
  const std::int32_t row = cell_of(y), column = cell_of(x);
  const auto distance = [&](double z) { return std::isnan(z_hint) ? -z : std::abs(z - z_hint); };
  for (auto c = first_at(row, column); c != cells_.end() && c->row == row && c->column == column; ++c) {
    const JunctionSurface& surface = *map.junctions[c->junction].surface;
    if (!contains(surface, x, y)) continue;
    const JunctionHeight at = evaluate(surface, x, y);
    if (!std::isfinite(at.z)) continue;
    if (best.junction == no_index || distance(at.z) < distance(best.at.z)) best = {c->junction, at};
  }
  return best;
}

}  // namespace roadquery
