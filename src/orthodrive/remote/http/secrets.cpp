// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/remote/http/secrets.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <regex>

#include "orthodrive/core/error.hpp"
#include "orthodrive/remote/http/url_template.hpp"

namespace orthodrive::remote {

std::string Secrets::resolve(const std::string& text) {
  constexpr std::string_view mark = "{env:";
  std::string result;
  std::size_t at = 0;
  for (std::size_t begin = text.find(mark); begin != std::string::npos; begin = text.find(mark, at)) {
    const std::size_t end = text.find('}', begin);
    if (end == std::string::npos) break;
    const std::string whole = text.substr(begin, end + 1 - begin);
    const std::string name = text.substr(begin + mark.size(), end - begin - mark.size());
    const char* value = std::getenv(name.c_str());
    if (!value || !*value)
      throw OptionError(fmt::format(
          "the environment variable {} is not set; it holds the key of the service: export {}=...", name, name));
    const std::string encoded = percent_encoded(value);
    for (const std::string& form : {encoded, std::string(value)})
      if (std::none_of(values_.begin(), values_.end(), [&](const auto& known) { return known.first == form; }))
        values_.emplace_back(form, whole);
    result += text.substr(at, begin - at) + encoded;
    at = end + 1;
  }
  std::stable_sort(values_.begin(), values_.end(),
                   [](const auto& a, const auto& b) { return a.first.size() > b.first.size(); });
  return result + text.substr(at);
}

std::string Secrets::hide(std::string text) const {
  for (const auto& [value, name] : values_)
    for (std::size_t at = text.find(value); at != std::string::npos; at = text.find(value, at + name.size()))
      text.replace(at, value.size(), name);
  static const std::regex login("(://)[^/@\\s]*@");
  static const std::regex key(
      "([?&;][a-z_-]*(?:key|token|secret|password|passwd|signature|sig|auth)=)(?!\\{env:)[^&;\\s]*", std::regex::icase);
  if (text.find("://") == std::string::npos && text.find('=') == std::string::npos) return text;
  text = std::regex_replace(text, login, "$1");
  return std::regex_replace(text, key, "$1***");
}

}  // namespace orthodrive::remote
