// SPDX-License-Identifier: Apache-2.0
#pragma once
// Weights as safetensors files (format: safetensors_header.hpp). Reads F32 and F16; values are float in memory.
// Other types, and files too large to be held twice: safetensors_stream.hpp.

#include <cstdint>
#include <iosfwd>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "orthodrive/io/models/safetensors_header.hpp"
#include "orthodrive/model/rasters/tensor_file.hpp"

namespace orthodrive {

/// `source` names the file in messages. Throws InputError for anything that is not a complete safetensors file.
[[nodiscard]] TensorFile parse_safetensors(std::string_view bytes, const std::string& source);
[[nodiscard]] std::string format_safetensors(const TensorFile& file);
/// The same bytes, without holding them. Throws Error when the stream fails.
void write_safetensors(std::ostream& out, const TensorFile& file);

}  // namespace orthodrive
