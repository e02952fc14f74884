// SPDX-License-Identifier: Apache-2.0
#pragma once
// The attributes of one element of an OpenDRIVE file, checked as they are read.

#include <cmath>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>

#include "roadquery/text/number_text.hpp"
#include "roadquery/text/text.hpp"

namespace roadquery {

/// The part of a name behind its namespace's prefix.
[[nodiscard]] constexpr std::string_view local_name(std::string_view name) {
  const std::size_t colon = name.rfind(':');
  return colon == std::string_view::npos ? name : name.substr(colon + 1);
}

/// Attributes are known by their name, or by what is behind its prefix. What is missing or no number throws
/// std::runtime_error.
class Attributes {
 public:
  /// `pairs`: name, value, name, value, ..., nullptr.
  Attributes(std::string_view element, const char** pairs) : element_(element), pairs_(pairs) {}

  [[nodiscard]] const char** pairs() const { return pairs_; }
  [[nodiscard]] const char* find(std::string_view name) const {
    for (const char** pair = pairs_; *pair != nullptr; pair += 2)
      if (name == pair[0]) return pair[1];
    for (const char** pair = pairs_; *pair != nullptr; pair += 2)
      if (name == local_name(pair[0]) && !std::string_view(pair[0]).starts_with("xml")) return pair[1];
    return nullptr;
  }
  [[nodiscard]] std::string text(std::string_view name) const {
    const char* value = find(name);
    return value != nullptr ? value : "";
  }
  [[nodiscard]] bool flag(std::string_view name) const {
    const std::string value = text(name);
    return value == "true" || value == "1";
  }
  [[nodiscard]] std::string_view required(std::string_view name) const {
    const char* value = find(name);
    if (value == nullptr) throw std::runtime_error("<" + element_ + "> lacks the attribute " + std::string(name));
    return value;
  }
  [[nodiscard]] double number(std::string_view name) const { return parse<double>(name, required(name)); }
  [[nodiscard]] double number(std::string_view name, double fallback) const {
    const char* value = find(name);
    return value != nullptr ? parse<double>(name, value) : fallback;
  }
  [[nodiscard]] int integer(std::string_view name) const { return parse<int>(name, required(name)); }

  /// As XML Schema writes numbers: blanks around it, a plus before it. Nothing for what is none.
  template <typename T>
  [[nodiscard]] static std::optional<T> number_of(std::string_view value) {
    value = trimmed(value, " \t\r\n");
    if (value.starts_with('+')) value.remove_prefix(1);
    T result{};
    const auto [end, error] = number_from_text(value, result);
    bool good = error == std::errc{} && end == value.data() + value.size();
    if constexpr (std::is_floating_point_v<T>) good = good && std::isfinite(result);
    return good ? std::optional(result) : std::nullopt;
  }
  template <typename T>
  [[nodiscard]] T parse(std::string_view name, std::string_view value) const {
    if (const auto number = number_of<T>(value)) return *number;
    throw std::runtime_error("<" + element_ + "> has " + std::string(name) + "=\"" +
                             std::string(trimmed(value, " \t\r\n")) + "\", which is not " +
                             (std::is_integral_v<T> ? "an integer" : "a number"));
  }

 private:
  std::string element_;
  const char** pairs_;
};

}  // namespace roadquery
