#include "orthodrive/geo/line_grid.hpp"

#include <algorithm>
#include <cmath>

namespace orthodrive {
namespace {

/// Calls visit(key) for the cells that the box touches.
template <typename Visit>
void for_cells(const Box2& box, double cell_m, Visit&& visit) {
  const auto cell = [cell_m](double x) { return static_cast<std::int64_t>(std::floor(x / cell_m)); };
  for (std::int64_t row = cell(box.min_y); row <= cell(box.max_y); ++row)
    for (std::int64_t col = cell(box.min_x); col <= cell(box.max_x); ++col)
      visit((static_cast<std::uint64_t>(row) << 32) ^ (static_cast<std::uint64_t>(col) & 0xffffffffULL));
}

}  // namespace

LineGrid::LineGrid(const std::vector<Polyline>& lines, double cell_m) : cell_m_(cell_m) {
  for (std::size_t l = 0; l < lines.size(); ++l)
    for (std::size_t i = 0; i + 1 < lines[l].size(); ++i)
      for_cells(bounds_of({lines[l][i], lines[l][i + 1]}), cell_m_, [&](std::uint64_t key) {
        cells_[key].push_back({static_cast<std::uint32_t>(l), static_cast<std::uint32_t>(i)});
      });
}

std::vector<LineGrid::Segment> LineGrid::near(Vec2 p, double reach_m) const {
  std::vector<Segment> segments;
  for_cells(Box2{p.x, p.y, p.x, p.y}.grown(reach_m), cell_m_, [&](std::uint64_t key) {
    if (const auto cell = cells_.find(key); cell != cells_.end())
      segments.insert(segments.end(), cell->second.begin(), cell->second.end());
  });
  std::sort(segments.begin(), segments.end());
  segments.erase(std::unique(segments.begin(), segments.end()), segments.end());
  return segments;
}

}  // namespace orthodrive
