// SPDX-License-Identifier: Apache-2.0
#pragma once
// One transfer of libcurl: what both ways of HttpClient share. Internal to remote.

#include <curl/curl.h>

#include <memory>
#include <string>

#include "orthodrive/remote/http/http_client.hpp"

namespace orthodrive::remote {

struct CloseEasy {
  void operator()(CURL* easy) const { curl_easy_cleanup(easy); }
};
using EasyPtr = std::unique_ptr<CURL, CloseEasy>;
struct FreeList {
  void operator()(curl_slist* list) const { curl_slist_free_all(list); }
};
using HeaderList = std::unique_ptr<curl_slist, FreeList>;

/// What the last response of a transfer (after redirects) says in its headers.
struct ResponseHeaders {
  std::string content_type, etag, last_modified, retry_after, content_range;
  void add(std::string_view line);  ///< a status line begins anew
};

enum class Judgement {
  good,     ///< 200
  same,     ///< 304
  missing,  ///< 404, 410, 204
  again,    ///< may go away: 408, 425, 429, 5xx, a cut or stalled connection
  never     ///< another 4xx, too large, not HTTP
};
struct Verdict {
  Judgement judgement = Judgement::good;
  std::string why;
};
[[nodiscard]] Verdict judge(CURLcode result, long status, const char* detail);

/// Everything that is the same for all transfers: limits, redirects, User-Agent, no signals.
void prepare(CURL* easy, const HttpOptions& options);
[[nodiscard]] HeaderList header_list(const std::vector<std::string>& lines);
/// Starts libcurl once.
void start_curl();

}  // namespace orthodrive::remote
