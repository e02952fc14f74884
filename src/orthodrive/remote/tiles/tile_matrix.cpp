// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/remote/tiles/tile_matrix.hpp"

#include <algorithm>
#include <cmath>

namespace orthodrive::remote {
namespace {
constexpr double quad_resolution = 2.0 * web_mercator_half / 256.0;  // of level 0, m

struct Range {
  std::int64_t begin = 0, end = 0;  ///< empty where equal
  [[nodiscard]] double count() const { return static_cast<double>(std::max<std::int64_t>(0, end - begin)); }
};

/// Of tiles of that size from `first`, those that [low, high] has a part of, clipped to `count` tiles.
Range span_of(double low, double high, double tile, std::int64_t count) {
  const auto limited = [&](double value) {
    return static_cast<std::int64_t>(std::clamp(value, 0.0, static_cast<double>(count)));
  };
  if (!(high > low)) return {};
  return {limited(std::floor(low / tile)), limited(std::ceil(high / tile))};
}

struct Ranges {
  Range columns, rows;
};
Ranges ranges_of(const TileMatrix& m, const Box2& box) {
  return {span_of(box.min_x - m.left, box.max_x - m.left, m.resolution * m.tile_width, m.columns),
          span_of(m.top - box.max_y, m.top - box.min_y, m.resolution * m.tile_height, m.rows)};
}

/// Clips the segment to the box (Liang and Barsky): whether a part is left.
bool crosses(const Box2& box, Vec2 a, Vec2 b) {
  double from = 0.0, to = 1.0;
  const Vec2 d = b - a;
  const auto clip = [&](double direction, double distance) {  // direction * t <= distance
    if (direction == 0.0) return distance >= 0.0;
    const double t = distance / direction;
    if (direction < 0.0)
      from = std::max(from, t);
    else
      to = std::min(to, t);
    return from <= to;
  };
  return clip(-d.x, a.x - box.min_x) && clip(d.x, box.max_x - a.x) && clip(-d.y, a.y - box.min_y) &&
         clip(d.y, box.max_y - a.y);
}

bool touches(const Polygon& area, const Box2& box) {
  if (contains(area, {0.5 * (box.min_x + box.max_x), 0.5 * (box.min_y + box.max_y)})) return true;
  for (std::size_t i = 0; i < area.outer.size(); ++i)
    if (crosses(box, area.outer[i], area.outer[(i + 1) % area.outer.size()])) return true;
  return false;
}
}  // namespace

TileMatrixSet web_mercator_quad(int min_zoom, int max_zoom) {
  TileMatrixSet set{"WebMercatorQuad", {"EPSG:3857"}, {}};
  for (int zoom = min_zoom; zoom <= max_zoom; ++zoom)
    set.matrices.push_back({std::to_string(zoom), std::ldexp(quad_resolution, -zoom), -web_mercator_half,
                            web_mercator_half, 256, 256, std::int64_t{1} << zoom, std::int64_t{1} << zoom});
  return set;
}

std::optional<int> quad_zoom(const TileMatrix& m) {
  if (m.tile_width != 256 || m.tile_height != 256 || !(m.resolution > 0.0)) return std::nullopt;
  const double zoom = std::log2(quad_resolution / m.resolution), rounded = std::round(zoom);
  // Services round the denominator of the scale and the corner. No other grid in use comes so near to the quad.
  if (!(rounded >= 0.0 && rounded <= 30.0) || std::abs(zoom - rounded) > 1e-5) return std::nullopt;
  const double tolerance = std::max(0.5 * m.resolution, 0.05);
  if (std::abs(m.left + web_mercator_half) > tolerance || std::abs(m.top - web_mercator_half) > tolerance)
    return std::nullopt;
  return static_cast<int>(rounded);
}

Box2 bounds_of_tile(const TileMatrix& m, TileAddress tile) {
  const double width = m.resolution * m.tile_width, height = m.resolution * m.tile_height;
  const double west = m.left + static_cast<double>(tile.column) * width;
  const double north = m.top - static_cast<double>(tile.row) * height;
  return {west, north - height, west + width, north};
}

double most_tiles_over(const TileMatrix& matrix, const Polygon& area) {
  const Ranges ranges = ranges_of(matrix, bounds_of(area.outer));
  return ranges.columns.count() * ranges.rows.count();
}

std::optional<std::vector<TileAddress>> tiles_over(const TileMatrix& matrix, const Polygon& area, std::size_t most) {
  // A slanted area fills half of its box at least; thin ones (a coast, a road) are cut into several sites.
  if (most_tiles_over(matrix, area) > 8.0 * static_cast<double>(most)) return std::nullopt;
  const Ranges ranges = ranges_of(matrix, bounds_of(area.outer));
  std::vector<TileAddress> tiles;
  for (std::int64_t row = ranges.rows.begin; row < ranges.rows.end; ++row)
    for (std::int64_t column = ranges.columns.begin; column < ranges.columns.end; ++column) {
      if (!touches(area, bounds_of_tile(matrix, {column, row}))) continue;
      if (tiles.size() == most) return std::nullopt;
      tiles.push_back({column, row});
    }
  return tiles;
}

std::size_t fine_enough(const TileMatrixSet& set, double resolution) {
  for (std::size_t i = 0; i < set.matrices.size(); ++i)
    if (set.matrices[i].resolution <= resolution * 1.001) return i;
  return set.matrices.size() - 1;
}

}  // namespace orthodrive::remote
