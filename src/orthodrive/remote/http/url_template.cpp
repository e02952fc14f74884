// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/remote/http/url_template.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>

#include "roadquery/text/text.hpp"

namespace orthodrive::remote {
namespace {
/// Calls text(part) for what stands outside {} and name(part, with braces) for what stands inside.
template <typename Text, typename Name>
void split(std::string_view pattern, const Text& text, const Name& name) {
  std::size_t at = 0;
  while (at < pattern.size()) {
    const std::size_t begin = pattern.find('{', at),
                      end = begin == std::string_view::npos ? begin : pattern.find('}', begin);
    if (end == std::string_view::npos) break;
    text(pattern.substr(at, begin - at));
    name(pattern.substr(begin + 1, end - begin - 1), pattern.substr(begin, end + 1 - begin));
    at = end + 1;
  }
  text(pattern.substr(std::min(at, pattern.size())));
}
}  // namespace

std::string percent_encoded(std::string_view text) {
  std::string result;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < 0x80 && (std::isalnum(byte) || c == '-' || c == '.' || c == '_' || c == '~'))
      result += c;
    else
      result += fmt::format("%{:02X}", byte);
  }
  return result;
}

std::vector<std::string> names_in(std::string_view pattern) {
  std::vector<std::string> names;
  split(
      pattern, [](std::string_view) {},
      [&](std::string_view name, std::string_view) {
        if (!name.starts_with("env:")) names.emplace_back(name);
      });
  return names;
}

std::string filled(std::string_view pattern, const std::map<std::string, std::string>& values) {
  std::string result;
  split(
      pattern, [&](std::string_view text) { result += text; },
      [&](std::string_view name, std::string_view whole) {
        const auto found = std::find_if(values.begin(), values.end(), [&](const auto& value) {
          return roadquery::lowered(value.first) == roadquery::lowered(name);
        });
        result += found == values.end() ? std::string(whole) : found->second;
      });
  return result;
}

std::string with_query(const std::string& url, const std::vector<std::pair<std::string, std::string>>& query) {
  const std::size_t mark = url.find('?');
  std::string result = url.substr(0, mark) + "?", kept = mark == std::string::npos ? "" : url.substr(mark + 1);
  std::size_t at = 0;
  while (at < kept.size()) {
    const std::size_t end = std::min(kept.find('&', at), kept.size());
    const std::string part = kept.substr(at, end - at), name = roadquery::lowered(part.substr(0, part.find('=')));
    at = end + 1;
    if (part.empty() || std::any_of(query.begin(), query.end(),
                                    [&](const auto& item) { return roadquery::lowered(item.first) == name; }))
      continue;
    result += (result.back() == '?' ? "" : "&") + part;
  }
  for (const auto& [name, value] : query)
    result += (result.back() == '?' ? "" : "&") + name + "=" + percent_encoded(value);
  return result;
}

std::string host_of(std::string_view url) {
  const std::size_t scheme = url.find("://");
  if (scheme == std::string_view::npos) return {};
  std::string_view rest = url.substr(scheme + 3);
  rest = rest.substr(0, rest.find_first_of("/?#"));
  if (const std::size_t login = rest.rfind('@'); login != std::string_view::npos) rest = rest.substr(login + 1);
  return roadquery::lowered(url.substr(0, scheme + 3)) + roadquery::lowered(rest);
}

bool is_http(std::string_view url) {
  const std::string start = roadquery::lowered(url.substr(0, 8));
  return start.starts_with("http://") || start.starts_with("https://");
}

}  // namespace orthodrive::remote
