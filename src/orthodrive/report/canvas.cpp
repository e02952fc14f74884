// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/report/canvas.hpp"

#include <algorithm>
#include <cmath>

namespace orthodrive {
namespace {
constexpr Color no_photo{225, 225, 225};

GridFrame picture_frame(const Box2& box, double source_gsd_m, int max_px) {
  // Down to a quarter of the source's pixel: a close-up shows the pixels as squares.
  const double gsd = std::max(std::max(box.width(), box.height()) / max_px, source_gsd_m / 4.0);
  return {box.min_x, box.max_y, gsd, std::max(1, static_cast<int>(std::lround(box.width() / gsd))),
          std::max(1, static_cast<int>(std::lround(box.height() / gsd)))};
}

/// color(col, row, rgb) gives the sum of what lies in the source pixel and whether there is anything.
template <typename Pick>
Canvas resampled(const GridFrame& source, const Box2& box, int max_px, const Pick& pick) {
  Canvas canvas;
  canvas.frame = picture_frame(box, source.gsd_m, max_px);
  canvas.rgb = Raster<std::uint8_t>(canvas.frame.width, canvas.frame.height, 3);
  const int taps =
      std::clamp(static_cast<int>(canvas.frame.gsd_m / source.gsd_m), 1, 4);  // box filter of taps x taps samples
  for (int row = 0; row < canvas.frame.height; ++row)
    for (int col = 0; col < canvas.frame.width; ++col) {
      int sum[3] = {0, 0, 0}, count = 0;
      for (int j = 0; j < taps; ++j)
        for (int i = 0; i < taps; ++i) {
          const Vec2 q =
              source.pixel_from_world(canvas.frame.world_from_pixel(col + (i + 0.5) / taps, row + (j + 0.5) / taps));
          const int c = static_cast<int>(std::floor(q.x)), r = static_cast<int>(std::floor(q.y));
          Color color;
          if (c < 0 || r < 0 || c >= source.width || r >= source.height || !pick(c, r, color)) continue;
          for (int k = 0; k < 3; ++k) sum[k] += color[static_cast<std::size_t>(k)];
          ++count;
        }
      for (int k = 0; k < 3; ++k)
        canvas.rgb.at(col, row, k) =
            count ? static_cast<std::uint8_t>(sum[k] / count) : no_photo[static_cast<std::size_t>(k)];
    }
  return canvas;
}

void mix(Canvas& canvas, int col, int row, Color color, double alpha) {
  for (int k = 0; k < 3; ++k) {
    std::uint8_t& value = canvas.rgb.at(col, row, k);
    value = static_cast<std::uint8_t>(std::lround(value + alpha * (color[static_cast<std::size_t>(k)] - value)));
  }
}
}  // namespace

double grey_at(const Photo* photo, Vec2 p) {
  constexpr double without_photo = 190.0;
  if (!photo) return without_photo;
  const Vec2 q = photo->frame.pixel_from_world(p);
  const int col = static_cast<int>(std::floor(q.x)), row = static_cast<int>(std::floor(q.y));
  if (!photo->valid.inside(col, row) || !photo->valid.at(col, row)) return without_photo;
  return 0.299 * photo->rgb.at(col, row, 0) + 0.587 * photo->rgb.at(col, row, 1) + 0.114 * photo->rgb.at(col, row, 2);
}

Canvas canvas_of(const Photo& photo, const Box2& box, int max_px) {
  return resampled(photo.frame, box, max_px, [&](int col, int row, Color& color) {
    if (photo.valid.at(col, row) == 0) return false;
    color = {photo.rgb.at(col, row, 0), photo.rgb.at(col, row, 1), photo.rgb.at(col, row, 2)};
    return true;
  });
}

Canvas canvas_of(const LabelMap& labels, const Box2& box, int max_px) {
  return resampled(labels.frame, box, max_px, [&](int col, int row, Color& color) {
    const std::uint8_t label = labels.labels.at(col, row);
    if (label >= labels.classes.classes.size()) return false;
    color = labels.classes.classes[label].color;
    return true;
  });
}

void fill(Canvas& canvas, const Polygon& polygon, Color color, double alpha) {
  rasterize(polygon, canvas.frame, [&](int row, int begin, int end) {
    for (int col = begin; col < end; ++col) mix(canvas, col, row, color, alpha);
  });
}

void stroke(Canvas& canvas, std::span<const Vec2> line, double width_px, Color color, double alpha) {
  const double reach = 0.5 * width_px + 0.5;
  for (std::size_t i = 0; i + 1 < line.size(); ++i) {
    const Vec2 a = canvas.frame.pixel_from_world(line[i]), b = canvas.frame.pixel_from_world(line[i + 1]);
    const int c0 = std::max(0, static_cast<int>(std::floor(std::min(a.x, b.x) - reach)));
    const int c1 = std::min(canvas.frame.width - 1, static_cast<int>(std::ceil(std::max(a.x, b.x) + reach)));
    const int r0 = std::max(0, static_cast<int>(std::floor(std::min(a.y, b.y) - reach)));
    const int r1 = std::min(canvas.frame.height - 1, static_cast<int>(std::ceil(std::max(a.y, b.y) + reach)));
    const Vec2 d = b - a;
    const double n2 = dot(d, d);
    for (int row = r0; row <= r1; ++row)
      for (int col = c0; col <= c1; ++col) {
        const Vec2 p{col + 0.5, row + 0.5};
        const double t = n2 > 0.0 ? dot(p - a, d) / n2 : 0.0;
        if (t > 1.0 && i + 2 < line.size()) continue;  // the next segment paints its own start
        const double coverage = reach - distance(p, a + d * std::clamp(t, 0.0, 1.0));
        if (coverage > 0.0) mix(canvas, col, row, color, alpha * std::min(1.0, coverage));
      }
  }
}

Color viridis(double t) {
  // Nine anchors of matplotlib's viridis (CC0).
  static constexpr std::array<Color, 9> anchors{{{68, 1, 84},
                                                 {71, 44, 122},
                                                 {59, 81, 139},
                                                 {44, 113, 142},
                                                 {33, 144, 141},
                                                 {39, 173, 129},
                                                 {92, 200, 99},
                                                 {170, 220, 50},
                                                 {253, 231, 37}}};
  const double x = std::clamp(t, 0.0, 1.0) * 8.0;
  const std::size_t i = std::min<std::size_t>(7, static_cast<std::size_t>(x));
  Color color;
  for (std::size_t k = 0; k < 3; ++k)
    color[k] = static_cast<std::uint8_t>(
        std::lround(anchors[i][k] + (x - static_cast<double>(i)) * (anchors[i + 1][k] - anchors[i][k])));
  return color;
}

}  // namespace orthodrive
