// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/scene/ground/terrain_windows.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "orthodrive/core/error.hpp"
#include "orthodrive/model/rasters/sample_height.hpp"

namespace orthodrive::scene {
namespace {

constexpr int coarse_levels = 6, coarse_px = 1 << coarse_levels;
constexpr int read_px = 16 * coarse_px;  // a side of what is read at a time
constexpr float no_height = std::numeric_limits<float>::quiet_NaN();

bool has_holes(const Raster<float>& heights) {
  return std::ranges::any_of(heights.data, [](float v) { return std::isnan(v); });
}

/// Means of two by two pixels, of those that have a height.
Raster<float> halved(const Raster<float>& heights) {
  Raster<float> half((heights.width + 1) / 2, (heights.height + 1) / 2, 1, no_height);
  for (int row = 0; row < half.height; ++row) {
    for (int col = 0; col < half.width; ++col) {
      double sum = 0.0;
      int count = 0;
      for (int k = 0; k < 4; ++k) {
        const int c = 2 * col + k % 2, r = 2 * row + k / 2;
        if (heights.inside(c, r) && !std::isnan(heights.at(c, r)))
          sum += static_cast<double>(heights.at(c, r)), ++count;
      }
      if (count > 0) half.at(col, row) = static_cast<float>(sum / count);
    }
  }
  return half;
}

void fill_from(Raster<float> half, Raster<float>& heights) {
  const GridFrame frame{0.0, 0.0, 2.0, half.width, half.height};
  const HeightGrid coarse{{}, frame, std::move(half), {}};
  for (int row = 0; row < heights.height; ++row)
    for (int col = 0; col < heights.width; ++col)
      if (std::isnan(heights.at(col, row)))
        heights.at(col, row) = static_cast<float>(sample_bilinear(coarse, {col + 0.5, -row - 0.5}));
}

/// As fill_holes(), but the means after `levels` halvings are given.
void fill_below(int levels, const Raster<float>& top, Raster<float>& heights) {
  if (levels == 0) {
    heights = top;
    return;
  }
  if (!has_holes(heights)) return;
  Raster<float> half = halved(heights);
  fill_below(levels - 1, top, half);
  fill_from(std::move(half), heights);
}

/// Adds up heights by squares of the coarse raster.
struct Sums {
  Raster<double> sum;
  Raster<int> count;
  void add(const PixelBox& box, const Raster<float>& heights) {
    for (int row = 0; row < heights.height; ++row) {
      for (int col = 0; col < heights.width; ++col) {
        const float z = heights.at(col, row);
        if (std::isnan(z)) continue;
        const int c = (static_cast<int>(box.col) + col) / coarse_px, r = (static_cast<int>(box.row) + row) / coarse_px;
        sum.at(c, r) += static_cast<double>(z), ++count.at(c, r);
      }
    }
  }
};

/// Holes outside the area (terrain models end somewhere) are nobody's business.
struct Holes {
  std::size_t count = 0;
  Vec2 sum;
  void add(const GridFrame& frame, const Raster<float>& heights, const Outline& area) {
    for (int row = 0; row < heights.height; ++row) {
      for (int col = 0; col < heights.width; ++col) {
        const Vec2 p = frame.center_of(col, row);
        if (std::isnan(heights.at(col, row)) && area.contains(p)) ++count, sum = sum + p;
      }
    }
  }
};

}  // namespace

void fill_holes(Raster<float>& heights) {
  const auto holes = std::ranges::count_if(heights.data, [](float v) { return std::isnan(v); });
  if (holes == 0 || static_cast<std::size_t>(holes) == heights.data.size()) return;
  Raster<float> half = halved(heights);
  fill_holes(half);
  fill_from(std::move(half), heights);
}

TerrainWindows::TerrainWindows(HeightSource source, const Outline& area, Findings& findings)
    : source_(std::move(source)) {
  const GridFrame& frame = source_.frame;
  const int width = (frame.width + coarse_px - 1) / coarse_px, height = (frame.height + coarse_px - 1) / coarse_px;
  Sums sums{Raster<double>(width, height), Raster<int>(width, height)};
  Holes holes;
  for (int row = 0; row < frame.height; row += read_px) {
    for (int col = 0; col < frame.width; col += read_px) {
      const PixelBox box{col, row, std::min(read_px, frame.width - col), std::min(read_px, frame.height - row)};
      const Raster<float> heights = source_.read(box);
      sums.add(box, heights);
      if (has_holes(heights)) holes.add(part_of(frame, box), heights, area);
    }
  }
  coarse_ = Raster<float>(width, height, 1, no_height);
  for (std::size_t i = 0; i < coarse_.data.size(); ++i)
    if (sums.count.data[i] > 0) coarse_.data[i] = static_cast<float>(sums.sum.data[i] / sums.count.data[i]);
  fill_holes(coarse_);
  if (coarse_.empty() || std::isnan(coarse_.data.front()))
    throw InputError("terrain model", "has no height anywhere, give a DTM that covers the area");
  if (holes.count == 0) return;
  const double n = static_cast<double>(holes.count);
  findings.push_back({Severity::warning, "scene.terrain_hole",
                      fmt::format("{:.0f} m2 of the terrain model have no height and were filled from around",
                                  n * frame.gsd_m * frame.gsd_m),
                      holes.sum.x / n, holes.sum.y / n});
}

HeightGrid TerrainWindows::window(const Box2& box) const {
  const GridFrame& frame = source_.frame;
  const Box2 whole = frame.bounds();
  const Box2 inside{std::clamp(box.min_x, whole.min_x, whole.max_x), std::clamp(box.min_y, whole.min_y, whole.max_y),
                    std::clamp(box.max_x, whole.min_x, whole.max_x), std::clamp(box.max_y, whole.min_y, whole.max_y)};
  // Two pixels more: what is between two centres needs both.
  const PixelBox wanted = intersection(pixels_in(frame, inside.grown(2.0 * frame.gsd_m)), pixels_of(frame));
  HeightGrid grid{source_.crs, part_of(frame, wanted), source_.read(wanted), {}};
  if (!has_holes(grid.height_m)) return grid;
  // Squares count from the terrain's corner. A pixel depends on squares beside its own, of each size.
  constexpr int margin = 2 * coarse_px;
  const auto down = [](std::int64_t v) { return std::max<std::int64_t>(0, v - margin) / coarse_px * coarse_px; };
  PixelBox around{down(wanted.col), down(wanted.row), 0, 0};
  const auto size_from = [](std::int64_t from, std::int64_t end, int limit) {
    return static_cast<int>(std::min<std::int64_t>(limit, (end + margin + coarse_px - 1) / coarse_px * coarse_px) -
                            from);
  };
  around.width = size_from(around.col, wanted.end_col(), frame.width);
  around.height = size_from(around.row, wanted.end_row(), frame.height);
  Raster<float> heights = source_.read(around);
  Raster<float> top((around.width + coarse_px - 1) / coarse_px, (around.height + coarse_px - 1) / coarse_px);
  for (int row = 0; row < top.height; ++row)
    for (int col = 0; col < top.width; ++col)
      top.at(col, row) =
          coarse_.at(static_cast<int>(around.col / coarse_px) + col, static_cast<int>(around.row / coarse_px) + row);
  fill_below(coarse_levels, top, heights);
  for (int row = 0; row < wanted.height; ++row)
    for (int col = 0; col < wanted.width; ++col)
      grid.height_m.at(col, row) =
          heights.at(static_cast<int>(wanted.col - around.col) + col, static_cast<int>(wanted.row - around.row) + row);
  return grid;
}

double TerrainWindows::height_m(Vec2 p) const {
  const HeightGrid grid = window({p.x, p.y, p.x, p.y});
  const Box2 b = grid.frame.bounds();
  return sample_bilinear(grid, {std::clamp(p.x, b.min_x, b.max_x), std::clamp(p.y, b.min_y, b.max_y)});
}

}  // namespace orthodrive::scene
