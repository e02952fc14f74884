// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/io/models/safetensors.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <limits>
#include <span>
#include <sstream>
#include <utility>

#include "orthodrive/core/error.hpp"
#include "orthodrive/io/models/safetensors_stream.hpp"

namespace orthodrive {
namespace {

NamedTensor parse_tensor(const TensorPlace& place, std::string_view data) {
  NamedTensor tensor{place.shape, std::vector<float>(place.size() / bytes_of(place.type)), place.type};
  if (place.type == TensorType::f32) {
    if (place.size() > 0) std::memcpy(tensor.values.data(), data.data() + place.begin, place.size());
  } else {
    for (std::size_t i = 0; i < tensor.values.size(); ++i) {
      std::uint16_t half = 0;
      std::memcpy(&half, data.data() + place.begin + 2 * i, 2);
      tensor.values[i] = float_from_half(half);
    }
  }
  return tensor;
}

void write_tensor(SafetensorsWriter& writer, const std::string& name, const NamedTensor& tensor) {
  if (tensor.stored_as == TensorType::f32) return writer.write(name, std::as_bytes(std::span(tensor.values)));
  constexpr std::size_t piece = 65536;
  std::vector<std::uint16_t> halves;
  for (std::size_t begin = 0; begin < tensor.values.size(); begin += piece) {
    const auto values = std::span(tensor.values).subspan(begin, std::min(piece, tensor.values.size() - begin));
    halves.resize(values.size());
    std::transform(values.begin(), values.end(), halves.begin(), half_from_float);
    writer.write(name, std::as_bytes(std::span(halves)));
  }
}

}  // namespace

TensorFile parse_safetensors(std::string_view bytes, const std::string& source) {
  std::uint64_t header_bytes = 0;
  if (bytes.size() < sizeof(header_bytes)) throw InputError(source, "not a safetensors file (too short)");
  std::memcpy(&header_bytes, bytes.data(), sizeof(header_bytes));
  if (header_bytes > bytes.size() - sizeof(header_bytes) || header_bytes > max_safetensors_header_bytes) {
    throw InputError(source, "not a safetensors file, or truncated: fetch it again");
  }
  const std::string_view data = bytes.substr(sizeof(header_bytes) + header_bytes);
  SafetensorsHeader header =
      parse_safetensors_header(bytes.substr(sizeof(header_bytes), header_bytes), data.size(), source);
  TensorFile file;
  file.metadata = std::move(header.metadata);
  for (const auto& [name, place] : header.tensors) {
    if (place.type != TensorType::f32 && place.type != TensorType::f16) {
      throw InputError(source, fmt::format("tensor '{}' is {}, weights are F32 or F16: is it the right file?", name,
                                           to_string(place.type)));
    }
    file.tensors.emplace(name, parse_tensor(place, data));
  }
  return file;
}

void write_safetensors(std::ostream& out, const TensorFile& file) {
  std::vector<TensorSpec> specs;
  specs.reserve(file.tensors.size());
  for (const auto& [name, tensor] : file.tensors) specs.push_back({name, tensor.stored_as, tensor.shape});
  SafetensorsWriter writer(out, file.metadata, std::move(specs));
  for (const auto& [name, tensor] : file.tensors) write_tensor(writer, name, tensor);
  writer.finish();
}

std::string format_safetensors(const TensorFile& file) {
  std::ostringstream out;
  write_safetensors(out, file);
  return std::move(out).str();
}

}  // namespace orthodrive
