#include "orthodrive/evaluate/line_index.hpp"

#include <algorithm>
#include <cmath>

namespace orthodrive::evaluate {
namespace {
constexpr double cell_m = 32.0;  // about twice the reach: a query looks into four cells

/// Calls visit(key) for the cells that the box touches.
template <typename F>
void for_cells(Vec2 a, Vec2 b, F&& visit) {
  const auto cell = [](double x) { return static_cast<std::int64_t>(std::floor(x / cell_m)); };
  for (std::int64_t row = cell(std::min(a.y, b.y)); row <= cell(std::max(a.y, b.y)); ++row)
    for (std::int64_t col = cell(std::min(a.x, b.x)); col <= cell(std::max(a.x, b.x)); ++col)
      visit((static_cast<std::uint64_t>(row) << 32) ^ (static_cast<std::uint64_t>(col) & 0xffffffffULL));
}
}  // namespace

LineIndex::LineIndex(const RoadNetwork& roads) : roads_(roads) {
  for (std::size_t path = 0; path < roads.paths.size(); ++path) {
    const std::vector<RoadNode>& nodes = roads.paths[path].nodes;
    for (std::size_t i = 0; i + 1 < nodes.size(); ++i)
      for_cells(nodes[i].p, nodes[i + 1].p, [&](std::uint64_t key) {
        cells_[key].push_back({static_cast<std::uint32_t>(path), static_cast<std::uint32_t>(i)});
      });
  }
}

std::optional<Across> LineIndex::find(const Query& query) const {
  const Vec2 left = left_normal(query.direction);
  const double min_cos = std::cos(query.max_angle_rad);
  std::optional<Across> nearest;
  for_cells(query.p - query.reach_m * left, query.p + query.reach_m * left, [&](std::uint64_t key) {
    const auto cell = cells_.find(key);
    if (cell == cells_.end()) return;
    for (const Segment& candidate : cell->second) {
      const RoadPath& path = roads_.paths[candidate.path];
      if (query.layer && path.layer != *query.layer) continue;
      const Vec2 a = path.nodes[candidate.segment].p, d = path.nodes[candidate.segment + 1].p - a;
      const double along = dot(d, query.direction), size = length(d);
      if (size == 0.0 || std::abs(along) < min_cos * size) continue;
      // p + t left = a + u d, by the component along the direction.
      const double u = dot(query.p - a, query.direction) / along;
      if (u < 0.0 || u > 1.0) continue;
      const double t = dot(a + u * d - query.p, left);
      if (std::abs(t) > query.reach_m) continue;
      // Ties (a segment in two cells, paths that share a node) go to the first path: no dependence on hash order.
      const bool closer =
          !nearest || std::abs(t) < std::abs(nearest->offset_m) ||
          (std::abs(t) == std::abs(nearest->offset_m) &&
           std::pair(candidate.path, candidate.segment) <
               std::pair(static_cast<std::uint32_t>(nearest->path), static_cast<std::uint32_t>(nearest->segment)));
      if (closer) nearest = Across{candidate.path, candidate.segment, u, t, along > 0.0};
    }
  });
  return nearest;
}

}  // namespace orthodrive::evaluate
