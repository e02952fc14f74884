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

}  // namespace

JunctionIndex::JunctionIndex(const RoadMap& map) {
  if (std::none_of(map.junctions.begin(), map.junctions.end(), has_surface)) return;
  std::unordered_map<int, std::uint32_t> index;
  for (const Junction& junction : map.junctions) {
    if (has_surface(junction)) {
      check_bounds(junction);
      index.emplace(junction.id, static_cast<std::uint32_t>(areas_.size()));
      add(*junction.surface);
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
  cut_into_strips(surface.boundary, area);
  areas_.push_back(area);
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
  if (!contains(junction, x, y)) return {};
  const Area& area = areas_[junction];
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
