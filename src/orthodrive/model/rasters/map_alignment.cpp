// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/model/rasters/map_alignment.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>

#include "orthodrive/geo/simplify.hpp"

namespace orthodrive {
namespace {

constexpr double vector_scale = 4.0, width_scale = 8.0;

std::uint8_t byte_of(double value) { return static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0, 255.0))); }

/// The pixels of one axis of a box whose centres lie within reach of a segment's ends.
struct Cells {
  int first = 0, last = -1;
};
Cells cells_near(double a, double b, std::int64_t box_first, int box_size) {
  const double low = std::min(a, b) - map_reach_px - 0.5 - static_cast<double>(box_first),
               high = std::max(a, b) + map_reach_px - 0.5 - static_cast<double>(box_first);
  if (high < 0.0 || low > box_size - 1.0) return {};
  return {static_cast<int>(std::ceil(std::max(low, 0.0))),
          static_cast<int>(std::floor(std::min(high, box_size - 1.0)))};
}

/// Of these columns those within reach of the segment's endless line, in the row whose centre lies at `y` from `a`.
Cells cols_near_line(const Cells& cols, Vec2 a, Vec2 along, double y, std::int64_t box_first) {
  const double slope = std::abs(along.y);
  if (slope * (cols.last - cols.first) < map_reach_px) return cols;  // level: all of them, or nearly so
  const double middle = a.x - 0.5 - static_cast<double>(box_first) + along.x * y / along.y,
               reach = map_reach_px * length(along) / slope + 1.0;
  return {static_cast<int>(std::max<double>(cols.first, std::floor(middle - reach))),
          static_cast<int>(std::min<double>(cols.last, std::ceil(middle + reach)))};
}

struct Segment {
  Vec2 a, along;
  double per_square = 0.0;  ///< 1 / |along|^2; 0: it has no length
  std::int32_t line = 0, index = 0;

  /// How far along it its point nearest to a place lies, 0 to 1; the place counts from `a`.
  [[nodiscard]] double t(double x, double y) const {
    return std::clamp((x * along.x + y * along.y) * per_square, 0.0, 1.0);
  }
};

/// Pixels from `col` on, `count` of them, in the row whose centre lies at `y` from the segment's beginning. `square`:
/// of the distance to what is nearest so far, `segment`: which it is.
void take_nearer(const Segment& s, std::int64_t which, double y, std::int64_t col, int count, double* __restrict square,
                 std::int64_t* __restrict segment) {
  const double first = static_cast<double>(col) + 0.5;
  for (int i = 0; i < count; ++i) {
    const double x = (first + i) - s.a.x, t = s.t(x, y);
    const double dx = s.along.x * t - x, dy = s.along.y * t - y, d = dx * dx + dy * dy;
    segment[i] = d < square[i] ? which : segment[i];
    square[i] = d < square[i] ? d : square[i];
  }
}

std::vector<Segment> segments_of(std::span<const RoadLine> lines) {
  std::vector<Segment> segments;
  for (std::size_t line = 0; line < lines.size(); ++line) {
    const Polyline& points = lines[line].points;
    for (std::size_t i = 0; i + 1 < points.size(); ++i) {
      const Vec2 along = points[i + 1] - points[i];
      const double square = dot(along, along);
      segments.push_back({points[i], along, square > 0.0 ? 1.0 / square : 0.0, static_cast<std::int32_t>(line),
                          static_cast<std::int32_t>(i)});
    }
  }
  return segments;
}

Raster<NearestLine> nearest_segments(std::span<const Segment> segments, const PixelBox& box) {
  Raster<double> square(box.width, box.height, 1, map_reach_px * map_reach_px);
  Raster<std::int64_t> nearest_segment(box.width, box.height, 1, -1);
  for (std::size_t i = 0; i < segments.size(); ++i) {
    const Segment& s = segments[i];
    const Vec2 b = s.a + s.along;
    const Cells rows = cells_near(s.a.y, b.y, box.row, box.height), cols = cells_near(s.a.x, b.x, box.col, box.width);
    for (int row = rows.first; row <= rows.last; ++row) {
      const double y = static_cast<double>(box.row + row) + 0.5 - s.a.y;
      const Cells seen = cols_near_line(cols, s.a, s.along, y, box.col);
      if (seen.first <= seen.last)
        take_nearer(s, static_cast<std::int64_t>(i), y, box.col + seen.first, seen.last - seen.first + 1,
                    &square.at(seen.first, row), &nearest_segment.at(seen.first, row));
    }
  }
  Raster<NearestLine> nearest(box.width, box.height);
  for (int row = 0; row < box.height; ++row)
    for (int col = 0; col < box.width; ++col) {
      const std::int64_t i = nearest_segment.at(col, row);
      if (i < 0) continue;
      const Segment& s = segments[static_cast<std::size_t>(i)];
      const Vec2 from_a{static_cast<double>(box.col + col) + 0.5 - s.a.x,
                        static_cast<double>(box.row + row) + 0.5 - s.a.y};
      const double t = s.t(from_a.x, from_a.y);
      nearest.at(col, row) = {s.along * t - from_a, s.line, s.index, t};
    }
  return nearest;
}

}  // namespace

