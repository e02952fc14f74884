// SPDX-License-Identifier: Apache-2.0
#pragma once
// Pictures as map services send them, and mosaics of them.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "orthodrive/geo/crs.hpp"
#include "orthodrive/geo/pixel_box.hpp"
#include "orthodrive/geo/raster.hpp"

namespace orthodrive::io {

/// "jpg", "png", "webp" by the first bytes; empty for anything else.
[[nodiscard]] std::string image_format(std::string_view bytes);

/// Red, green, blue, alpha (255 where the picture has none) of a JPEG, PNG or WebP of up to 4096 pixels a side. Other
/// formats are not tried: some name files of their own. Throws InputError for what does not decode to its end.
[[nodiscard]] Raster<std::uint8_t> decode_tile(std::string_view bytes);

/// The pixels of a CRS without any of them: corner and edges of a pixel (which need not be square) in its units.
struct TileMosaic {
  Crs crs;
  double left = 0.0, top = 0.0, resolution = 1.0;
  int tile_width = 256, tile_height = 256;
  int columns = 0, rows = 0;  ///< of tiles
};
/// Writes a cloud-optimised GeoTIFF (JPEG with a mask) of tiles asked row by row; what has none is invalid, not black.
/// Memory does not grow with the mosaic. Written aside first.
void write_tile_mosaic(const std::filesystem::path& path, const TileMosaic& mosaic,
                       const std::function<std::optional<Raster<std::uint8_t>>(int column, int row)>& tile_at,
                       const std::function<void(double)>& progress = {});

}  // namespace orthodrive::io
