// SPDX-License-Identifier: Apache-2.0
#pragma once
// Reading tables of a TOML file with the line of whatever is wrong. For .cpp files of this folder only.

#include <fmt/format.h>
#include <toml++/toml.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <set>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "orthodrive/core/error.hpp"
#include "orthodrive/geo/vec.hpp"

namespace orthodrive {

/// Throws InputError with the line of a syntax error.
[[nodiscard]] toml::table parse_toml(std::string_view text, const std::filesystem::path& file);

/// Puts "section.key=value" of a command line over what the file says. What is wrong in it is told as an OptionError
/// that quotes the text, whenever it shows up. Bare words are taken as texts.
void override_toml(toml::table& table, const std::string& text);

/// One table of the file: hands out its values and knows which keys nobody asked for. All that is wrong is told in one
/// line with file, line and key: InputError, or OptionError for what came with override_toml.
class TomlSection {
 public:
  /// `name` is how messages call the section: "drive" for the keys "drive.route"; empty for the whole file and for
  /// tables of lists, whose keys are called without it.
  TomlSection(const toml::table& table, const std::filesystem::path& file, std::string name = "")
      : table_(table), file_(file), name_(std::move(name)) {}

  template <typename T>
  void read(const char* key, T& value) {
    const toml::node* node = find(key);
    if (!node) return;
    if constexpr (std::is_same_v<T, std::filesystem::path>) {
      const auto text = node->value<std::string>();
      if (!text) fail(*node, fmt::format("{} must be a path", called(key)));
      value = file_.parent_path() / *text;
    } else if constexpr (std::is_same_v<T, bool>) {
      const auto flag = node->value_exact<bool>();
      if (!flag) fail(*node, fmt::format("{} must be true or false", called(key)));
      value = *flag;
    } else if constexpr (std::is_arithmetic_v<T>) {
      value = number_of<T>(*node, called(key));
    } else {
      const auto found = node->value<T>();
      if (!found) fail(*node, fmt::format("{} must be a text", called(key)));
      value = *found;
    }
  }

  template <typename T>
  void read(const char* key, std::vector<T>& values) {
    const toml::node* node = find(key);
    if (!node) return;
    if (!node->is_array()) fail(*node, fmt::format("{} must be a list", called(key)));
    values.clear();
    for (const toml::node& entry : *node->as_array()) {
      if constexpr (std::is_arithmetic_v<T>) {
        values.push_back(number_of<T>(entry, fmt::format("an entry of {}", called(key))));
      } else {
        const auto value = entry.value<T>();
        if (!value) fail(entry, fmt::format("{} has an entry of the wrong type", called(key)));
        values.push_back(*value);
      }
    }
  }

  /// A text, or a list of texts.
  void read_texts(const char* key, std::vector<std::string>& values);

  /// [red, green, blue], each 0 to 255, or "#RRGGBB". A key that is not there is an error.
  void read_color(const char* key, std::array<std::uint8_t, 3>& color);

  /// A text out of `choices`.
  void read_choice(const char* key, std::string& value, const std::vector<std::string>& choices);

  /// west, south, east, north
  template <typename Take>
  void read_box(const char* key, const Take& take) {
    std::vector<double> box;
    read(key, box);
    if (!table_.contains(key)) return;
    if (box.size() != 4) fail(*table_.get(key), fmt::format("{} must be [west, south, east, north]", called(key)));
    take(Box2{box[0], box[1], box[2], box[3]});
  }

  template <typename Visit>
  void for_each_table(const char* key, const Visit& visit) {
    const toml::node* node = find(key);
    if (!node) return;
    if (!node->is_array_of_tables()) fail(*node, fmt::format("{} must be a list of tables", called(key)));
    for (const toml::node& entry : *node->as_array()) {
      TomlSection section(*entry.as_table(), file_);
      visit(section);
      section.finish();
    }
  }

  const toml::table* find_table(const char* key);

  /// The section of that name; an empty one where the file has none.
  [[nodiscard]] TomlSection section(const char* key);

  /// The value as it is, for what no other function here reads; null: not there.
  const toml::node* find(const char* key) {
    used_.insert(key);
    return table_.get(key);
  }

  [[nodiscard]] bool has(const char* key) const { return table_.contains(key); }

  /// "site.toml:12" or "--set drive.route=x", of the key or, where there is none, of the section.
  [[nodiscard]] std::string place_of(const char* key) const;

  /// Runs `body`; an Error in it is told with the place of the key.
  void at(const char* key, const std::function<void()>& body) const;

  [[noreturn]] void fail_here(const std::string& what) const { fail(table_, what); }
  [[noreturn]] void fail_at(const char* key, const std::string& what) const;

  void require(const char* key) const {
    if (!table_.contains(key)) fail(table_, fmt::format("{} is missing here", called(key)));
  }

  /// Throws for the first key that nobody asked for, with the closest of those that were.
  void finish() const;

  [[noreturn]] void fail(const toml::node& node, const std::string& what) const;

 private:
  template <typename T>
  [[nodiscard]] T number_of(const toml::node& node, const std::string& name) const {
    const auto number = node.value<double>();
    if (!number) fail(node, fmt::format("{} must be a number", name));
    if constexpr (std::is_integral_v<T>) {
      if (!(*number >= static_cast<double>(std::numeric_limits<T>::min()) &&
            *number < static_cast<double>(std::numeric_limits<T>::max())))
        fail(node, fmt::format("{} is {}: out of range", name, *number));
      if (std::trunc(*number) != *number) fail(node, fmt::format("{} is {}: must be a whole number", name, *number));
    }
    return static_cast<T>(*number);
  }
  [[nodiscard]] std::string called(std::string_view key) const {
    return fmt::format("'{}{}{}'", name_, name_.empty() ? "" : ".", key);
  }
  [[nodiscard]] std::string place_of(const toml::node& node) const;

  const toml::table& table_;
  const std::filesystem::path& file_;
  std::string name_;
  std::set<std::string> used_;
};

}  // namespace orthodrive
