// SPDX-License-Identifier: Apache-2.0
#pragma once
// Black or white around a photo that no format declares: turned or cut photos have it, and JPEG frays it. Internal to
// io.

#include <optional>
#include <string>

#include "orthodrive/geo/raster.hpp"
#include "orthodrive/io/support/gdal_support.hpp"

namespace orthodrive::io {

/// Where the collar is, in cells of some pixels.
struct PhotoCollar {
  static constexpr std::uint8_t black = 1, white = 2;
  int cell_px = 1;
  Raster<std::uint8_t> zone;  ///< bits of the colours that mean no data, in the collar and two cells beyond it
  double share = 0.0;         ///< of the photo's pixels
  Vec2 middle_px;             ///< of the largest part of it
  bool has_black = false, has_white = false;

  /// Whether a pixel is part of it.
  [[nodiscard]] bool covers(int col, int row, std::uint8_t r, std::uint8_t g, std::uint8_t b) const;
  /// "black", "white" or "black and white".
  [[nodiscard]] std::string colors() const;
};

/// Looks for it in a photo of the bands red, green and blue (8 bit): a flat part of one extreme colour that goes along
/// 2 % of the border and covers 0.1 % of the photo. Shadows and snow are not flat, or do not reach so far. Nothing
/// where the photo is of one colour altogether. Reads the border, and the photo itself only where that is suspicious.
[[nodiscard]] std::optional<PhotoCollar> find_collar(GDALDataset& rgb);

/// The photo with an alpha band that is 0 in the collar and where the photo itself has no data.
[[nodiscard]] DatasetPtr without_collar(DatasetPtr own, GDALDataset& rgb, PhotoCollar collar);

}  // namespace orthodrive::io
