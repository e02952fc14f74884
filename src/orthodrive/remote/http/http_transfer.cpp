// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/remote/http/http_transfer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <mutex>

#include "orthodrive/core/error.hpp"
#include "orthodrive/core/printable.hpp"
#include "roadquery/text/text.hpp"

namespace orthodrive::remote {

void start_curl() {
  static std::once_flag once;
  std::call_once(once, [] { curl_global_init(CURL_GLOBAL_DEFAULT); });
}

void ResponseHeaders::add(std::string_view line) {
  while (!line.empty() && (line.back() == '\r' || line.back() == '\n' || line.back() == ' ')) line.remove_suffix(1);
  if (line.starts_with("HTTP/")) {
    *this = {};
    return;
  }
  const std::size_t colon = line.find(':');
  if (colon == std::string_view::npos || line.size() > 4000) return;
  const std::string name = roadquery::lowered(line.substr(0, colon));
  std::string_view value = line.substr(colon + 1);
  while (!value.empty() && value.front() == ' ') value.remove_prefix(1);
  const auto keep = [&](const char* wanted, std::string& into) {
    if (name == wanted) into = printable(std::string(value));
  };
  keep("content-type", content_type), keep("etag", etag), keep("last-modified", last_modified);
  keep("retry-after", retry_after), keep("content-range", content_range);
}

namespace {
const char* meaning_of(long status) {
  switch (status) {
    case 400:
      return " (bad request)";
    case 401:
      return " (not authorised: is the key right?)";
    case 403:
      return " (forbidden: is the key right, may this address ask?)";
    case 429:
      return " (too many requests)";
    case 503:
      return " (not available now)";
    case 504:
      return " (the server was too slow)";
    default:
      return "";
  }
}
}  // namespace

Verdict judge(CURLcode result, long status, const char* detail) {
  if (result != CURLE_OK) {
    const std::string why = printable(detail && *detail ? detail : curl_easy_strerror(result));
    switch (result) {
      case CURLE_FILESIZE_EXCEEDED:
      case CURLE_UNSUPPORTED_PROTOCOL:
      case CURLE_URL_MALFORMAT:
      case CURLE_PEER_FAILED_VERIFICATION:
      case CURLE_SSL_CACERT_BADFILE:
        return {Judgement::never, why};
      default:
        return {Judgement::again, why};
    }
  }
  if (status == 200 || status == 206) return {Judgement::good, ""};
  if (status == 304) return {Judgement::same, ""};
  if (status == 404 || status == 410 || status == 204) return {Judgement::missing, fmt::format("HTTP {}", status)};
  const bool again = status == 408 || status == 425 || status == 429 || status >= 500;
  return {again ? Judgement::again : Judgement::never, fmt::format("HTTP {}{}", status, meaning_of(status))};
}

void prepare(CURL* easy, const HttpOptions& options) {
  curl_easy_setopt(easy, CURLOPT_USERAGENT, "orthodrive (map data for an area, asked once and kept)");
  curl_easy_setopt(easy, CURLOPT_NOSIGNAL, 1L);
  curl_easy_setopt(easy, CURLOPT_PROTOCOLS_STR, "http,https");
  curl_easy_setopt(easy, CURLOPT_REDIR_PROTOCOLS_STR, "http,https");
  curl_easy_setopt(easy, CURLOPT_FOLLOWLOCATION, 1L);
  curl_easy_setopt(easy, CURLOPT_MAXREDIRS, 5L);
  curl_easy_setopt(easy, CURLOPT_CONNECTTIMEOUT_MS, 15000L);
  curl_easy_setopt(easy, CURLOPT_LOW_SPEED_LIMIT, 1L);
  curl_easy_setopt(easy, CURLOPT_LOW_SPEED_TIME, std::max(1L, std::lround(options.stall_s)));
  curl_easy_setopt(easy, CURLOPT_ACCEPT_ENCODING, "");
}

HeaderList header_list(const std::vector<std::string>& lines) {
  curl_slist* list = nullptr;
  for (const std::string& line : lines) list = curl_slist_append(list, line.c_str());
  return HeaderList(list);
}

std::optional<double> retry_after_s(const std::string& header, std::int64_t now) {
  if (header.empty()) return std::nullopt;
  if (std::all_of(header.begin(), header.end(), [](unsigned char c) { return std::isdigit(c); }))
    return header.size() > 9 ? 1e9 : std::strtod(header.c_str(), nullptr);
  const time_t date = curl_getdate(header.c_str(), nullptr);
  if (date < 0) return std::nullopt;
  return std::max(0.0, static_cast<double>(date) - static_cast<double>(now));
}

double pause_before(int attempt, const HttpOptions& options) {
  return std::min(options.longest_pause_s, std::ldexp(options.first_pause_s, std::min(attempt - 2, 60)));
}

}  // namespace orthodrive::remote
