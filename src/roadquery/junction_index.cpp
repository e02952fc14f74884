#include "roadquery/junction_index.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <unordered_map>

namespace roadquery {
namespace {

constexpr double widest_junction_m = 5000.0;

void check_bounds(const Junction& junction) {
  double west = std::numeric_limits<double>::infinity(), south = west, east = -west, north = -west;
  bool are_places = true;
  for (const auto& [x, y] : junction.surface->boundary) {
    are_places = are_places && std::max(std::abs(x), std::abs(y)) <= 1e9 && !std::isnan(x + y);
    west = std::min(west, x), east = std::max(east, x);
    south = std::min(south, y), north = std::max(north, y);
  }
  if (!(are_places && east - west <= widest_junction_m && north - south <= widest_junction_m))
    throw std::runtime_error("junction " + std::to_string(junction.id) + " has a boundary wider than 5 km");
}

}  // namespace

JunctionIndex::JunctionIndex(const RoadMap& map) {
  if (std::none_of(map.junctions.begin(), map.junctions.end(), has_surface)) return;
  std::unordered_map<int, std::uint32_t> index;
  for (const Junction& junction : map.junctions) {
    if (has_surface(junction)) {
      check_bounds(junction);
      index.emplace(junction.id, static_cast<std::uint32_t>(boundaries_.size()));
    }
    boundaries_.emplace_back(has_surface(junction) ? std::span(junction.surface->boundary)
                                                   : std::span<const std::array<double, 2>>{});
  }
  roads_.resize(map.junctions.size());
  for (std::uint32_t r = 0; r < map.roads.size(); ++r)
    if (const auto found = index.find(map.roads[r].junction); found != index.end()) roads_[found->second].push_back(r);
}

JunctionOver JunctionIndex::over(const RoadMap& map, const Cell& cell, double x, double y, double z_hint) const {
  JunctionOver best;
  const auto distance = [&](double z) { return std::isnan(z_hint) ? -z : std::abs(z - z_hint); };
  for (const CellEntry& entry : cell.junctions()) {
    if (!boundaries_[entry.first].contains(x, y)) continue;
    const JunctionHeight at = evaluate(*map.junctions[entry.first].surface, x, y);
    if (!std::isfinite(at.z)) continue;
    if (best.junction == no_index || distance(at.z) < distance(best.at.z)) best = {entry.first, at};
  }
  return best;
}

}  // namespace roadquery
