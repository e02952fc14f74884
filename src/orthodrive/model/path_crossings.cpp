#include "orthodrive/model/path_crossings.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <tuple>
#include <utility>

namespace orthodrive {
namespace {

constexpr double cell_m = 50.0;  // a few segments a cell in a town

struct CellSegment {
  long column, row;
  std::size_t path, segment;
  friend auto operator<=>(const CellSegment&, const CellSegment&) = default;
};

/// Each segment once in every cell that its box touches, sorted by cell.
std::vector<CellSegment> segments_by_cell(const RoadNetwork& roads) {
  std::vector<CellSegment> cells;
  const auto cell_of = [](double v) { return static_cast<long>(std::floor(v / cell_m)); };
  for (std::size_t p = 0; p < roads.paths.size(); ++p) {
    const auto& nodes = roads.paths[p].nodes;
    for (std::size_t i = 0; i + 1 < nodes.size(); ++i) {
      const Vec2 a = nodes[i].p, b = nodes[i + 1].p;
      for (long row = cell_of(std::min(a.y, b.y)); row <= cell_of(std::max(a.y, b.y)); ++row)
        for (long column = cell_of(std::min(a.x, b.x)); column <= cell_of(std::max(a.x, b.x)); ++column)
          cells.push_back({column, row, p, i});
    }
  }
  std::sort(cells.begin(), cells.end());
  return cells;
}

bool share_node(const RoadNode& a0, const RoadNode& a1, const RoadNode& b0, const RoadNode& b1) {
  const auto is_end_of_b = [&](const RoadNode& a) {
    return a.osm_node > 0 && (a.osm_node == b0.osm_node || a.osm_node == b1.osm_node);
  };
  return is_end_of_b(a0) || is_end_of_b(a1);
}

/// Fractions along both segments; none for parallel segments and for those that do not reach each other.
std::optional<std::pair<double, double>> intersect(Vec2 a0, Vec2 a1, Vec2 b0, Vec2 b1) {
  const Vec2 a = a1 - a0, b = b1 - b0;
  const double det = cross(a, b);
  if (det == 0.0) return std::nullopt;
  const double fa = cross(b0 - a0, b) / det, fb = cross(b0 - a0, a) / det;
  // Half open, so that a crossing exactly at a node between two segments counts once.
  if (fa < 0.0 || fa >= 1.0 || fb < 0.0 || fb >= 1.0) return std::nullopt;
  return std::pair{fa, fb};
}

}  // namespace

std::vector<PathCrossing> find_crossings(const RoadNetwork& roads) {
  const std::vector<CellSegment> cells = segments_by_cell(roads);
  std::vector<PathCrossing> crossings;
  const auto key = [](const PathCrossing& c) { return std::tuple(c.path_a, c.segment_a, c.path_b, c.segment_b); };
  for (std::size_t begin = 0; begin < cells.size();) {
    std::size_t end = begin;
    while (end < cells.size() && cells[end].column == cells[begin].column && cells[end].row == cells[begin].row) ++end;
    for (std::size_t i = begin; i < end; ++i)
      for (std::size_t k = i + 1; k < end; ++k) {
        const CellSegment &a = cells[i], &b = cells[k];
        if (a.path == b.path && b.segment <= a.segment + 1) continue;  // neighbours meet, they do not cross
        const auto& na = roads.paths[a.path].nodes;
        const auto& nb = roads.paths[b.path].nodes;
        const RoadNode &a0 = na[a.segment], &a1 = na[a.segment + 1], &b0 = nb[b.segment], &b1 = nb[b.segment + 1];
        const auto fractions = intersect(a0.p, a1.p, b0.p, b1.p);
        if (!fractions || share_node(a0, a1, b0, b1)) continue;
        crossings.push_back({a.path, b.path, a.segment, b.segment, fractions->first, fractions->second,
                             a0.p + (a1.p - a0.p) * fractions->first});
      }
    begin = end;
  }
  std::sort(crossings.begin(), crossings.end(), [&](const auto& a, const auto& b) { return key(a) < key(b); });
  crossings.erase(std::unique(crossings.begin(), crossings.end(), [&](const auto& a, const auto& b) { return key(a) == key(b); }),
                  crossings.end());
  return crossings;
}

}  // namespace orthodrive
