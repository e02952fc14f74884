#pragma once
// Reading tables of a TOML file with the line of whatever is wrong. For .cpp files of this folder only.

#include <fmt/format.h>
#include <toml++/toml.h>

#include <filesystem>
#include <set>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "orthodrive/core/error.hpp"
#include "orthodrive/geo/vec.hpp"

namespace orthodrive {

[[nodiscard]] inline toml::table parse_toml(std::string_view text, const std::filesystem::path& file) {
  try {
    return toml::parse(text);
  } catch (const toml::parse_error& error) {
    throw InputError(fmt::format("{}:{}", file.string(), error.source().begin.line), std::string(error.description()));
  }
}

/// One table of the file: hands out its values and knows which keys nobody asked for.
class TomlSection {
 public:
  TomlSection(const toml::table& table, const std::filesystem::path& file) : table_(table), file_(file) {}

  template <typename T>
  void read(const char* key, T& value) {
    const toml::node* node = find(key);
    if (!node) return;
    if constexpr (std::is_same_v<T, std::filesystem::path>) {
      const auto text = node->value<std::string>();
      if (!text) fail(*node, fmt::format("'{}' must be a path", key));
      value = file_.parent_path() / *text;
    } else if constexpr (std::is_arithmetic_v<T> && !std::is_same_v<T, bool>) {
      const auto number = node->value<double>();
      if (!number) fail(*node, fmt::format("'{}' must be a number", key));
      value = static_cast<T>(*number);
    } else {
      const auto found = node->value<T>();
      if (!found) fail(*node, fmt::format("'{}' has the wrong type", key));
      value = *found;
    }
  }

  template <typename T>
  void read(const char* key, std::vector<T>& values) {
    const toml::node* node = find(key);
    if (!node) return;
    if (!node->is_array()) fail(*node, fmt::format("'{}' must be a list", key));
    values.clear();
    for (const toml::node& entry : *node->as_array()) {
      const auto value = entry.value<T>();
      if (!value) fail(entry, fmt::format("'{}' has an entry of the wrong type", key));
      values.push_back(*value);
    }
  }

  /// west, south, east, north
  template <typename Take>
  void read_box(const char* key, const Take& take) {
    std::vector<double> box;
    read(key, box);
    if (!table_.contains(key)) return;
    if (box.size() != 4) fail(*table_.get(key), fmt::format("'{}' must be [west, south, east, north]", key));
    take(Box2{box[0], box[1], box[2], box[3]});
  }

  template <typename Visit>
  void for_each_table(const char* key, const Visit& visit) {
    const toml::node* node = find(key);
    if (!node) return;
    if (!node->is_array_of_tables()) fail(*node, fmt::format("'{}' must be a list of tables", key));
    for (const toml::node& entry : *node->as_array()) {
      TomlSection section(*entry.as_table(), file_);
      visit(section);
      section.finish();
    }
  }

  const toml::table* find_table(const char* key) {
    const toml::node* node = find(key);
    if (node && !node->is_table()) fail(*node, fmt::format("'{}' must be a table", key));
    return node ? node->as_table() : nullptr;
  }

  [[noreturn]] void fail_here(const std::string& what) const { fail(table_, what); }

  void require(const char* key) const {
    if (!table_.contains(key)) fail(table_, fmt::format("'{}' is missing here", key));
  }

  void finish() const {
    for (const auto& [key, node] : table_) {
      if (!used_.contains(std::string(key.str()))) fail(node, fmt::format("'{}' is not known here", key.str()));
    }
  }

  [[noreturn]] void fail(const toml::node& node, const std::string& what) const {
    throw InputError(fmt::format("{}:{}", file_.string(), node.source().begin.line), what);
  }

 private:
  const toml::node* find(const char* key) {
    used_.insert(key);
    return table_.get(key);
  }

  const toml::table& table_;
  const std::filesystem::path& file_;
  std::set<std::string> used_;
};

}  // namespace orthodrive
