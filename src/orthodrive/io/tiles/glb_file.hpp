// SPDX-License-Identifier: Apache-2.0
#pragma once
// A binary glTF 2.0 file under construction: JSON, and the buffer that it describes, compressed by meshoptimizer where
// wanted (EXT_meshopt_compression).

#include <array>
#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace orthodrive::io {

using GltfJson = nlohmann::ordered_json;

/// glTF 2.0, 3.6.2: component types.
enum ComponentType {
  byte_type = 5120,
  unsigned_byte_type,
  short_type,
  unsigned_short_type,
  unsigned_int_type = 5125,
  float_type
};

class GlbFile {
 public:
  explicit GlbFile(bool compressed);

  /// All but buffers, views and accessors are the caller's.
  GltfJson json;
  [[nodiscard]] bool compressed() const { return compressed_; }
  /// Adds to extensionsUsed, and to extensionsRequired where a reader without it would draw something wrong.
  void use_extension(std::string_view name, bool required);

  /// Bytes as they are: pictures, tables. Returns their view.
  int add_bytes(std::span<const std::uint8_t> bytes);
  int add_bytes(std::string_view text);

  // Accessors. Those of one layout share a view: a view takes 250 bytes of JSON. Compressed numbers are rounded to
  // multiples of 2^exponent, of the number itself: equal numbers stay equal whatever stands beside them.
  template <std::size_t N>
  int add_numbers(const std::vector<std::array<float, N>>& values, int exponent) {
    return add_floats({values.empty() ? nullptr : values.front().data(), values.size() * N}, N, exponent);
  }
  /// With the bounds that glTF wants of positions.
  int add_positions(const std::vector<std::array<float, 3>>& values, int exponent);
  /// One number a vertex, such as a feature id.
  int add_scalars(const std::vector<float>& values) { return add_floats(values, 1, 0); }
  /// Unit vectors. Compressed: 12 bits in an octahedron, 0.03 degrees.
  int add_directions(const std::vector<std::array<float, 3>>& values);
  /// Unit vectors with a fourth number of 1 or -1, which stays. Compressed: 8 bits, half a degree.
  int add_tangents(const std::vector<std::array<float, 4>>& values);
  /// 0..1. Compressed: 16 bits.
  int add_shares(const std::vector<std::array<float, 2>>& values);
  /// 0..65535 for 0..1. Compressed: 8 bits.
  int add_colors(const std::vector<std::array<std::uint16_t, 4>>& values);
  int add_indices(std::span<const std::uint32_t> values, std::size_t vertex_count);

  /// Writes the file as a whole or not at all. Throws Error when it cannot be written.
  void write(const std::filesystem::path& path);

 private:
  /// How the numbers of a view lie.
  struct Layout {
    std::size_t stride;
    int target;          ///< of glTF
    const char* filter;  ///< of EXT_meshopt_compression; none: nullptr
    friend bool operator==(const Layout&, const Layout&) = default;
  };
  /// A view under construction: what its accessors have added so far.
  struct View {
    Layout layout;
    int index = 0;  ///< in the JSON
    std::vector<std::uint8_t> bytes;
  };
  /// Where a block begins.
  struct Place {
    int view = 0;
    std::size_t offset = 0;
  };
  int add_floats(std::span<const float> values, std::size_t width, int exponent);
  /// Unit vectors as points of an octahedron, in four numbers of so many bits.
  template <typename Word>
  Place add_octahedral(const std::vector<std::array<float, 4>>& values, int bits);
  Place add_block(const void* bytes, std::size_t size, const Layout& layout);
  int add_accessor(Place at, std::size_t count, int component_type, std::string_view type, bool normalized = false);
  void write_view(const View& view);
  std::size_t append(std::span<const std::uint8_t> bytes);

  bool compressed_ = false;
  std::vector<std::uint8_t> bytes_;
  std::vector<View> views_;
  std::size_t unpacked_size_ = 0;  ///< of what compressed views decode to
};

}  // namespace orthodrive::io
