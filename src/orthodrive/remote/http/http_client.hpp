// SPDX-License-Identifier: Apache-2.0
#pragma once
// Many small answers over few connections (libcurl), and one large one into a file. Polite: bounded connections, a
// fixed schedule of pauses that doubles, and Retry-After is obeyed for the whole host.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "orthodrive/core/error.hpp"
#include "orthodrive/core/monitor.hpp"
#include "orthodrive/remote/http/secrets.hpp"

namespace orthodrive::remote {

constexpr double longest_wait_s = 600.0;  ///< a Retry-After beyond this ends the work

struct HttpOptions {
  int connections = 6;         ///< to one host, and in all
  int attempts = 8;            ///< of one request; 4 as long as nothing at all has succeeded
  double first_pause_s = 0.5;  ///< before the second attempt; each further one is twice as long
  double longest_pause_s = 60.0;
  double stall_s = 30.0;                             ///< no byte for so long ends an attempt
  std::int64_t most_bytes = std::int64_t{64} << 20;  ///< of one answer in memory, decompressed
};

struct HttpRequest {
  std::size_t id = 0;
  std::string url;                  ///< with its keys
  std::string etag, last_modified;  ///< of what is there already: 304 when it has not changed
  std::string post;                 ///< a body; empty: GET
  std::string post_type;            ///< of the body; empty: that of a form
};

/// Status 200, 304, or 404 (also for 204 and 410): nothing there.
struct HttpReply {
  std::size_t id = 0;
  int status = 0;
  std::string body, content_type, etag, last_modified;
};

struct HttpFailure {
  std::size_t id = 0;
  std::string what;  ///< keys are hidden
  int status = 0;    ///< of the last answer; 0: none came
};

struct HttpWork {
  std::function<std::optional<HttpRequest>()> next;
  /// Empty for a good answer, else what is wrong with it: it is asked again. Not called for 304 and 404.
  std::function<std::string(const HttpReply&)> check;
  std::function<void(HttpReply&&)> take;
  std::function<void(HttpFailure&&)> fail;  ///< after the last attempt
  std::function<void()> idle;               ///< between answers, some ten times a second at least
};

struct HttpCounts {
  std::int64_t requests = 0, retries = 0, bytes = 0;
};

/// The server says that it has no such file (404, 410).
struct NotThere : Error {
  using Error::Error;
};

struct HttpFile {
  std::string etag, last_modified;
  std::int64_t bytes = 0, resumed_at = 0;
  bool unchanged = false;  ///< the file that was there is still the server's
};

/// One thread at a time.
class HttpClient {
 public:
  HttpClient(HttpOptions options, const Secrets& secrets, Monitor* monitor);
  ~HttpClient();
  HttpClient(const HttpClient&) = delete;
  HttpClient& operator=(const HttpClient&) = delete;

  /// Until `next` has no more and all are done. Throws Error when the monitor is cancelled, when nothing succeeds at
  /// all (the server is away, says no or answers something else), and when Retry-After is too long.
  HttpCounts run(const HttpWork& work);

  /// One answer in memory. Throws Error naming the address (keys hidden).
  [[nodiscard]] HttpReply get(const HttpRequest& request,
                              const std::function<std::string(const HttpReply&)>& check = {});

  /// A large file: goes on where an earlier, killed download of the same version stopped (FILE.part and
  /// FILE.part.json), and asks only for news where the file is there (FILE.json holds its version). Throws Error, and
  /// for a file of more than `most_bytes`; NotThere for one that the server does not have.
  HttpFile download(const std::string& url, const std::filesystem::path& to, bool refresh,
                    std::int64_t most_bytes = std::int64_t{1} << 40);

  struct State;  ///< for the .cpp files of remote

 private:
  std::unique_ptr<State> state_;
};

/// Seconds that a Retry-After header asks for: a number, or a date after `now` (seconds since 1970). None for what is
/// neither.
[[nodiscard]] std::optional<double> retry_after_s(const std::string& header, std::int64_t now);
/// Before attempt `attempt` (2, 3, ...): the first pause, doubled each time up to the longest. No chance in it.
[[nodiscard]] double pause_before(int attempt, const HttpOptions& options);

}  // namespace orthodrive::remote
