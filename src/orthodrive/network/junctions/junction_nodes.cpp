// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/network/junctions/junction_nodes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace orthodrive::network {
namespace {

std::size_t node_of(const FieldGrid& grid, int column, int row) {
  return static_cast<std::size_t>(row) * static_cast<std::size_t>(grid.columns) + static_cast<std::size_t>(column);
}

/// Marks the nodes about a cell that a bicubic takes.
void mark_about(const FieldGrid& grid, int column, int row, std::vector<char>& nodes) {
  for (int r = std::max(row - 1, 0); r <= std::min(row + 2, grid.rows - 1); ++r)
    for (int c = std::max(column - 1, 0); c <= std::min(column + 2, grid.columns - 1); ++c)
      nodes[node_of(grid, c, r)] = 1;
}

}  // namespace

std::vector<char> nodes_inside(const FieldGrid& grid, const Ring& boundary) {
  std::vector<char> inside(grid.size(), 0);
  std::vector<std::vector<double>> crossings(static_cast<std::size_t>(grid.rows));
  for (std::size_t i = 0, before = boundary.size() - 1; i < boundary.size(); before = i++) {
    const Vec2 a = boundary[before], b = boundary[i];
    if (a.y == b.y) continue;
    const auto row_after = [&](double y) {  // the first row above y
      return static_cast<int>(std::floor((y - grid.origin.y) / grid.spacing_m)) + 1;
    };
    const int first = std::max(row_after(std::min(a.y, b.y)), 0),
              last = std::min(row_after(std::max(a.y, b.y)), grid.rows);
    for (int r = first; r < last; ++r) {
      const double y = grid.origin.y + r * grid.spacing_m;
      crossings[static_cast<std::size_t>(r)].push_back(a.x + (y - a.y) / (b.y - a.y) * (b.x - a.x));
    }
  }
  for (int r = 0; r < grid.rows; ++r) {
    std::vector<double>& xs = crossings[static_cast<std::size_t>(r)];
    std::sort(xs.begin(), xs.end());
    for (std::size_t k = 0; k + 1 < xs.size(); k += 2) {
      const auto column_at = [&](double x) {
        return static_cast<int>(std::ceil((x - grid.origin.x) / grid.spacing_m));
      };
      for (int c = std::max(column_at(xs[k]), 0); c < std::min(column_at(xs[k + 1]), grid.columns); ++c)
        inside[node_of(grid, c, r)] = 1;
    }
  }
  return inside;
}

std::vector<char> nodes_for(const FieldGrid& grid, const Ring& boundary) {
  std::vector<char> nodes(grid.size(), 0);
  const std::vector<char> inside = nodes_inside(grid, boundary);
  for (int r = 0; r < grid.rows; ++r)
    for (int c = 0; c < grid.columns; ++c)
      if (inside[node_of(grid, c, r)] != 0)  // corner of four cells
        for (const auto& [column, row] : {std::pair{c - 1, r - 1}, {c, r - 1}, {c - 1, r}, {c, r}})
          mark_about(grid, column, row, nodes);
  const double step_m = 0.25 * grid.spacing_m;
  for (std::size_t i = 0; i < boundary.size(); ++i) {  // cells that it enters without a corner of them inside
    const Vec2 a = boundary[i], b = boundary[(i + 1) % boundary.size()];
    const int steps = std::max(1, static_cast<int>(std::ceil(distance(a, b) / step_m)));
    for (int k = 0; k < steps; ++k) {
      const Vec2 p = (a + (b - a) * (static_cast<double>(k) / steps) - grid.origin) * (1.0 / grid.spacing_m);
      mark_about(grid, static_cast<int>(std::floor(p.x)), static_cast<int>(std::floor(p.y)), nodes);
    }
  }
  return nodes;
}

std::vector<char> grown(const FieldGrid& grid, std::vector<char> nodes, int steps) {
  for (int step = 0; step < steps; ++step) {
    const std::vector<char> before = nodes;
    for (int r = 0; r < grid.rows; ++r)
      for (int c = 0; c < grid.columns; ++c) {
        if (before[node_of(grid, c, r)] == 0) continue;
        for (int y = std::max(r - 1, 0); y <= std::min(r + 1, grid.rows - 1); ++y)
          for (int x = std::max(c - 1, 0); x <= std::min(c + 1, grid.columns - 1); ++x) nodes[node_of(grid, x, y)] = 1;
      }
  }
  return nodes;
}

void extend(const FieldGrid& grid, std::vector<char> nodes, std::vector<double>& z) {
  constexpr double beyond_m = 4.0;
  for (int step = 0; step < static_cast<int>(beyond_m / grid.spacing_m); ++step) {
    const std::vector<char> known = nodes;
    const auto is_known = [&](int c, int r) {
      return c >= 0 && r >= 0 && c < grid.columns && r < grid.rows && known[node_of(grid, c, r)] != 0;
    };
    for (int r = 0; r < grid.rows; ++r)
      for (int c = 0; c < grid.columns; ++c) {
        if (is_known(c, r)) continue;
        double sum = 0.0, count = 0.0;
        for (const auto& [x, y] : {std::pair{-1, 0}, {1, 0}, {0, -1}, {0, 1}, {-1, -1}, {-1, 1}, {1, -1}, {1, 1}})
          if (is_known(c + x, r + y) && is_known(c + 2 * x, r + 2 * y))
            sum += 2.0 * z[node_of(grid, c + x, r + y)] - z[node_of(grid, c + 2 * x, r + 2 * y)], count += 1.0;
        if (count == 0.0) continue;
        z[node_of(grid, c, r)] = sum / count, nodes[node_of(grid, c, r)] = 1;
      }
  }
}

}  // namespace orthodrive::network
