#include "orthodrive/segment/safetensors.hpp"

#include <fmt/format.h>

#include <bit>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>

#include "orthodrive/core/error.hpp"

namespace orthodrive {
namespace {

static_assert(std::endian::native == std::endian::little, "safetensors is little endian");

float float_from_half(std::uint16_t h) {
  const std::uint32_t sign = static_cast<std::uint32_t>(h & 0x8000U) << 16;
  const std::uint32_t exponent = (h >> 10) & 0x1fU;
  const std::uint32_t mantissa = h & 0x3ffU;
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

std::size_t element_count(const std::vector<std::int64_t>& shape) {
  std::size_t count = 1;
  for (const std::int64_t n : shape) count *= static_cast<std::size_t>(n);
  return count;
}

NamedTensor parse_tensor(const nlohmann::json& entry, std::string_view data) {
  NamedTensor tensor;
  entry.at("shape").get_to(tensor.shape);
  const auto begin = entry.at("data_offsets").at(0).get<std::size_t>();
  const auto end = entry.at("data_offsets").at(1).get<std::size_t>();
  const auto type = entry.at("dtype").get<std::string>();
  if (type != "F32" && type != "F16")
    throw std::runtime_error("tensor type " + type + " is not supported, use F32 or F16");
  const std::size_t count = element_count(tensor.shape), size = type == "F32" ? 4 : 2;
  if (begin > end || end > data.size() || end - begin != count * size)
    throw std::runtime_error("truncated or inconsistent");
  tensor.values.resize(count);
  if (type == "F32") {
    std::memcpy(tensor.values.data(), data.data() + begin, end - begin);
  } else {
    tensor.stored_as = TensorType::f16;
    for (std::size_t i = 0; i < count; ++i) {
      std::uint16_t half = 0;
      std::memcpy(&half, data.data() + begin + 2 * i, 2);
      tensor.values[i] = float_from_half(half);
    }
  }
  return tensor;
}

}  // namespace

TensorFile parse_safetensors(std::string_view bytes, const std::string& source) {
  std::uint64_t header_size = 0;
  if (bytes.size() < sizeof(header_size)) throw InputError(source, "not a safetensors file (too short)");
  std::memcpy(&header_size, bytes.data(), sizeof(header_size));
  if (header_size > bytes.size() - sizeof(header_size)) {
    throw InputError(source, "not a safetensors file, or truncated: fetch it again");
  }
  const std::string_view header = bytes.substr(sizeof(header_size), header_size);
  const std::string_view data = bytes.substr(sizeof(header_size) + header_size);
  TensorFile file;
  std::string name;
  try {
    const auto json = nlohmann::json::parse(header);
    for (const auto& [key, entry] : json.items()) {
      name = key;
      if (key == "__metadata__") {
        entry.get_to(file.metadata);
      } else {
        file.tensors.emplace(key, parse_tensor(entry, data));
      }
    }
  } catch (const std::exception& error) {
    throw InputError(
        source, fmt::format("not a complete safetensors file (tensor '{}': {}): fetch it again", name, error.what()));
  }
  return file;
}

std::string format_safetensors(const TensorFile& file) {
  nlohmann::json header = nlohmann::json::object();
  if (!file.metadata.empty()) header["__metadata__"] = file.metadata;
  std::string data;
  for (const auto& [name, tensor] : file.tensors) {
    const std::size_t begin = data.size();
    if (tensor.stored_as == TensorType::f32) {
      data.append(reinterpret_cast<const char*>(tensor.values.data()), tensor.values.size() * sizeof(float));
    } else {
      for (const float value : tensor.values) {
        const std::uint16_t half = half_from_float(value);
        data.append(reinterpret_cast<const char*>(&half), sizeof(half));
      }
    }
    header[name] = {{"dtype", tensor.stored_as == TensorType::f32 ? "F32" : "F16"},
                    {"shape", tensor.shape},
                    {"data_offsets", {begin, data.size()}}};
  }
  std::string text = header.dump();
  text.append((8 - text.size() % 8) % 8, ' ');  // the format allows trailing spaces; keeps the data aligned
  const std::uint64_t size = text.size();
  std::string bytes(reinterpret_cast<const char*>(&size), sizeof(size));
  return bytes + text + data;
}

}  // namespace orthodrive
