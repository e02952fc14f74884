// SPDX-License-Identifier: Apache-2.0
#pragma once
// A source on a server becomes a local file.

#include <cstdint>
#include <string>

#include "orthodrive/core/finding.hpp"
#include "orthodrive/core/monitor.hpp"
#include "orthodrive/model/site_frame.hpp"
#include "orthodrive/remote/http/http_client.hpp"
#include "orthodrive/remote/source/fetch_source.hpp"

namespace orthodrive::remote {

struct FetchOptions {
  HttpOptions http;
  bool refresh = false;  ///< ask for news of what is there
  bool dry_run = false;  ///< say how much it is, fetch nothing
};

struct FetchOutcome {
  bool taken_over = false;  ///< nothing was asked: all is there
  std::int64_t tiles = 0;   ///< of the area
  std::int64_t requests = 0, retries = 0, bytes = 0;
  std::int64_t missing = 0;    ///< tiles that the server does not have
  std::int64_t unchanged = 0;  ///< tiles that the server says have not changed
  std::string summary;         ///< one line
};

/// Fetches one source. Goes on where an earlier, killed run stopped; the file takes its place when it is complete, with
/// FILE.source.json beside it. Throws InputError, OptionError or Error with one line that says what to do; keys out of
/// the environment are in no message and no file.
FetchOutcome fetch(const FetchSource& source, const SiteFrame& site, const FetchOptions& options,
                   Monitor* monitor = nullptr);

}  // namespace orthodrive::remote
