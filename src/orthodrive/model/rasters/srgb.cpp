// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/model/rasters/srgb.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace orthodrive {

const std::array<float, 256>& linear_values() {
  static const std::array<float, 256> table = [] {
    std::array<float, 256> values{};
    for (std::size_t i = 0; i < values.size(); ++i) {
      const double v = static_cast<double>(i) / 255.0;
      values[i] = static_cast<float>(v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4));
    }
    return values;
  }();
  return table;
}

std::uint8_t srgb_byte(double linear) {
  constexpr double steps = 65535.0;  // eight of them a byte where it is darkest
  static const std::vector<std::uint8_t> table = [] {
    std::vector<std::uint8_t> bytes(static_cast<std::size_t>(steps) + 1);
    for (std::size_t i = 0; i < bytes.size(); ++i) {
      const double v = static_cast<double>(i) / steps;
      const double s = v <= 0.0031308 ? 12.92 * v : 1.055 * std::pow(v, 1.0 / 2.4) - 0.055;
      bytes[i] = static_cast<std::uint8_t>(std::floor(255.0 * std::clamp(s, 0.0, 1.0) + 0.5));
    }
    return bytes;
  }();
  // NOLINTNEXTLINE(bugprone-incorrect-roundings): never negative, and asked for every pixel
  return table[static_cast<std::size_t>(steps * std::clamp(linear, 0.0, 1.0) + 0.5)];
}

}  // namespace orthodrive
