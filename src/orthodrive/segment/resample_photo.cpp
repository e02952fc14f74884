// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/segment/resample_photo.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <utility>
#include <vector>

#include "orthodrive/core/parallel.hpp"

namespace orthodrive {
namespace {

constexpr double average_from_ratio = 1.25;  // below it an area average would only blur unevenly

/// Source pixels and weights of one target pixel along one axis.
struct Taps {
  std::int64_t first = 0;
  std::vector<float> weights;
  [[nodiscard]] std::int64_t end() const { return first + static_cast<std::int64_t>(weights.size()); }
};

/// `start` and `ratio`: source coordinate of the target pixel's near edge and the target pixel's size, in source
/// pixels.
Taps make_taps(double start, double ratio) {
  Taps taps;
  if (ratio > average_from_ratio) {
    taps.first = static_cast<std::int64_t>(std::floor(start + 1e-9));
    const auto end = static_cast<std::int64_t>(std::ceil(start + ratio - 1e-9));
    for (std::int64_t i = taps.first; i < end; ++i) {
      const auto near = static_cast<double>(i);
      taps.weights.push_back(static_cast<float>(std::min(near + 1.0, start + ratio) - std::max(near, start)));
    }
  } else {
    const double center = start + 0.5 * ratio - 0.5;
    taps.first = static_cast<std::int64_t>(std::floor(center));
    const auto t = static_cast<float>(center - static_cast<double>(taps.first));
    taps.weights = {1.0F - t, t};
  }
  return taps;
}

/// The taps of `count` target pixels from `first` on. Ascending, so the first and the last span the source pixels.
std::vector<Taps> make_axis(std::int64_t first, int count, double start, double ratio) {
  std::vector<Taps> axis;
  axis.reserve(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) axis.push_back(make_taps(start + static_cast<double>(first + i) * ratio, ratio));
  return axis;
}

float sum_of(const std::vector<float>& weights) {
  float sum = 0.0F;
  for (const float w : weights) sum += w;
  return sum;
}

/// Adds w times a row of bytes.
void add_row(std::vector<float>& sum, const std::uint8_t* row, float w) {
  float* s = sum.data();
  for (std::size_t i = 0, n = sum.size(); i < n; ++i) s[i] += w * static_cast<float>(row[i]);
}

bool has_photo(const std::uint8_t* valid, std::size_t count) { return std::memchr(valid, 1, count) != nullptr; }

void clear_invalid(PhotoWindow& window, std::uint8_t value) {
  if (!std::memchr(window.valid.data.data(), 0, window.valid.data.size())) return;
  for (std::size_t i = 0; i < window.valid.data.size(); ++i)
    if (!window.valid.data[i]) std::memset(&window.rgb.data[3 * i], value, 3);
}

/// First down the columns, then along the row: the sums of a pixel have the same order in every window.
class Resampler {
 public:
  Resampler(PhotoSource photo, const GridFrame& frame) : photo_(std::move(photo)), frame_(frame) {
    same_scale_ = frame_ == photo_.frame;
    ratio_ = frame_.gsd_m / photo_.frame.gsd_m;
    start_ = photo_.frame.pixel_from_world({frame_.west_m, frame_.north_m});
  }
  [[nodiscard]] const GridFrame& frame() const { return frame_; }

