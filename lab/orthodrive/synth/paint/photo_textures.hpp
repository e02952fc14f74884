// SPDX-License-Identifier: Apache-2.0
#pragma once
// The small structure of real photos on synthetic ones. `tools/paint quilt` makes the tiles out of painted photos:
// Efros and Freeman, Image quilting for texture synthesis and transfer, 2001.

#include <array>
#include <cstdint>
#include <map>
#include <string>

#include "orthodrive/geo/raster.hpp"

namespace orthodrive {

/// A square tile a class (names of the default class table), 3 channels, 128: as bright as its surroundings. Tiles go
/// on at their edges. Classes without a tile stay as they are painted.
struct PhotoTextures {
  double gsd_m = 0.0;
  std::map<std::string, Raster<std::uint8_t>> tiles;
};

namespace synth {

/// The classes that are told apart where a pixel is painted.
enum class Texture : std::uint8_t { ground, road, parking, building, vegetation, grass, water };
constexpr std::size_t texture_count = 7;

/// Tiles at the scale of a site's photo.
class TextureSampler {
 public:
  /// `seed` moves the tiles, each by its own way.
  TextureSampler(const PhotoTextures& textures, double gsd_m, std::uint32_t seed);
  /// Factors of the three channels at a pixel of the site; 1 without a tile.
  [[nodiscard]] std::array<float, 3> at(Texture texture, std::int64_t col, std::int64_t row) const;

 private:
  struct Tile {
    Raster<float> factors;
    std::int64_t first_col = 0, first_row = 0;
  };
  std::array<Tile, texture_count> tiles_;
};

}  // namespace synth
}  // namespace orthodrive
