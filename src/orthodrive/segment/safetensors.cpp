#include "orthodrive/segment/safetensors.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <limits>
#include <span>
#include <sstream>
#include <utility>

#include "orthodrive/core/error.hpp"
#include "orthodrive/segment/safetensors_stream.hpp"

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