  [[nodiscard]] PhotoWindow read(const PixelBox& box) const {
    if (same_scale_) {
      PhotoWindow window = photo_.read(box);
      clear_invalid(window, no_photo_value);
      return window;
    }
    PhotoWindow out{Raster<std::uint8_t>(box.width, box.height, 3, no_photo_value),
                    Raster<std::uint8_t>(box.width, box.height)};
    const PixelBox inside = intersection(box, pixels_of(frame_));
    if (inside.empty()) return out;
    const std::vector<Taps> columns = make_axis(inside.col, inside.width, start_.x, ratio_),
                            rows = make_axis(inside.row, inside.height, start_.y, ratio_);
    const PixelBox seen{columns.front().first, rows.front().first,
                        static_cast<int>(columns.back().end() - columns.front().first),
                        static_cast<int>(rows.back().end() - rows.front().first)};
    PhotoWindow source = photo_.read(seen);
    clear_invalid(source, 0);  // adds nothing
    std::vector<float> rgb_sum(3 * static_cast<std::size_t>(seen.width)),
        valid_sum(static_cast<std::size_t>(seen.width));
    for (int i = 0; i < inside.height; ++i) {
      const Taps& vertical = rows[static_cast<std::size_t>(i)];
      std::fill(rgb_sum.begin(), rgb_sum.end(), 0.0F);
      std::fill(valid_sum.begin(), valid_sum.end(), 0.0F);
      bool any = false;
      for (std::size_t j = 0; j < vertical.weights.size(); ++j) {
        const int row = static_cast<int>(vertical.first - seen.row) + static_cast<int>(j);
        if (!has_photo(&source.valid.at(0, row), valid_sum.size())) continue;
        any = true;
        add_row(rgb_sum, &source.rgb.at(0, row), vertical.weights[j]);
        add_row(valid_sum, &source.valid.at(0, row), vertical.weights[j]);
      }
      if (any) {
        const int left = static_cast<int>(inside.col - box.col), top = static_cast<int>(inside.row - box.row);
        finish_row(columns, seen.col, sum_of(vertical.weights), rgb_sum, valid_sum, &out.rgb.at(left, top + i),
                   &out.valid.at(left, top + i));
      }
    }
    return out;
  }

 private:
  static void finish_row(const std::vector<Taps>& columns, std::int64_t first_col, float vertical_total,
                         const std::vector<float>& rgb_sum, const std::vector<float>& valid_sum, std::uint8_t* rgb,
                         std::uint8_t* valid) {
    for (std::size_t col = 0; col < columns.size(); ++col) {
      const Taps& horizontal = columns[col];
      const auto offset = static_cast<std::size_t>(horizontal.first - first_col);
      std::array<float, 3> sum{};
      float weight = 0.0F, total = 0.0F;
      for (std::size_t i = 0; i < horizontal.weights.size(); ++i) {
        const float w = horizontal.weights[i];
        const float* p = &rgb_sum[3 * (offset + i)];
        sum[0] += w * p[0], sum[1] += w * p[1], sum[2] += w * p[2];
        weight += w * valid_sum[offset + i];
        total += w;
      }
      if (weight < 0.5F * total * vertical_total) continue;
      valid[col] = 1;
      for (std::size_t c = 0; c < 3; ++c)
        rgb[3 * col + c] = static_cast<std::uint8_t>(std::min(255.0F, sum[c] / weight + 0.5F));
    }
  }

  PhotoSource photo_;
  GridFrame frame_;
  bool same_scale_ = false;
  double ratio_ = 1.0;  ///< target pixel in source pixels
  Vec2 start_;          ///< corner of the target frame in source pixels
};

}  // namespace

GridFrame resampled_frame(const GridFrame& frame, double gsd_m) {
  const bool same_scale = std::abs(frame.gsd_m - gsd_m) < 1e-6 * gsd_m;
  return same_scale ? frame : covering_grid(frame.bounds(), gsd_m);
}

PhotoSource resample_source(PhotoSource photo, double gsd_m) {
  const GridFrame frame = resampled_frame(photo.frame, gsd_m);
  return resample_source(std::move(photo), frame);
}

PhotoSource resample_source(PhotoSource photo, const GridFrame& frame) {
  const Crs crs = photo.crs;
  const Resampler resampler(std::move(photo), frame);
  return {crs, resampler.frame(), [resampler](const PixelBox& box) { return resampler.read(box); }};
}

Photo resample_photo(const Photo& photo, double gsd_m, int threads) {
  const PhotoSource source = resample_source(source_of(photo), gsd_m);
  const GridFrame& frame = source.frame;
  Photo out{photo.crs, frame, Raster<std::uint8_t>(frame.width, frame.height, 3),
            Raster<std::uint8_t>(frame.width, frame.height)};
  constexpr int band_rows = 64;
  parallel_for(static_cast<std::size_t>((frame.height + band_rows - 1) / band_rows), threads, [&](std::size_t index) {
    const int row = band_rows * static_cast<int>(index);
    const PhotoWindow band = source.read({0, row, frame.width, std::min(band_rows, frame.height - row)});
    std::copy(band.rgb.data.begin(), band.rgb.data.end(), &out.rgb.at(0, row));
    std::copy(band.valid.data.begin(), band.valid.data.end(), &out.valid.at(0, row));
  });
  return out;
}

}  // namespace orthodrive
