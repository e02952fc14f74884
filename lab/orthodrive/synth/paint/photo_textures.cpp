// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/synth/paint/photo_textures.hpp"

#include <algorithm>
#include <cmath>

#include "orthodrive/core/noise.hpp"

namespace orthodrive::synth {
namespace {

constexpr std::array<const char*, texture_count> names{"ground",     "road",  "parking", "building",
                                                       "vegetation", "grass", "water"};
constexpr float usual = 128.0f;

std::int64_t wrapped(std::int64_t value, int size) { return ((value % size) + size) % size; }

/// Bilinear between pixel centres, round the tile.
float value_at(const Raster<std::uint8_t>& tile, double x, double y, int channel) {
  const double left = std::floor(x - 0.5), top = std::floor(y - 0.5);
  const auto u = static_cast<float>(x - 0.5 - left), v = static_cast<float>(y - 0.5 - top);
  const auto pixel = [&](double col, double row) {
    return static_cast<float>(tile.at(static_cast<int>(wrapped(static_cast<std::int64_t>(col), tile.width)),
                                      static_cast<int>(wrapped(static_cast<std::int64_t>(row), tile.height)), channel));
  };
  return (pixel(left, top) * (1.0f - u) + pixel(left + 1.0, top) * u) * (1.0f - v) +
         (pixel(left, top + 1.0) * (1.0f - u) + pixel(left + 1.0, top + 1.0) * u) * v;
}

/// `scale`: pixels of the tile a pixel of the result.
Raster<float> resampled(const Raster<std::uint8_t>& tile, double scale) {
  const int width = std::max(1, static_cast<int>(std::lround(tile.width / scale))),
            height = std::max(1, static_cast<int>(std::lround(tile.height / scale)));
  const double step_x = static_cast<double>(tile.width) / width, step_y = static_cast<double>(tile.height) / height;
  const int samples = std::max(1, static_cast<int>(std::ceil(scale)));  // of a pixel, in each direction
  Raster<float> result(width, height, 3);
  for (int row = 0; row < height; ++row)
    for (int col = 0; col < width; ++col)
      for (int channel = 0; channel < 3; ++channel) {
        float sum = 0.0f;
        for (int j = 0; j < samples; ++j)
          for (int i = 0; i < samples; ++i)
            sum += value_at(tile, (col + (i + 0.5) / samples) * step_x, (row + (j + 0.5) / samples) * step_y, channel);
        result.at(col, row, channel) = sum / (usual * static_cast<float>(samples * samples));
      }
  return result;
}

}  // namespace

TextureSampler::TextureSampler(const PhotoTextures& textures, double gsd_m, std::uint32_t seed) {
  for (std::size_t i = 0; i < texture_count; ++i) {
    const auto tile = textures.tiles.find(names[i]);
    if (tile == textures.tiles.end()) continue;
    const auto number = static_cast<std::int32_t>(i);
    Tile& own = tiles_[i];
    own.factors = resampled(tile->second, gsd_m / textures.gsd_m);
    own.first_col = static_cast<std::int64_t>(unit_hash(number, 1, seed) * static_cast<float>(own.factors.width));
    own.first_row = static_cast<std::int64_t>(unit_hash(number, 2, seed) * static_cast<float>(own.factors.height));
  }
}

std::array<float, 3> TextureSampler::at(Texture texture, std::int64_t col, std::int64_t row) const {
  const Tile& tile = tiles_[static_cast<std::size_t>(texture)];
  if (tile.factors.data.empty()) return {1.0f, 1.0f, 1.0f};
  const int x = static_cast<int>(wrapped(col + tile.first_col, tile.factors.width)),
            y = static_cast<int>(wrapped(row + tile.first_row, tile.factors.height));
  return {tile.factors.at(x, y, 0), tile.factors.at(x, y, 1), tile.factors.at(x, y, 2)};
}

}  // namespace orthodrive::synth
