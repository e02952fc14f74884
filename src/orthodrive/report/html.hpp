// SPDX-License-Identifier: Apache-2.0
#pragma once
// What the pages that people look at share. All of it is well-formed XML too, so that a test can read it back.

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "orthodrive/geo/raster.hpp"

namespace orthodrive {

/// The style sheet of all pages.
extern const char* const html_style;

/// How pictures become bytes. Given by the caller: a report makes text, and encoders need a library for files.
struct PictureEncoders {
  std::function<std::vector<std::uint8_t>(const Raster<std::uint8_t>& rgb, int quality)> jpeg;
  std::function<std::vector<std::uint8_t>(const Raster<std::uint8_t>& image)> png;
};

[[nodiscard]] std::string base64(const std::vector<std::uint8_t>& bytes);
/// An encoded picture (type "jpeg" or "png") inside the page, with its caption.
[[nodiscard]] std::string html_figure(const std::vector<std::uint8_t>& picture, const std::string& type,
                                      const std::string& caption);
/// Cells are text; numbers stand to the right.
[[nodiscard]] std::string html_table(const std::vector<std::string>& head,
                                     const std::vector<std::vector<std::string>>& rows);

}  // namespace orthodrive
