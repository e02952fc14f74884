#pragma once
// The safetensors format: u64 header length (little endian), a JSON header, the tensors' bytes.
// https://github.com/huggingface/safetensors (format section). Reads F32 and F16; values are float in memory.

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace orthodrive {

enum class TensorType { f32, f16 };

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

}  // namespace orthodrive
