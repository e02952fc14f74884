#pragma once
// Weights as safetensors files (format: safetensors_header.hpp). Reads F32 and F16; values are float in memory.
// Other types, and files too large to be held twice: safetensors_stream.hpp.

#include <cstdint>
#include <iosfwd>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "orthodrive/segment/safetensors_header.hpp"

namespace orthodrive {

struct NamedTensor {
  std::vector<std::int64_t> shape;
  std::vector<float> values;               ///< row-major
  TensorType stored_as = TensorType::f32;  ///< type in the file; f16 rounds to nearest even
};

struct TensorFile {
  std::map<std::string, std::string> metadata;
  std::map<std::string, NamedTensor> tensors;  ///< sorted: same content, same bytes
};

/// `source` names the file in messages. Throws InputError for anything that is not a complete safetensors file.
[[nodiscard]] TensorFile parse_safetensors(std::string_view bytes, const std::string& source);
[[nodiscard]] std::string format_safetensors(const TensorFile& file);
/// The same bytes, without holding them. Throws Error when the stream fails.
void write_safetensors(std::ostream& out, const TensorFile& file);

/// IEEE 754 binary16.
[[nodiscard]] float float_from_half(std::uint16_t half);
[[nodiscard]] std::uint16_t half_from_float(float value);  ///< to nearest, ties to even

}  // namespace orthodrive
