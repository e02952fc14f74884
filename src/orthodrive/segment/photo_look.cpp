// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/segment/photo_look.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace orthodrive {

PhotoLook& PhotoLook::operator+=(const PhotoLook& other) {
  pixels += other.pixels;
  luminance += other.luminance;
  chroma += other.chroma;
  white += other.white;
  red += other.red;
  return *this;
}

PhotoLook look_of(const Raster<std::uint8_t>& rgb, const Raster<std::uint8_t>& valid, int left, int top, int width,
                  int height) {
  PhotoLook look;
  for (int row = top; row < top + height; ++row)
    for (int col = left; col < left + width; ++col) {
      if (!valid.at(col, row)) continue;
      const std::uint8_t* pixel = &rgb.at(col, row);
      const int r = pixel[0], g = pixel[1], b = pixel[2];
      const int luminance = (r + 2 * g + b) / 4, chroma = std::max({r, g, b}) - std::min({r, g, b});
      ++look.pixels;
      look.luminance += luminance;
      look.chroma += chroma;
      look.white += luminance > 190 && chroma < 30;
      look.red += 3 * r > 4 * std::max(g, b);
    }
  return look;
}

Findings judge_look(const PhotoLook& look, Vec2 place) {
  constexpr double least_chroma = 4.0, least_luminance = 40.0, most_white = 0.5, most_red = 0.4;
  Findings findings;
  if (look.pixels == 0) return findings;
  const auto of_all = [&](std::int64_t value) { return static_cast<double>(value) / static_cast<double>(look.pixels); };
  const auto warn = [&](const char* code, const std::string& what) {
    findings.push_back({Severity::warning, code,
                        what + "; the network learned from colour photos of summer and spring days: look at the labels "
                               "before you trust them, or take another photo",
                        place.x, place.y});
  };
  if (of_all(look.chroma) < least_chroma)
    warn("segment.gray_photo",
         fmt::format("the photo has no colours (mean chroma {:.1f} of 255)", of_all(look.chroma)));
  if (of_all(look.luminance) < least_luminance)
    warn("segment.dark_photo",
         fmt::format("the photo is dark (mean luminance {:.0f} of 255), as by night", of_all(look.luminance)));
  if (of_all(look.white) > most_white)
    warn("segment.white_photo",
         fmt::format("{:.0f} % of the photo is white: snow, clouds or overexposed", 100.0 * of_all(look.white)));
  if (of_all(look.red) > most_red)
    warn("segment.infrared_photo",
         fmt::format("{:.0f} % of the photo is red: infrared as false colour, or red soil", 100.0 * of_all(look.red)));
  return findings;
}

}  // namespace orthodrive
