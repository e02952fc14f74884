// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/scene/tiles/tile_texture.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace orthodrive::scene {
namespace {

constexpr std::uint8_t no_photo_grey = 128;
constexpr int bleed_px = 4;  // reach of trilinear filtering over the first mipmap levels

int texture_size_px(const Box2& square, double gsd_m, int max_px) {
  return std::clamp(static_cast<int>(std::floor(square.width() / gsd_m)), 1, max_px);
}

/// Pixels of one axis that share length with a texel, and how much.
struct Span {
  int first = 0;
  std::vector<float> weights;
};

std::vector<Span> spans(double first_px, double texel_px, int texels, int size_px) {
  std::vector<Span> result(static_cast<std::size_t>(texels));
  for (int i = 0; i < texels; ++i) {
    const double low = first_px + i * texel_px, high = low + texel_px;
    Span& span = result[static_cast<std::size_t>(i)];
    span.first = std::clamp(static_cast<int>(std::floor(low)), 0, size_px);
    for (int k = span.first; k < size_px && k < high; ++k)
      span.weights.push_back(
          static_cast<float>(std::max(0.0, std::min(high, k + 1.0) - std::max(low, static_cast<double>(k)))));
  }
  return result;
}

/// Gives texels without photo that touch one with photo the mean of their neighbours.
void bleed(Raster<std::uint8_t>& rgb, Raster<std::uint8_t>& known) {
  const Raster<std::uint8_t> before = known;
  for (int row = 0; row < rgb.height; ++row) {
    for (int col = 0; col < rgb.width; ++col) {
      if (before.at(col, row)) continue;
      std::array<int, 3> sum{};
      int count = 0;
      for (int k = 0; k < 9; ++k) {
        const int c = col + k % 3 - 1, r = row + k / 3 - 1;
        if (!rgb.inside(c, r) || !before.at(c, r)) continue;
        for (int channel = 0; channel < 3; ++channel) sum[static_cast<std::size_t>(channel)] += rgb.at(c, r, channel);
        ++count;
      }
      if (count == 0) continue;
      for (int channel = 0; channel < 3; ++channel)
        rgb.at(col, row, channel) =
            static_cast<std::uint8_t>((sum[static_cast<std::size_t>(channel)] + count / 2) / count);
      known.at(col, row) = 1;
    }
  }
}

}  // namespace

Raster<std::uint8_t> tile_texture(const Photo& photo, const Box2& square, int max_px) {
  const int size = texture_size_px(square, photo.frame.gsd_m, max_px);
  const Vec2 corner = photo.frame.pixel_from_world({square.min_x, square.max_y});
  const double texel_px = square.width() / photo.frame.gsd_m / size;
  const auto columns = spans(corner.x, texel_px, size, photo.frame.width);
  const auto rows = spans(corner.y, texel_px, size, photo.frame.height);

  Raster<std::uint8_t> rgb(size, size, 3, no_photo_grey), known(size, size);
  bool any = false;
  for (int row = 0; row < size; ++row) {
    const Span& sr = rows[static_cast<std::size_t>(row)];
    for (int col = 0; col < size; ++col) {
      const Span& sc = columns[static_cast<std::size_t>(col)];
      std::array<float, 3> sum{};
      float total = 0.0F;
      for (std::size_t j = 0; j < sr.weights.size(); ++j) {
        for (std::size_t i = 0; i < sc.weights.size(); ++i) {
          const int c = sc.first + static_cast<int>(i), r = sr.first + static_cast<int>(j);
          if (!photo.valid.at(c, r)) continue;
          const float w = sr.weights[j] * sc.weights[i];
          const std::uint8_t* pixel = &photo.rgb.data[photo.rgb.index(c, r)];
          for (std::size_t channel = 0; channel < 3; ++channel) sum[channel] += w * static_cast<float>(pixel[channel]);
          total += w;
        }
      }
      if (!(total > 0.0F)) continue;
      for (int channel = 0; channel < 3; ++channel)
        rgb.at(col, row, channel) =
            static_cast<std::uint8_t>(std::floor(sum[static_cast<std::size_t>(channel)] / total + 0.5F));
      known.at(col, row) = 1;
      any = true;
    }
  }
  if (!any) return {};
  for (int i = 0; i < bleed_px; ++i) bleed(rgb, known);
  return rgb;
}

Raster<std::uint8_t> tile_labels(const LabelMap& labels, const Box2& square, int max_px) {
  const int size = texture_size_px(square, labels.frame.gsd_m, max_px);
  const GridFrame texels{square.min_x, square.max_y, square.width() / size, size, size};
  Raster<std::uint8_t> result(size, size, 1, label_nodata);
  for (int row = 0; row < size; ++row) {
    for (int col = 0; col < size; ++col) {
      const Vec2 at = labels.frame.pixel_from_world(texels.center_of(col, row));
      const int c = static_cast<int>(std::floor(at.x)), r = static_cast<int>(std::floor(at.y));
      if (labels.labels.inside(c, r)) result.at(col, row) = labels.labels.at(c, r);
    }
  }
  return result;
}

}  // namespace orthodrive::scene
