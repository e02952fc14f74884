// SPDX-License-Identifier: Apache-2.0
#pragma once
// sRGB (IEC 61966-2-1) and linear light.

#include <array>
#include <cstdint>

namespace orthodrive {

/// Linear red, green and blue, 0 to 1.
using LinearColor = std::array<float, 3>;

/// Linear light of a byte, 0 to 1.
[[nodiscard]] const std::array<float, 256>& linear_values();
/// The nearest byte to linear light, which is cut to 0 to 1.
[[nodiscard]] std::uint8_t srgb_byte(double linear);

}  // namespace orthodrive
