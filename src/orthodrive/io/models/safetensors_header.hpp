// SPDX-License-Identifier: Apache-2.0
#pragma once
// The head of a safetensors file: u64 header length (little endian), a JSON header, then the tensors' bytes.
// https://github.com/huggingface/safetensors (format section). As there, the tensors fill the data without gap or
// overlap.

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "orthodrive/model/rasters/tensor_file.hpp"

namespace orthodrive {

[[nodiscard]] const char* to_string(TensorType type);  ///< "F32", "F16", "U8", "I64" as in the file
[[nodiscard]] std::uint64_t bytes_of(TensorType type);

/// A tensor that is to be written.
struct TensorSpec {
  std::string name;
  TensorType type = TensorType::f32;
  std::vector<std::int64_t> shape;
};
/// Throws Error for negative sizes and more bytes than 2^63.
[[nodiscard]] std::uint64_t byte_count(const TensorSpec& spec);

/// Where a tensor lies in a file.
struct TensorPlace {
  TensorType type = TensorType::f32;
  std::vector<std::int64_t> shape;   ///< row-major
  std::uint64_t begin = 0, end = 0;  ///< bytes from the beginning of the data
  [[nodiscard]] std::uint64_t size() const { return end - begin; }
};

struct SafetensorsHeader {
  std::map<std::string, std::string> metadata;
  std::map<std::string, TensorPlace> tensors;
};

constexpr std::uint64_t max_safetensors_header_bytes = 100'000'000;  // as in the reference implementation

/// `json`: the header; `data_bytes`: what follows it. Throws InputError naming `source` and the tensor.
[[nodiscard]] SafetensorsHeader parse_safetensors_header(std::string_view json, std::uint64_t data_bytes,
                                                         const std::string& source);
/// The length and the JSON, padded to 8 bytes, of a file with these tensors one after another.
[[nodiscard]] std::string format_safetensors_header(const std::map<std::string, std::string>& metadata,
                                                    const std::vector<TensorSpec>& tensors);

}  // namespace orthodrive
