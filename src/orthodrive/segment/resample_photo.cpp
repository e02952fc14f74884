#include "orthodrive/segment/resample_photo.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "orthodrive/core/parallel.hpp"

namespace orthodrive {
namespace {

constexpr double average_from_ratio = 1.25;  // below it an area average would only blur unevenly

/// Source pixels and weights of one target pixel along one axis.
struct Taps {
  int first = 0;
  std::vector<float> weights;
};

/// `start` and `ratio`: source coordinate of the target pixel's near edge and the target pixel's size, in source
/// pixels.
Taps make_taps(double start, double ratio) {
  Taps taps;
  if (ratio > average_from_ratio) {
    taps.first = static_cast<int>(std::floor(start + 1e-9));
    const int end = static_cast<int>(std::ceil(start + ratio - 1e-9));
    for (int i = taps.first; i < end; ++i) {
      taps.weights.push_back(static_cast<float>(std::min<double>(i + 1, start + ratio) - std::max<double>(i, start)));
    }
  } else {
    const double center = start + 0.5 * ratio - 0.5;
    taps.first = static_cast<int>(std::floor(center));
    const auto t = static_cast<float>(center - taps.first);
    taps.weights = {1.0F - t, t};
  }
  return taps;
}

std::vector<Taps> make_axis(int count, double start, double ratio) {
  std::vector<Taps> axis;
  axis.reserve(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) axis.push_back(make_taps(start + i * ratio, ratio));
  return axis;
}

}  // namespace

Photo resample_photo(const Photo& photo, double gsd_m, int threads) {
  const bool same_scale = std::abs(photo.frame.gsd_m - gsd_m) < 1e-6 * gsd_m;
  Photo out{photo.crs, same_scale ? photo.frame : covering_grid(photo.frame.bounds(), gsd_m), {}, {}};
  const GridFrame& frame = out.frame;
  out.rgb = Raster<std::uint8_t>(frame.width, frame.height, 3, no_photo_value);
  out.valid = Raster<std::uint8_t>(frame.width, frame.height, 1, 0);
  const double ratio = same_scale ? 1.0 : gsd_m / photo.frame.gsd_m;
  const Vec2 start = photo.frame.pixel_from_world({frame.west_m, frame.north_m});
  const std::vector<Taps> columns = make_axis(frame.width, start.x, ratio),
                          rows = make_axis(frame.height, start.y, ratio);
  parallel_for(static_cast<std::size_t>(frame.height), threads, [&](std::size_t index) {
    const int row = static_cast<int>(index);
    const Taps& vertical = rows[index];
    for (int col = 0; col < frame.width; ++col) {
      const Taps& horizontal = columns[static_cast<std::size_t>(col)];
      std::array<float, 3> sum{};
      float weight = 0.0F, total = 0.0F;
      for (std::size_t j = 0; j < vertical.weights.size(); ++j) {
        const int source_row = vertical.first + static_cast<int>(j);
        for (std::size_t i = 0; i < horizontal.weights.size(); ++i) {
          const int source_col = horizontal.first + static_cast<int>(i);
          const float w = vertical.weights[j] * horizontal.weights[i];
          total += w;
          if (!photo.valid.inside(source_col, source_row) || !photo.valid.at(source_col, source_row)) continue;
          weight += w;
          for (int c = 0; c < 3; ++c) sum[static_cast<std::size_t>(c)] += w * photo.rgb.at(source_col, source_row, c);
        }
      }
      if (weight < 0.5F * total) continue;
      out.valid.at(col, row) = 1;
      for (int c = 0; c < 3; ++c) {
        out.rgb.at(col, row, c) = static_cast<std::uint8_t>(std::lround(sum[static_cast<std::size_t>(c)] / weight));
      }
    }
  });
  return out;
}

}  // namespace orthodrive
