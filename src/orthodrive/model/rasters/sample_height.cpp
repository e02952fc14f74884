// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/model/rasters/sample_height.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>

namespace orthodrive {
namespace {
constexpr double nan_height = std::numeric_limits<double>::quiet_NaN();

/// Keys 1981, eq. 4 with a = -1/2.
std::array<double, 4> keys_weights(double t) {
  const double t2 = t * t, t3 = t2 * t;
  return {0.5 * (-t3 + 2.0 * t2 - t), 0.5 * (3.0 * t3 - 5.0 * t2 + 2.0), 0.5 * (-3.0 * t3 + 4.0 * t2 + t),
          0.5 * (t3 - t2)};
}
}  // namespace

double sample_bilinear(const HeightGrid& grid, Vec2 p) {
  const Vec2 q = grid.frame.pixel_from_world(p);
  const double col = q.x - 0.5, row = q.y - 0.5;  // in units of pixel centres
  const int w = grid.frame.width, h = grid.frame.height;
  if (!(col >= -1.0 && row >= -1.0 && col <= w && row <= h)) return nan_height;
  const double c = std::clamp(col, 0.0, w - 1.0), r = std::clamp(row, 0.0, h - 1.0);
  const int c0 = std::min(static_cast<int>(c), std::max(0, w - 2)),
            r0 = std::min(static_cast<int>(r), std::max(0, h - 2));
  const int c1 = std::min(c0 + 1, w - 1), r1 = std::min(r0 + 1, h - 1);
  const double u = c - c0, v = r - r0;
  double sum = 0.0;
  const auto add = [&](int cc, int rr, double weight) {
    if (weight != 0.0) sum += weight * static_cast<double>(grid.height_m.at(cc, rr));
  };
  add(c0, r0, (1 - u) * (1 - v));
  add(c1, r0, u * (1 - v));
  add(c0, r1, (1 - u) * v);
  add(c1, r1, u * v);
  return sum;
}

double sample_cubic(const HeightGrid& grid, Vec2 p) {
  const Vec2 q = grid.frame.pixel_from_world(p);
  const double col = q.x - 0.5, row = q.y - 0.5;
  const int c0 = static_cast<int>(std::floor(col)), r0 = static_cast<int>(std::floor(row));
  if (c0 < 1 || r0 < 1 || c0 + 2 >= grid.frame.width || r0 + 2 >= grid.frame.height) return sample_bilinear(grid, p);
  const auto wx = keys_weights(col - c0), wy = keys_weights(row - r0);
  double sum = 0.0;
  for (int j = 0; j < 4; ++j)
    for (int i = 0; i < 4; ++i) sum += wx[i] * wy[j] * static_cast<double>(grid.height_m.at(c0 - 1 + i, r0 - 1 + j));
  return std::isnan(sum) ? sample_bilinear(grid, p) : sum;
}

double sample_height(const HeightGrid& grid, Vec2 p, HeightSampling sampling) {
  return sampling == HeightSampling::cubic ? sample_cubic(grid, p) : sample_bilinear(grid, p);
}

HeightSource merged_source(const std::vector<HeightGrid>& best_first, const Box2& box) {
  assert(!best_first.empty());
  if (best_first.size() == 1) return source_of(best_first.front());
  double gsd_m = best_first.front().frame.gsd_m;
  for (const HeightGrid& grid : best_first) gsd_m = std::min(gsd_m, grid.frame.gsd_m);
  const GridFrame frame = covering_grid(box, gsd_m);
  return {best_first.front().crs, frame, [&best_first, frame](const PixelBox& pixels) {
            Raster<float> merged(pixels.width, pixels.height, 1, std::numeric_limits<float>::quiet_NaN());
            for (int row = 0; row < merged.height; ++row)
              for (int col = 0; col < merged.width; ++col) {
                float& height = merged.at(col, row);
                const Vec2 p = frame.center_of(static_cast<int>(pixels.col) + col, static_cast<int>(pixels.row) + row);
                for (const HeightGrid& grid : best_first) {
                  if (!std::isnan(height)) break;
                  height = static_cast<float>(sample_cubic(grid, p));
                }
              }
            return merged;
          }};
}

}  // namespace orthodrive
