#include "orthodrive/scene/cell_index.hpp"

#include <algorithm>
#include <numeric>

namespace orthodrive::scene {

CellIndex::CellIndex(std::span<const Box2> boxes, double cell_m) : cell_m_(cell_m) {
  if (boxes.empty()) return;
  bounds_ = boxes[0];
  for (const Box2& b : boxes) {
    bounds_ = {std::min(bounds_.min_x, b.min_x), std::min(bounds_.min_y, b.min_y), std::max(bounds_.max_x, b.max_x),
               std::max(bounds_.max_y, b.max_y)};
  }
  columns_ = column(bounds_.max_x) + 1, rows_ = row(bounds_.max_y) + 1;
  const auto for_each_cell = [&](const Box2& b, const auto& visit) {
    for (int r = row(b.min_y); r <= row(b.max_y); ++r)
      for (int c = column(b.min_x); c <= column(b.max_x); ++c) visit(cell(c, r));
  };
  first_.assign(cell(0, rows_) + 1, 0);
  for (const Box2& b : boxes) for_each_cell(b, [&](std::size_t c) { ++first_[c + 1]; });
  std::partial_sum(first_.begin(), first_.end(), first_.begin());
  items_.resize(first_.back());
  std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
  for (std::size_t i = 0; i < boxes.size(); ++i)
    for_each_cell(boxes[i], [&](std::size_t c) { items_[next[c]++] = static_cast<std::uint32_t>(i); });
}

std::span<const std::uint32_t> CellIndex::at(Vec2 p) const {
  if (items_.empty() || !bounds_.contains(p)) return {};
  const std::size_t c = cell(column(p.x), row(p.y));
  return std::span(items_).subspan(first_[c], first_[c + 1] - first_[c]);
}

}  // namespace orthodrive::scene
