// SPDX-License-Identifier: Apache-2.0
#pragma once
// What the bands of a photo are, whatever its format says of them: looked at, not believed. Internal to io.

#include <filesystem>
#include <string>
#include <vector>

#include "orthodrive/io/support/gdal_support.hpp"

namespace orthodrive::io {

/// Something about a photo that its format does not say, or says wrongly.
struct PhotoOddity {
  std::string code, message;
  Vec2 pixel;  ///< where on the photo
};

struct RgbPhoto {
  DatasetPtr view;  ///< null: the photo is as it should be
  std::vector<PhotoOddity> oddities;
};

/// A view of a photo with the bands red, green, blue (8 bit) and, if some pixels have no data, alpha:
/// - palettes and grey become colours, bands that are named red, green and blue are taken in that order, inks (cyan,
///   magenta, yellow, black) become colours;
/// - samples of more than 8 bit are scaled from the range that they fill;
/// - a band of transparency that holds values all over is none (NAIP has near infrared there).
/// The photo must outlive the view. Throws InputError for samples that are no colours.
[[nodiscard]] RgbPhoto rgb_bands(const std::filesystem::path& path, GDALDataset& photo);

/// The same, and black or white around the photo that no format declares (photo_collar.hpp) is no data.
[[nodiscard]] RgbPhoto rgb_photo(const std::filesystem::path& path, GDALDataset& photo);

}  // namespace orthodrive::io
