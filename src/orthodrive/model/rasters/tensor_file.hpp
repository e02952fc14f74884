// SPDX-License-Identifier: Apache-2.0
#pragma once
// Named tensors with text about them: what a file of weights holds.

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace orthodrive {

enum class TensorType { f32, f16, u8, i64 };

struct NamedTensor {
  std::vector<std::int64_t> shape;
  std::vector<float> values;               ///< row-major
  TensorType stored_as = TensorType::f32;  ///< type in the file; f16 rounds to nearest even
};

struct TensorFile {
  std::map<std::string, std::string> metadata;
  std::map<std::string, NamedTensor> tensors;  ///< sorted: same content, same bytes
};

/// IEEE 754 binary16.
[[nodiscard]] float float_from_half(std::uint16_t half);
[[nodiscard]] std::uint16_t half_from_float(float value);  ///< to nearest, ties to even

/// The values that a file of these tensors would give back.
[[nodiscard]] TensorFile rounded_as_stored(TensorFile file);

}  // namespace orthodrive
