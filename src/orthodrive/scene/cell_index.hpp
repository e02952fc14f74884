#pragma once
// Which of many small boxes lie at a point.

#include <cstdint>
#include <span>
#include <vector>

#include "orthodrive/geo/vec.hpp"

namespace orthodrive::scene {

/// A uniform grid over all boxes; each cell lists the boxes that touch it. Grow the boxes by the search radius before.
class CellIndex {
 public:
  CellIndex() = default;
  CellIndex(std::span<const Box2> boxes, double cell_m);
  /// Indices of the boxes that may contain p, ascending: a superset of those that do.
  [[nodiscard]] std::span<const std::uint32_t> at(Vec2 p) const;

 private:
  [[nodiscard]] int column(double x) const { return static_cast<int>((x - bounds_.min_x) / cell_m_); }
  [[nodiscard]] int row(double y) const { return static_cast<int>((y - bounds_.min_y) / cell_m_); }
  [[nodiscard]] std::size_t cell(int column, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(column);
  }
  Box2 bounds_;
  double cell_m_ = 1.0;
  int columns_ = 0, rows_ = 0;
  std::vector<std::uint32_t> first_, items_;  // items of cell c: items_[first_[c]] to items_[first_[c + 1]]
};

}  // namespace orthodrive::scene
