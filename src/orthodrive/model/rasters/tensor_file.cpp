// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/model/rasters/tensor_file.hpp"

#include <bit>
#include <cstdint>
#include <cstring>
#include <limits>

namespace orthodrive {

float float_from_half(std::uint16_t half) {
  const std::uint32_t sign = static_cast<std::uint32_t>(half & 0x8000U) << 16;
  const std::uint32_t exponent = (half >> 10) & 0x1fU;
  const std::uint32_t mantissa = half & 0x3ffU;
  if (exponent == 0) {  // zero or subnormal: mantissa * 2^-24
    const float magnitude = static_cast<float>(mantissa) * 0x1.0p-24F;
    return sign ? -magnitude : magnitude;
  }
  const std::uint32_t wide = exponent == 31 ? 0xffU : exponent + (127 - 15);
  return std::bit_cast<float>(sign | (wide << 23) | (mantissa << 13));
}

std::uint16_t half_from_float(float value) {
  const auto bits = std::bit_cast<std::uint32_t>(value);
  const auto sign = static_cast<std::uint16_t>((bits >> 16) & 0x8000U);
  const float magnitude = std::bit_cast<float>(bits & 0x7fffffffU);
  if (!(magnitude < std::numeric_limits<float>::infinity())) {
    return static_cast<std::uint16_t>(sign | (magnitude != magnitude ? 0x7e00U : 0x7c00U));
  }
  if (magnitude >= 65520.0F) return static_cast<std::uint16_t>(sign | 0x7c00U);
  if (magnitude < 0x1.0p-14F) {  // subnormal: the addition rounds to multiples of 2^-24, to nearest even
    const float shifted = magnitude + 0.5F;
    return static_cast<std::uint16_t>(sign |
                                      (std::bit_cast<std::uint32_t>(shifted) - std::bit_cast<std::uint32_t>(0.5F)));
  }
  const std::uint32_t m = std::bit_cast<std::uint32_t>(magnitude);
  const std::uint32_t rounded = m + 0xfffU + ((m >> 13) & 1U) - ((127U - 15U) << 23);
  return static_cast<std::uint16_t>(sign | (rounded >> 13));
}

TensorFile rounded_as_stored(TensorFile file) {
  for (auto& [name, tensor] : file.tensors)
    if (tensor.stored_as == TensorType::f16)
      for (float& value : tensor.values) value = float_from_half(half_from_float(value));
  return file;
}

}  // namespace orthodrive
