// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/io/tiles/glb_file.hpp"

#include <meshoptimizer.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>

#include "orthodrive/core/atomic_file.hpp"
#include "orthodrive/core/error.hpp"

namespace orthodrive::io {
namespace {

// glTF 2.0, 5.11: targets.
constexpr int array_buffer = 34962, element_array_buffer = 34963;
constexpr int direction_bits = 12, tangent_bits = 8;
constexpr int largest_mantissa = (1 << 23) - 1;

/// EXT_meshopt_compression, filter EXPONENTIAL: a signed mantissa of 24 bits, then the exponent of 2.
std::uint32_t exponential_word(float value, int exponent) {
  const double steps = std::floor(std::ldexp(static_cast<double>(value), -exponent) + 0.5);
  return (static_cast<std::uint32_t>(static_cast<std::int32_t>(steps)) & 0xffffffU) |
         (static_cast<std::uint32_t>(exponent) << 24U);
}

/// The smallest exponent, at least the one given, at which all values fit.
int fitting_exponent(std::span<const float> values, int exponent) {
  double largest = 0.0;
  for (const float v : values) largest = std::max(largest, std::abs(static_cast<double>(v)));
  while (std::ldexp(largest, -exponent) > largest_mantissa - 1) ++exponent;
  return exponent;
}

std::string_view vector_type(std::size_t width) {
  constexpr std::array<std::string_view, 4> names = {"SCALAR", "VEC2", "VEC3", "VEC4"};
  return names[width - 1];
}

std::span<const std::uint8_t> as_bytes(const void* data, std::size_t size) {
  return {static_cast<const std::uint8_t*>(data), size};
}

std::vector<std::uint8_t> packed_values(const std::vector<std::uint8_t>& bytes, std::size_t stride) {
  const std::size_t count = bytes.size() / stride;
  std::vector<std::uint8_t> packed(meshopt_encodeVertexBufferBound(count, stride));
  packed.resize(meshopt_encodeVertexBuffer(packed.data(), packed.size(), bytes.data(), count, stride));
  return packed;
}

/// Indices of 2 or 4 bytes.
std::vector<std::uint8_t> packed_indices(const std::vector<std::uint8_t>& bytes, std::size_t stride) {
  std::vector<std::uint32_t> indices(bytes.size() / stride);
  for (std::size_t i = 0; i < indices.size(); ++i)
    std::memcpy(&indices[i], &bytes[i * stride], stride);  // little endian
  const std::size_t vertices = std::size_t{*std::ranges::max_element(indices)} + 1;
  std::vector<std::uint8_t> packed(meshopt_encodeIndexBufferBound(indices.size(), vertices));
  packed.resize(meshopt_encodeIndexBuffer(packed.data(), packed.size(), indices.data(), indices.size()));
  return packed;
}

}  // namespace

GlbFile::GlbFile(bool compressed) : compressed_(compressed) {
  json = {{"asset", {{"version", "2.0"}, {"generator", "Orthodrive"}}}};
  if (compressed) use_extension("EXT_meshopt_compression", true);
}

void GlbFile::use_extension(std::string_view name, bool required) {
  const auto add = [&](const char* list) {
    auto& names = json[list];
    if (std::ranges::none_of(names, [&](const auto& known) { return known.template get<std::string_view>() == name; }))
      names.push_back(name);
  };
  add("extensionsUsed");
  if (required) add("extensionsRequired");
}

/// Each block on a multiple of eight bytes: EXT_structural_metadata wants that, glTF four.
std::size_t GlbFile::append(std::span<const std::uint8_t> bytes) {
  bytes_.resize((bytes_.size() + 7) / 8 * 8);
  bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
  return bytes_.size() - bytes.size();
}

int GlbFile::add_bytes(std::span<const std::uint8_t> bytes) {
  const std::size_t offset = append(bytes);
  auto& views = json["bufferViews"];
  views.push_back({{"buffer", 0}, {"byteOffset", offset}, {"byteLength", bytes.size()}});
  return static_cast<int>(views.size()) - 1;
}

int GlbFile::add_bytes(std::string_view text) { return add_bytes(as_bytes(text.data(), text.size())); }

GlbFile::Place GlbFile::add_block(const void* bytes, std::size_t size, const Layout& layout) {
  auto view = std::ranges::find(views_, layout, &View::layout);
  if (view == views_.end()) {
    auto& listed = json["bufferViews"];
    view = views_.insert(view, {layout, static_cast<int>(listed.size()), {}});
    listed.push_back(nullptr);  // filled in by write_view()
  }
  const std::size_t offset = view->bytes.size();
  const auto added = as_bytes(bytes, size);
  view->bytes.insert(view->bytes.end(), added.begin(), added.end());
  return {view->index, offset};
}

void GlbFile::write_view(const View& view) {
  const auto& [stride, target, filter] = view.layout;
  const std::size_t count = view.bytes.size() / stride;
  const bool is_index = target == element_array_buffer;
  GltfJson made;
  if (!compressed_ || count == 0) {
    const std::size_t offset = append(view.bytes);
    made = {{"buffer", 0}, {"byteOffset", offset}, {"byteLength", view.bytes.size()}};
  } else {
    const std::vector<std::uint8_t> packed =
        is_index ? packed_indices(view.bytes, stride) : packed_values(view.bytes, stride);
    const std::size_t offset = append(packed);
    GltfJson compression = {
        {"buffer", 0},          {"byteOffset", offset}, {"byteLength", packed.size()},
        {"byteStride", stride}, {"count", count},       {"mode", is_index ? "TRIANGLES" : "ATTRIBUTES"}};
    if (filter != nullptr) compression["filter"] = filter;
    made = {{"buffer", 1}, {"byteOffset", unpacked_size_}, {"byteLength", view.bytes.size()}};
    made["extensions"]["EXT_meshopt_compression"] = std::move(compression);
    unpacked_size_ += (view.bytes.size() + 7) / 8 * 8;
  }
  if (!is_index) made["byteStride"] = stride;
  made["target"] = target;
  json["bufferViews"][static_cast<std::size_t>(view.index)] = std::move(made);
}

int GlbFile::add_accessor(Place at, std::size_t count, int component_type, std::string_view type, bool normalized) {
  GltfJson accessor = {{"bufferView", at.view}};
  if (at.offset > 0) accessor["byteOffset"] = at.offset;
  accessor["componentType"] = component_type, accessor["count"] = count, accessor["type"] = type;
  if (normalized) accessor["normalized"] = true;
  auto& accessors = json["accessors"];
  accessors.push_back(std::move(accessor));
  return static_cast<int>(accessors.size()) - 1;
}

int GlbFile::add_floats(std::span<const float> values, std::size_t width, int exponent) {
  const std::size_t count = values.size() / width, stride = width * sizeof(float);
  if (!compressed_)
    return add_accessor(add_block(values.data(), values.size_bytes(), {stride, array_buffer, nullptr}), count,
                        float_type, vector_type(width));
  exponent = fitting_exponent(values, exponent);
  std::vector<std::uint32_t> words;
  words.reserve(values.size());
  for (const float v : values) words.push_back(exponential_word(v, exponent));
  return add_accessor(add_block(words.data(), count * stride, {stride, array_buffer, "EXPONENTIAL"}), count, float_type,
                      vector_type(width));
}

int GlbFile::add_positions(const std::vector<std::array<float, 3>>& values, int exponent) {
  const int accessor = add_numbers(values, exponent);
  std::array<double, 3> low{}, high{};
  low.fill(std::numeric_limits<double>::infinity());
  high.fill(-std::numeric_limits<double>::infinity());
  if (!values.empty()) exponent = fitting_exponent({values.front().data(), values.size() * 3}, exponent);
  for (const auto& p : values) {
    for (std::size_t k = 0; k < 3; ++k) {
      const double v = static_cast<double>(p[k]);
      const double kept = compressed_ ? std::ldexp(std::floor(std::ldexp(v, -exponent) + 0.5), exponent) : v;
      low[k] = std::min(low[k], kept);
      high[k] = std::max(high[k], kept);
    }
  }
  json["accessors"].back()["min"] = low;
  json["accessors"].back()["max"] = high;
  return accessor;
}

template <typename Word>
GlbFile::Place GlbFile::add_octahedral(const std::vector<std::array<float, 4>>& values, int bits) {
  constexpr std::size_t stride = 4 * sizeof(Word);
  std::vector<std::array<Word, 4>> words(values.size());
  meshopt_encodeFilterOct(words.data(), values.size(), stride, bits, values.empty() ? nullptr : values.front().data());
  use_extension("KHR_mesh_quantization", true);
  return add_block(words.data(), values.size() * stride, {stride, array_buffer, "OCTAHEDRAL"});
}

int GlbFile::add_directions(const std::vector<std::array<float, 3>>& values) {
  if (!compressed_) return add_numbers(values, 0);
  std::vector<std::array<float, 4>> padded;
  padded.reserve(values.size());
  for (const auto& v : values) padded.push_back({v[0], v[1], v[2], 0.0F});
  return add_accessor(add_octahedral<std::int16_t>(padded, direction_bits), values.size(), short_type, "VEC3", true);
}

int GlbFile::add_tangents(const std::vector<std::array<float, 4>>& values) {
  if (!compressed_) return add_numbers(values, 0);
  return add_accessor(add_octahedral<std::int8_t>(values, tangent_bits), values.size(), byte_type, "VEC4", true);
}

int GlbFile::add_shares(const std::vector<std::array<float, 2>>& values) {
  if (!compressed_) return add_numbers(values, 0);
  std::vector<std::array<std::uint16_t, 2>> words;
  for (const auto& v : values) {
    const auto word = [](float share) {
      return static_cast<std::uint16_t>(std::lround(std::clamp(share, 0.0F, 1.0F) * 65535.0F));
    };
    words.push_back({word(v[0]), word(v[1])});
  }
  constexpr std::size_t stride = sizeof(words[0]);
  return add_accessor(add_block(words.data(), words.size() * stride, {stride, array_buffer, nullptr}), words.size(),
                      unsigned_short_type, "VEC2", true);
}

int GlbFile::add_colors(const std::vector<std::array<std::uint16_t, 4>>& values) {
  const std::size_t count = values.size();
  if (!compressed_)
    return add_accessor(add_block(values.data(), count * sizeof(values[0]), {sizeof(values[0]), array_buffer, nullptr}),
                        count, unsigned_short_type, "VEC4", true);
  constexpr int step = 65535 / 255;  // linear factors of textures: their grain hides what is rounded
  std::vector<std::array<std::uint8_t, 4>> words(count);
  for (std::size_t i = 0; i < count; ++i)
    for (std::size_t c = 0; c < 4; ++c) words[i][c] = static_cast<std::uint8_t>((values[i][c] + step / 2) / step);
  constexpr std::size_t stride = sizeof(words[0]);
  return add_accessor(add_block(words.data(), count * stride, {stride, array_buffer, nullptr}), count,
                      unsigned_byte_type, "VEC4", true);
}

int GlbFile::add_indices(std::span<const std::uint32_t> values, std::size_t vertex_count) {
  if (!compressed_ || vertex_count > 65535)  // glTF keeps the largest index of a type for itself
    return add_accessor(add_block(values.data(), values.size_bytes(), {4, element_array_buffer, nullptr}),
                        values.size(), unsigned_int_type, "SCALAR");
  const std::vector<std::uint16_t> narrow(values.begin(), values.end());
  return add_accessor(add_block(narrow.data(), narrow.size() * 2, {2, element_array_buffer, nullptr}), values.size(),
                      unsigned_short_type, "SCALAR");
}

void GlbFile::write(const std::filesystem::path& path) {
  for (const View& view : views_) write_view(view);
  views_.clear();
  bytes_.resize((bytes_.size() + 3) / 4 * 4);
  json["buffers"] = GltfJson::array({{{"byteLength", bytes_.size()}}});
  if (unpacked_size_ > 0)
    json["buffers"].push_back(
        {{"byteLength", unpacked_size_}, {"extensions", {{"EXT_meshopt_compression", {{"fallback", true}}}}}});
  std::string text = json.dump();
  text.resize((text.size() + 3) / 4 * 4, ' ');
  const auto word = [](std::size_t v) { return static_cast<std::uint32_t>(v); };
  const std::array<std::uint32_t, 5> head = {0x46546c67U, 2U, word(28 + text.size() + bytes_.size()), word(text.size()),
                                             0x4e4f534aU};  // "glTF", version, length; length and "JSON"
  const std::array<std::uint32_t, 2> bin = {word(bytes_.size()), 0x004e4942U};  // length and "BIN"

  AtomicFile out(path);
  std::ofstream stream(out.path(), std::ios::binary);
  const auto put = [&](const void* data, std::size_t size) {
    stream.write(static_cast<const char*>(data), static_cast<std::streamsize>(size));
  };
  put(head.data(), sizeof head);
  put(text.data(), text.size());
  put(bin.data(), sizeof bin);
  put(bytes_.data(), bytes_.size());
  stream.close();
  if (!stream) throw Error(path.string() + ": cannot be written, is the disk full or the folder read-only?");
  out.commit();
}

}  // namespace orthodrive::io
