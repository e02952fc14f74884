// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/io/models/safetensors_header.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>

#include "orthodrive/core/error.hpp"
#include "orthodrive/core/whole_number.hpp"

namespace orthodrive {
namespace {

static_assert(std::endian::native == std::endian::little, "safetensors is little endian");

TensorType type_from_string(const std::string& name) {
  for (const TensorType type : {TensorType::f32, TensorType::f16, TensorType::u8, TensorType::i64}) {
    if (name == to_string(type)) return type;
  }
  throw Error("tensor type " + name + " is not supported, use F32, F16, U8 or I64");
}

TensorPlace parse_place(const std::string& name, const nlohmann::json& entry, std::uint64_t data_bytes) {
  TensorPlace place;
  place.type = type_from_string(entry.at("dtype").get<std::string>());
  for (const auto& edge : entry.at("shape"))
    place.shape.push_back(whole_number<std::int64_t>(edge, "an edge of a shape"));
  const auto& offsets = entry.at("data_offsets");
  if (offsets.size() != 2) throw Error("data_offsets are not two positions");
  place.begin = whole_number<std::uint64_t>(offsets.at(0), "a position in data_offsets");
  place.end = whole_number<std::uint64_t>(offsets.at(1), "a position in data_offsets");
  if (place.begin > place.end || place.end > data_bytes ||
      place.size() != byte_count({name, place.type, place.shape})) {
    throw Error("truncated or inconsistent");
  }
  return place;
}

/// Every byte of the data belongs to one tensor.
void check_layout(const SafetensorsHeader& header, std::uint64_t data_bytes, std::string& name) {
  std::vector<std::pair<const std::string*, const TensorPlace*>> order;
  order.reserve(header.tensors.size());
  for (const auto& [key, place] : header.tensors) order.emplace_back(&key, &place);
  std::sort(order.begin(), order.end(), [](const auto& a, const auto& b) {
    return std::pair(a.second->begin, a.second->end) < std::pair(b.second->begin, b.second->end);
  });
  std::uint64_t at = 0;
  for (const auto& [key, place] : order) {
    name = *key;
    if (place->begin < at) throw Error("overlaps the tensor before it");
    if (place->begin > at) throw Error(fmt::format("{} bytes before it belong to no tensor", place->begin - at));
    at = place->end;
  }
  if (at != data_bytes) throw Error(fmt::format("{} bytes after it belong to no tensor", data_bytes - at));
}

}  // namespace

const char* to_string(TensorType type) {
  switch (type) {
    case TensorType::f32:
      return "F32";
    case TensorType::f16:
      return "F16";
    case TensorType::u8:
      return "U8";
    case TensorType::i64:
      return "I64";
  }
  return "?";
}

std::uint64_t bytes_of(TensorType type) {
  switch (type) {
    case TensorType::f32:
      return 4;
    case TensorType::f16:
      return 2;
    case TensorType::u8:
      return 1;
    case TensorType::i64:
      return 8;
  }
  return 0;
}

std::uint64_t byte_count(const TensorSpec& spec) {
  constexpr std::uint64_t most = std::numeric_limits<std::int64_t>::max();
  std::uint64_t count = bytes_of(spec.type);
  for (const std::int64_t n : spec.shape) {
    if (n < 0 || (n > 0 && count > most / static_cast<std::uint64_t>(n))) {
      throw Error(fmt::format("tensor '{}' has an impossible shape", spec.name));
    }
    count *= static_cast<std::uint64_t>(n);
  }
  return count;
}

SafetensorsHeader parse_safetensors_header(std::string_view json, std::uint64_t data_bytes, const std::string& source) {
  SafetensorsHeader header;
  std::string name;
  try {
    const auto entries = nlohmann::json::parse(json);
    if (!entries.is_object()) throw Error("the header is no JSON object");
    for (const auto& [key, entry] : entries.items()) {
      name = key;
      if (key == "__metadata__") {
        entry.get_to(header.metadata);
      } else {
        header.tensors.emplace(key, parse_place(key, entry, data_bytes));
      }
    }
    check_layout(header, data_bytes, name);
  } catch (const std::exception& error) {
    throw InputError(
        source, fmt::format("not a complete safetensors file (tensor '{}': {}): fetch it again", name, error.what()));
  }
  return header;
}

std::string format_safetensors_header(const std::map<std::string, std::string>& metadata,
                                      const std::vector<TensorSpec>& tensors) {
  nlohmann::json header = nlohmann::json::object();
  if (!metadata.empty()) header["__metadata__"] = metadata;
  std::uint64_t begin = 0;
  for (const TensorSpec& spec : tensors) {
    const std::uint64_t end = begin + byte_count(spec);
    if (header.contains(spec.name)) throw Error(fmt::format("tensor '{}' is there twice", spec.name));
    header[spec.name] = {{"dtype", to_string(spec.type)}, {"shape", spec.shape}, {"data_offsets", {begin, end}}};
    begin = end;
  }
  std::string text = header.dump();
  text.append((8 - text.size() % 8) % 8, ' ');  // the format allows trailing spaces; keeps the data aligned
  const std::uint64_t size = text.size();
  return std::string(reinterpret_cast<const char*>(&size), sizeof(size)) + text;
}

}  // namespace orthodrive
