// SPDX-License-Identifier: Apache-2.0
// One large file, resumed (RFC 9110: Range with If-Range) and refreshed (If-None-Match, If-Modified-Since).
#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <ctime>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include <thread>
#include <vector>

#include "orthodrive/core/atomic_file.hpp"
#include "orthodrive/core/error.hpp"
#include "orthodrive/core/hash.hpp"
#include "orthodrive/remote/http/http_state.hpp"
#include "orthodrive/remote/http/http_transfer.hpp"

namespace orthodrive::remote {
namespace {
namespace fs = std::filesystem;
using nlohmann::json;

fs::path beside(const fs::path& file, const char* suffix) {
  fs::path path = file;
  path += suffix;
  return path;
}

/// Which version of which file lies there.
struct Version {
  std::string url_hash, etag, last_modified;
  /// What If-Range may hold: a weak tag says nothing of bytes.
  [[nodiscard]] std::string validator() const {
    return !etag.empty() && !etag.starts_with("W/") ? etag : last_modified;
  }
};

Version read_version(const fs::path& file) {
  std::ifstream in(file);
  const json found = json::parse(in, nullptr, false);
  Version version;
  if (!found.is_object()) return version;
  const auto text = [&](const char* key) {
    const auto at = found.find(key);
    return at != found.end() && at->is_string() ? at->get<std::string>() : std::string();
  };
  return {text("url_hash"), text("etag"), text("last_modified")};
}

void write_version(const fs::path& file, const Version& version) {
  write_text_file(
      file,
      json{{"url_hash", version.url_hash}, {"etag", version.etag}, {"last_modified", version.last_modified}}.dump() +
          "\n");
}

struct FileTransfer {
  CURL* easy = nullptr;
  Monitor* monitor = nullptr;
  fs::path part;
  Version version;  ///< of the part
  std::int64_t offset = 0;
  ResponseHeaders response;
  std::ofstream out;
  std::int64_t most_bytes = 0, written = 0;
  bool begun = false, disk_failed = false, no_room = false, too_large = false;
  std::string what;
  char detail[CURL_ERROR_SIZE] = {};
};

/// The first bytes of an answer: it goes on with the part, or it is the whole file anew.
bool begin(FileTransfer& t) {
  t.begun = true;
  long status = 0;
  curl_easy_getinfo(t.easy, CURLINFO_RESPONSE_CODE, &status);
  if (status != 200 && status != 206) return true;  // a page about an error: not kept
  const bool goes_on = status == 206 && t.response.content_range.starts_with(fmt::format("bytes {}-", t.offset));
  if (status == 206 && !goes_on) return false;
  if (!goes_on) {
    t.offset = 0;
    t.version.etag = t.response.etag, t.version.last_modified = t.response.last_modified;
    write_version(beside(t.part, ".json"), t.version);
  }
  curl_off_t length = -1;
  curl_easy_getinfo(t.easy, CURLINFO_CONTENT_LENGTH_DOWNLOAD_T, &length);
  std::error_code ignored;
  const fs::space_info space = fs::space(t.part.parent_path(), ignored);
  if (!ignored && length > 0 && static_cast<std::uintmax_t>(length) > space.available) {
    t.no_room = true;
    return false;
  }
  t.out.open(t.part, goes_on ? std::ios::binary | std::ios::app : std::ios::binary | std::ios::trunc);
  return static_cast<bool>(t.out);
}

std::size_t write_file(char* data, std::size_t size, std::size_t count, void* user) {
  auto& t = *static_cast<FileTransfer*>(user);
  try {
    if (!t.begun && !begin(t)) {
      t.disk_failed = !t.out.is_open() && !t.no_room && t.offset == 0;
      return 0;
    }
  } catch (const std::exception&) {  // through C code no exception may pass
    t.disk_failed = true;
    return 0;
  }
  if (!t.out.is_open()) return size * count;
  t.written += static_cast<std::int64_t>(size * count);
  t.too_large = t.offset + t.written > t.most_bytes;
  if (t.too_large) return 0;
  t.out.write(data, static_cast<std::streamsize>(size * count));
  t.disk_failed = !t.out;
  return t.out ? size * count : 0;
}

std::size_t read_header(char* data, std::size_t size, std::size_t count, void* user) {
  auto& t = *static_cast<FileTransfer*>(user);
  const std::string_view line(data, size * count);
  if (line.starts_with("HTTP/")) t.begun = false;
  t.response.add(line);
  return size * count;
}

int report(void* user, curl_off_t total, curl_off_t done, curl_off_t, curl_off_t) {
  auto& t = *static_cast<FileTransfer*>(user);
  if (!t.monitor) return 0;
  if (total > 0)
    t.monitor->progress(static_cast<double>(t.offset + done) / static_cast<double>(t.offset + total), t.what);
  return t.monitor->cancelled() ? 1 : 0;
}

std::int64_t size_of(const fs::path& file) {
  std::error_code missing;
  const auto size = fs::file_size(file, missing);
  return missing ? 0 : static_cast<std::int64_t>(size);
}
struct Attempt {
  Verdict verdict;
  Version version;  ///< of the part, after it
  std::int64_t offset = 0;
  long status = 0;
  bool progressed = false, complete = false;
  std::optional<double> asked_pause_s;  ///< by Retry-After
};

/// The places and the request of one download.
struct Download {
  const std::string& url;
  const HttpClient::State& state;
  fs::path to, part;
  std::string url_hash;
  std::optional<Version> there;  ///< of the file that is to be refreshed
  std::int64_t most_bytes = 0;
};

void set_up(FileTransfer& t, const Download& d) {
  prepare(t.easy, d.state.options);
  curl_easy_setopt(t.easy, CURLOPT_ACCEPT_ENCODING, nullptr);  // ranges count the file's own bytes
  curl_easy_setopt(t.easy, CURLOPT_URL, d.url.c_str());
  curl_easy_setopt(t.easy, CURLOPT_WRITEFUNCTION, write_file);
  curl_easy_setopt(t.easy, CURLOPT_WRITEDATA, &t);
  curl_easy_setopt(t.easy, CURLOPT_HEADERFUNCTION, read_header);
  curl_easy_setopt(t.easy, CURLOPT_HEADERDATA, &t);
  curl_easy_setopt(t.easy, CURLOPT_NOPROGRESS, 0L);
  curl_easy_setopt(t.easy, CURLOPT_XFERINFOFUNCTION, report);
  curl_easy_setopt(t.easy, CURLOPT_XFERINFODATA, &t);
  curl_easy_setopt(t.easy, CURLOPT_ERRORBUFFER, t.detail);
}

std::vector<std::string> conditions(const FileTransfer& t, const Download& d) {
  std::vector<std::string> lines;
  if (t.offset > 0) {
    lines.push_back(fmt::format("Range: bytes={}-", t.offset));
    lines.push_back("If-Range: " + t.version.validator());
  } else if (d.there) {
    if (!d.there->etag.empty()) lines.push_back("If-None-Match: " + d.there->etag);
    if (!d.there->last_modified.empty()) lines.push_back("If-Modified-Since: " + d.there->last_modified);
  }
  return lines;
}

void stop_if_cancelled(const Monitor* monitor) {
  if (monitor && monitor->cancelled()) throw Error("cancelled; run it again to go on");
}

Attempt attempt_once(const Download& d) {
  FileTransfer t;
  const EasyPtr easy(curl_easy_init());
  t.easy = easy.get(), t.monitor = d.state.monitor, t.part = d.part, t.what = d.to.filename().string();
  t.version = read_version(beside(d.part, ".json")), t.most_bytes = d.most_bytes;
  if (t.version.url_hash == d.url_hash && !t.version.validator().empty()) t.offset = size_of(d.part);
  t.version.url_hash = d.url_hash;
  const std::int64_t offset = t.offset;
  set_up(t, d);
  const HeaderList headers = header_list(conditions(t, d));
  curl_easy_setopt(t.easy, CURLOPT_HTTPHEADER, headers.get());
  const CURLcode code = curl_easy_perform(t.easy);
  t.out.close();
  stop_if_cancelled(d.state.monitor);
  if (t.no_room || t.disk_failed)
    throw Error(fmt::format("{}: cannot be written; is the disk full or the folder read-only?", d.to.string()));
  if (t.too_large) {
    std::error_code ignored;
    fs::remove(d.part, ignored), fs::remove(beside(d.part, ".json"), ignored);
    throw Error(fmt::format("{}: the file has more than {:.0f} GB, which is not fetched", d.state.shown(d.url),
                            static_cast<double>(d.most_bytes) / 1e9));
  }
  Attempt attempt;
  curl_easy_getinfo(t.easy, CURLINFO_RESPONSE_CODE, &attempt.status);
  attempt.verdict = judge(code, attempt.status, t.detail);
  if (attempt.verdict.judgement == Judgement::good && attempt.status == 200 && !t.begun) {
    t.offset = 0;  // an empty file: nothing was written, and what an earlier attempt left is of another one
    std::ofstream(d.part, std::ios::binary | std::ios::trunc).close();
  }
  attempt.version = t.version, attempt.offset = t.offset;
  attempt.complete = attempt.verdict.judgement == Judgement::good && (t.begun || attempt.status == 200);
  attempt.progressed = t.offset == offset && size_of(d.part) > offset;
  attempt.asked_pause_s = retry_after_s(t.response.retry_after, std::time(nullptr));
  // The part is longer than the file, or the server sent another range.
  if (attempt.status == 416 || (attempt.status == 206 && code == CURLE_WRITE_ERROR)) {
    std::error_code ignored;
    fs::remove(d.part, ignored), fs::remove(beside(d.part, ".json"), ignored);
    attempt.verdict.judgement = Judgement::again;
  }
  return attempt;
}

void wait(double seconds, const Monitor* monitor) {
  for (double waited = 0.0; waited < seconds; waited += 0.1) {
    stop_if_cancelled(monitor);
    std::this_thread::sleep_for(std::chrono::duration<double>(std::min(0.1, seconds - waited)));
  }
}

/// Attempts until the part is the file, or the server has nothing newer. One that brought something does not count: a
/// long file over a bad line.
Attempt attempt_all(const Download& d) {
  const HttpOptions& options = d.state.options;
  for (int number = 1;; ++number) {
    Attempt attempt = attempt_once(d);
    if (attempt.complete || attempt.verdict.judgement == Judgement::same) return attempt;
    if (attempt.progressed) number = 1;
    const std::string what = fmt::format("{}: {}", d.state.shown(d.url), d.state.shown(attempt.verdict.why));
    const int most = size_of(d.part) > 0 ? options.attempts : std::min(options.attempts, 4);
    if (attempt.verdict.judgement == Judgement::missing) throw NotThere(what + " (not there); check the url");
    if (attempt.verdict.judgement != Judgement::again || number >= most) throw Error(what + "; run it again to go on");
    const double asked_s = attempt.asked_pause_s.value_or(0.0);
    if (asked_s > longest_wait_s)
      throw Error(fmt::format("{}; the server asks to come again in {:.0f} minutes", what, asked_s / 60.0));
    wait(std::max(pause_before(number + 1, options), asked_s), d.state.monitor);
  }
}
}  // namespace

HttpFile HttpClient::download(const std::string& url, const fs::path& to, bool refresh, std::int64_t most_bytes) {
  start_curl();
  Download d{url, *state_, to, beside(to, ".part"), hash_bytes(state_->shown(url)), {}, most_bytes};
  const Version there = read_version(beside(to, ".json"));
  if (fs::exists(to) && there.url_hash == d.url_hash) {
    if (!refresh) return {there.etag, there.last_modified, size_of(to), 0, true};
    d.there = there;
  }
  std::error_code failed;
  fs::create_directories(to.parent_path(), failed);
  if (failed) throw Error(fmt::format("{}: cannot be created ({})", to.parent_path().string(), failed.message()));
  const Attempt last = attempt_all(d);
  if (last.verdict.judgement == Judgement::same) return {there.etag, there.last_modified, size_of(to), 0, true};
  fs::rename(d.part, to, failed);
  if (failed) throw Error(fmt::format("{}: cannot be written ({})", to.string(), failed.message()));
  write_version(beside(to, ".json"), last.version);  // after it: killed in between, it is asked again
  fs::remove(beside(d.part, ".json"), failed);
  return {last.version.etag, last.version.last_modified, size_of(to), last.offset, false};
}

}  // namespace orthodrive::remote