Raster<NearestLine> nearest_lines(std::span<const RoadLine> lines, const PixelBox& box) {
  return nearest_segments(segments_of(lines), box);
}

Raster<std::uint8_t> map_raster(std::span<const RoadLine> lines, const Raster<NearestLine>& nearest) {
  Raster<std::uint8_t> raster(nearest.width, nearest.height, map_raster_channels);
  for (std::size_t i = 0; i < nearest.data.size(); ++i) {
    const NearestLine& n = nearest.data[i];
    std::uint8_t* bytes = &raster.data[map_raster_channels * i];
    bytes[0] = bytes[1] = 128;
    if (n.line < 0) continue;
    bytes[0] = byte_of(128.0 + vector_scale * n.to_line.x);
    bytes[1] = byte_of(128.0 + vector_scale * n.to_line.y);
    bytes[2] = byte_of(255.0 * (1.0 - std::sqrt(dot(n.to_line, n.to_line)) / map_reach_px));
    bytes[3] = byte_of(width_scale * lines[static_cast<std::size_t>(n.line)].half_width);
  }
  return raster;
}

PlaceAlignment place_alignment(const float* channels, Vec2 from_center_px, double gsd_m) {
  const double unit_m = alignment_unit_px * gsd_m;
  const auto rounded = [](double value) { return std::round(1000.0 * value) / 1000.0; };
  const auto sigma = [&](float log_scale) {
    return std::max(0.001,
                    rounded(std::numbers::sqrt2 * unit_m *
                            std::exp(std::clamp(static_cast<double>(log_scale), least_log_scale, most_log_scale))));
  };
  return {{rounded(unit_m * channels[0] - gsd_m * from_center_px.x),
           -rounded(unit_m * channels[1] - gsd_m * from_center_px.y)},
          sigma(channels[2]),
          std::max(0.0, rounded(unit_m * channels[3])),
          sigma(channels[4])};
}

std::vector<double> places_along(double length_m) {
  constexpr double step_m = 2.0;
  std::vector<double> places;
  for (int i = 0; step_m * i < length_m; ++i) places.push_back(step_m * i);
  places.push_back(length_m);
  return places;
}

MapLines::MapLines(std::vector<RoadLine> lines_m) : lines_(std::move(lines_m)) {
  // A path has a node every two metres, and each segment costs the pixels around it.
  constexpr double tolerance_m = 0.01;
  std::erase_if(lines_, [](const RoadLine& line) { return line.points.size() < 2; });
  for (RoadLine& line : lines_) {
    const std::vector<bool> stays = simplify(line.points, tolerance_m);
    std::size_t i = 0;
    std::erase_if(line.points, [&](Vec2) { return !stays[i++]; });
    boxes_.push_back(bounds_of(line.points));
  }
}

std::vector<RoadLine> MapLines::near(const GridFrame& frame, const PixelBox& box, double margin_px) const {
  const Vec2 north_west = frame.world_from_pixel(static_cast<double>(box.col), static_cast<double>(box.row)),
             south_east =
                 frame.world_from_pixel(static_cast<double>(box.end_col()), static_cast<double>(box.end_row()));
  const Box2 seen = Box2{north_west.x, south_east.y, south_east.x, north_west.y}.grown(margin_px * frame.gsd_m);
  std::vector<RoadLine> lines;
  for (std::size_t i = 0; i < lines_.size(); ++i) {
    if (!boxes_[i].overlaps(seen)) continue;
    RoadLine line{{}, lines_[i].half_width / frame.gsd_m};
    for (const Vec2 p : lines_[i].points) line.points.push_back(frame.pixel_from_world(p));
    lines.push_back(std::move(line));
  }
  return lines;
}

Raster<std::uint8_t> MapLines::read(const GridFrame& frame, const PixelBox& box) const {
  // Part by part: what is kept of a pixel on the way is ten times what it becomes, and stays in the processor's cache.
  constexpr int part_px = 64;
  const std::vector<RoadLine> lines = near(frame, box, map_reach_px + 1.0);
  const std::vector<Segment> segments = segments_of(lines);
  Raster<std::uint8_t> raster(box.width, box.height, map_raster_channels);
  for (int top = 0; top < box.height; top += part_px)
    for (int left = 0; left < box.width; left += part_px) {
      const PixelBox part{box.col + left, box.row + top, std::min(part_px, box.width - left),
                          std::min(part_px, box.height - top)};
      const Raster<std::uint8_t> bytes = map_raster(lines, nearest_segments(segments, part));
      for (int row = 0; row < part.height; ++row)
        std::memcpy(&raster.at(left, top + row), &bytes.at(0, row),
                    static_cast<std::size_t>(map_raster_channels) * static_cast<std::size_t>(part.width));
    }
  return raster;
}

}  // namespace orthodrive
