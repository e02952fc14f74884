// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/remote/http/link_address.hpp"

#include <curl/curl.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <memory>

#include "orthodrive/remote/http/url_template.hpp"
#include "roadquery/text/text.hpp"

namespace orthodrive::remote {
namespace {
struct CloseUrl {
  void operator()(CURLU* url) const { curl_url_cleanup(url); }
};
constexpr std::size_t longest_address = 8000;

std::string login_of(const std::string& url) {
  const std::size_t scheme = url.find("://");
  if (scheme == std::string::npos) return {};
  const std::string authority = url.substr(scheme + 3, url.find_first_of("/?#", scheme + 3) - scheme - 3);
  const std::size_t at = authority.rfind('@');
  return at == std::string::npos ? "" : authority.substr(0, at + 1);
}

std::vector<std::pair<std::string, std::string>> query_of(const std::string& url) {
  std::vector<std::pair<std::string, std::string>> parts;
  const std::size_t mark = url.find('?');
  for (std::size_t at = mark == std::string::npos ? url.size() : mark + 1; at < url.size();) {
    const std::size_t end = std::min(url.find_first_of("&#", at), url.size());
    const std::string part = url.substr(at, end - at);
    const std::size_t equals = part.find('=');
    if (!part.empty())
      parts.emplace_back(part.substr(0, equals), equals == std::string::npos ? "" : part.substr(equals + 1));
    at = end + 1;
  }
  return parts;
}
}  // namespace

std::string absolute_address(const std::string& page, const std::string& link) {
  const std::string trimmed(roadquery::trimmed(link));
  if (trimmed.empty() || trimmed.size() > longest_address || trimmed.find('\0') != std::string::npos) return {};
  const std::unique_ptr<CURLU, CloseUrl> url(curl_url());
  const bool plain = std::all_of(trimmed.begin(), trimmed.end(), [](unsigned char c) { return c > 0x20 && c < 0x7f; });
  const unsigned flags = CURLU_NON_SUPPORT_SCHEME | (plain ? 0U : CURLU_URLENCODE);
  if (!url || (!page.empty() && curl_url_set(url.get(), CURLUPART_URL, page.c_str(), 0) != CURLUE_OK) ||
      curl_url_set(url.get(), CURLUPART_URL, trimmed.c_str(), flags) != CURLUE_OK)
    return {};
  curl_url_set(url.get(), CURLUPART_FRAGMENT, nullptr, 0);
  char* text = nullptr;
  if (curl_url_get(url.get(), CURLUPART_URL, &text, 0) != CURLUE_OK) return {};
  std::string result(text);
  curl_free(text);
  return is_http(result) && result.size() <= longest_address ? result : std::string();
}

bool names_sheet(std::string_view address) {
  static constexpr std::array suffixes{".tif", ".tiff", ".jp2", ".j2k", ".zip", ".img",
                                       ".asc", ".xyz",  ".ecw", ".sid", ".hgt", ".dem"};
  const std::string lowered = roadquery::lowered(address);
  for (const std::string_view suffix : suffixes)
    for (std::size_t at = lowered.find(suffix); at != std::string::npos; at = lowered.find(suffix, at + 1)) {
      const std::size_t end = at + suffix.size();
      if (end == lowered.size() || lowered[end] == '?' || lowered[end] == '&' || lowered[end] == '#') return true;
    }
  return false;
}

LinkKeys::LinkKeys(const std::string& pattern, const std::string& resolved)
    : host_(host_of(resolved)), login_(login_of(resolved)) {
  const auto patterns = query_of(pattern), values = query_of(resolved);
  for (std::size_t i = 0; i < std::min(patterns.size(), values.size()); ++i)
    if (patterns[i].second.find("{env:") != std::string::npos) query_.push_back(values[i]);
}

std::string LinkKeys::with(const std::string& link) const {
  if (host_of(link) != host_) return link;
  std::string result = link;
  if (!login_.empty() && login_of(link).empty()) result.insert(result.find("://") + 3, login_);
  const auto there = query_of(result);
  for (const auto& [name, value] : query_)
    if (std::none_of(there.begin(), there.end(),
                     [&](const auto& part) { return roadquery::lowered(part.first) == roadquery::lowered(name); }))
      result += (result.find('?') == std::string::npos ? "?" : "&") + name + "=" + value;
  return result;
}

}  // namespace orthodrive::remote
