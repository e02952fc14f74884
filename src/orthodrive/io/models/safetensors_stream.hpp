// SPDX-License-Identifier: Apache-2.0
#pragma once
// Safetensors files that are too large to be held in memory twice: written in pieces, read tensor by tensor.

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iosfwd>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "orthodrive/io/models/safetensors.hpp"
#include "orthodrive/io/models/safetensors_header.hpp"

namespace orthodrive {

/// Writes the tensors one after another, each in as many pieces as wished:
///   SafetensorsWriter writer(stream, {}, {{"a", TensorType::u8, {2}}, {"b", TensorType::i64, {1}}});
///   writer.write("a", bytes_of_a); writer.write("b", bytes_of_b); writer.finish();
/// Throws Error when the stream fails (disk full) and when names or sizes are not those announced.
class SafetensorsWriter {
 public:
  /// Writes the header.
  SafetensorsWriter(std::ostream& out, const std::map<std::string, std::string>& metadata,
                    std::vector<TensorSpec> tensors);
  /// The next bytes of that tensor, little endian.
  void write(const std::string& name, std::span<const std::byte> bytes);
  /// Checks that all is there, and flushes.
  void finish();

 private:
  void skip_complete();
  std::ostream& out_;
  std::vector<TensorSpec> tensors_;
  std::size_t tensor_ = 0;           ///< the one being written
  std::uint64_t written_bytes_ = 0;  ///< of it
};

/// Reads the header at once and the tensors when asked. InputError for what is no complete safetensors file. A tensor
/// that is missing or of another type is an InputError too: the file is not what the caller takes it for.
class SafetensorsReader {
 public:
  explicit SafetensorsReader(const std::filesystem::path& file);

  [[nodiscard]] const std::string& source() const { return source_; }
  [[nodiscard]] const std::map<std::string, std::string>& metadata() const { return header_.metadata; }
  [[nodiscard]] const std::map<std::string, TensorPlace>& tensors() const { return header_.tensors; }
  [[nodiscard]] const TensorPlace& place(const std::string& name, TensorType type) const;

  /// Bytes of a tensor from `first_byte` on, as many as `into` holds.
  void read(const TensorPlace& place, std::uint64_t first_byte, std::span<std::byte> into);
  [[nodiscard]] std::vector<std::uint8_t> read_u8(const std::string& name);
  [[nodiscard]] std::vector<std::int64_t> read_i64(const std::string& name);
  [[nodiscard]] NamedTensor read_floats(const std::string& name);  ///< F32 or F16

 private:
  std::string source_;
  std::ifstream stream_;
  SafetensorsHeader header_;
  std::uint64_t data_begin_ = 0;  ///< in the file
};

/// As parse_safetensors, without holding the file's bytes.
[[nodiscard]] TensorFile read_safetensors(const std::filesystem::path& file);

}  // namespace orthodrive
