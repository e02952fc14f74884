// SPDX-License-Identifier: Apache-2.0
#pragma once
// Plain structs to bytes and back: results that one process leaves another of the same program. No format for users.
//
// A struct tells its fields once, for both ways, in a function that lookup by argument finds:
//   template <typename Archive> void fields(Archive& archive, PhotoLook& look) { archive(look.pixels, look.white); }

#include <array>
#include <concepts>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "orthodrive/core/error.hpp"

namespace orthodrive {

template <typename Archive, typename T>
concept HasFields = requires(Archive& archive, T& value) {
  fields(archive, value);
};

class ByteWriter {
 public:
  template <typename... T>
  void operator()(const T&... values) {
    (put(values), ...);
  }
  [[nodiscard]] std::string take() { return std::move(bytes_); }

 private:
  template <typename T>
  void put(const T& value) {
    if constexpr (HasFields<ByteWriter, T>) {
      fields(*this, const_cast<T&>(value));  // reads only
    } else {
      static_assert(std::is_arithmetic_v<T> || std::is_enum_v<T>, "tell the fields of this type");
      bytes_.append(reinterpret_cast<const char*>(&value), sizeof(T));
    }
  }
  template <typename T, std::size_t n>
  void put(const std::array<T, n>& values) {
    for (const T& value : values) put(value);
  }
  template <typename T>
  void put(const std::optional<T>& value) {
    put(value.has_value());
    if (value) put(*value);
  }
  template <typename T>
  void put(const std::vector<T>& values) {
    put(static_cast<std::uint64_t>(values.size()));
    if constexpr (std::is_arithmetic_v<T>)
      bytes_.append(reinterpret_cast<const char*>(values.data()), sizeof(T) * values.size());
    else
      for (const T& value : values) put(value);
  }
  void put(const std::vector<bool>& values) { put(std::vector<char>(values.begin(), values.end())); }
  template <typename... T>
  void put(const std::variant<T...>& value) {
    put(static_cast<std::uint8_t>(value.index()));
    std::visit([this](const auto& held) { put(held); }, value);
  }
  void put(const std::string& text) { put(std::vector<char>(text.begin(), text.end())); }

  std::string bytes_;
};

/// Throws InputError when the bytes end too early or go on too long: they are of another program, or were cut.
class ByteReader {
 public:
  /// `bytes` must outlive the reader. `name`: of the file, for messages.
  ByteReader(std::string_view bytes, std::string name) : bytes_(bytes), name_(std::move(name)) {}
  template <typename... T>
  void operator()(T&... values) {
    (get(values), ...);
  }
  void finish() const {
    if (!bytes_.empty()) fail();
  }

 private:
  [[noreturn]] void fail() const {
    throw InputError(name_, "is no result that this program left; remove it and run again");
  }
  void read(void* target, std::uint64_t size) {
    if (size > bytes_.size()) fail();
    std::memcpy(target, bytes_.data(), size);
    bytes_.remove_prefix(size);
  }
  template <typename T>
  void get(T& value) {
    if constexpr (HasFields<ByteReader, T>) {
      fields(*this, value);
    } else {
      static_assert(std::is_arithmetic_v<T> || std::is_enum_v<T>, "tell the fields of this type");
      read(&value, sizeof(T));
    }
  }
  template <typename T, std::size_t n>
  void get(std::array<T, n>& values) {
    for (T& value : values) get(value);
  }
  template <typename T>
  void get(std::optional<T>& value) {
    bool there = false;
    get(there);
    value.reset();
    if (there) get(value.emplace());
  }
  template <typename T>
  void get(std::vector<T>& values) {
    std::uint64_t size = 0;
    get(size);
    if (size > bytes_.size()) fail();  // every item has a byte or more: no memory for what is not there
    if constexpr (std::is_arithmetic_v<T>) {
      if (size > bytes_.size() / sizeof(T)) fail();
      values.resize(size);
      if (size > 0) read(values.data(), sizeof(T) * size);
    } else {
      values.resize(size);
      for (T& value : values) get(value);
    }
  }
  void get(std::vector<bool>& values) {
    std::vector<char> bytes;
    get(bytes);
    values.assign(bytes.begin(), bytes.end());
  }
  template <typename... T>
  void get(std::variant<T...>& value) {
    std::uint8_t index = 0;
    get(index);
    if (index >= sizeof...(T)) fail();
    [&]<std::size_t... i>(std::index_sequence<i...>) {
      ((index == i ? get(value.template emplace<i>()) : void()), ...);
    }
    (std::index_sequence_for<T...>{});
  }
  void get(std::string& text) {
    std::vector<char> chars;
    get(chars);
    text.assign(chars.begin(), chars.end());
  }

  std::string_view bytes_;
  std::string name_;
};

}  // namespace orthodrive
