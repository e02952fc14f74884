// SPDX-License-Identifier: Apache-2.0
// Based on libcurl's multi interface: one thread, so that nothing here needs a lock.
#include "orthodrive/remote/http/http_client.hpp"

#include <fmt/format.h>

#include <chrono>
#include <ctime>
#include <map>
#include <vector>

#include "orthodrive/core/error.hpp"
#include "orthodrive/core/stop.hpp"
#include "orthodrive/remote/http/http_state.hpp"
#include "orthodrive/remote/http/http_transfer.hpp"

namespace orthodrive::remote {
namespace {
using Clock = std::chrono::steady_clock;  // the wall's clock may jump
using Time = Clock::time_point;

Time after(double seconds) { return Clock::now() + std::chrono::microseconds(std::llround(seconds * 1e6)); }

struct Transfer {
  HttpRequest request;
  int attempt = 1;
  bool was_missing = false;  ///< the server has said so once
  EasyPtr easy;
  HeaderList headers;
  ResponseHeaders response;
  std::string body;
  std::int64_t most_bytes = 0;
  bool too_large = false;
  char detail[CURL_ERROR_SIZE] = {};
};
using TransferPtr = std::unique_ptr<Transfer>;

std::size_t keep_body(char* data, std::size_t size, std::size_t count, void* user) {
  auto& transfer = *static_cast<Transfer*>(user);
  if (static_cast<std::int64_t>(transfer.body.size() + size * count) > transfer.most_bytes) {
    transfer.too_large = true;
    return 0;
  }
  transfer.body.append(data, size * count);
  return size * count;
}

std::size_t keep_header(char* data, std::size_t size, std::size_t count, void* user) {
  auto& transfer = *static_cast<Transfer*>(user);
  const std::string_view line(data, size * count);
  if (line.starts_with("HTTP/")) transfer.body.clear();  // a redirect may have had a body
  transfer.response.add(line);
  return size * count;
}

void set_up(Transfer& t, const HttpOptions& options) {
  if (!t.easy) t.easy.reset(curl_easy_init());
  CURL* easy = t.easy.get();
  curl_easy_reset(easy);
  prepare(easy, options);
  t.body.clear(), t.response = {}, t.too_large = false, t.detail[0] = 0, t.most_bytes = options.most_bytes;
  std::vector<std::string> lines;
  if (!t.request.etag.empty()) lines.push_back("If-None-Match: " + t.request.etag);
  if (!t.request.last_modified.empty()) lines.push_back("If-Modified-Since: " + t.request.last_modified);
  if (!t.request.post_type.empty()) lines.push_back("Content-Type: " + t.request.post_type);
  t.headers = header_list(lines);
  curl_easy_setopt(easy, CURLOPT_URL, t.request.url.c_str());
  curl_easy_setopt(easy, CURLOPT_HTTPHEADER, t.headers.get());
  if (!t.request.post.empty()) {
    curl_easy_setopt(easy, CURLOPT_POSTFIELDSIZE, static_cast<long>(t.request.post.size()));
    curl_easy_setopt(easy, CURLOPT_POSTFIELDS, t.request.post.c_str());
  }
  curl_easy_setopt(easy, CURLOPT_WRITEFUNCTION, keep_body);
  curl_easy_setopt(easy, CURLOPT_WRITEDATA, &t);
  curl_easy_setopt(easy, CURLOPT_HEADERFUNCTION, keep_header);
  curl_easy_setopt(easy, CURLOPT_HEADERDATA, &t);
  curl_easy_setopt(easy, CURLOPT_ERRORBUFFER, t.detail);
}

struct CloseMulti {
  void operator()(CURLM* multi) const { curl_multi_cleanup(multi); }
};

/// The loop of one call of HttpClient::run.
class Run {
 public:
  Run(HttpClient::State& state, const HttpWork& work) : state_(state), options_(state.options), work_(work) {
    start_curl();
    multi_.reset(curl_multi_init());
    curl_multi_setopt(multi_.get(), CURLMOPT_MAX_HOST_CONNECTIONS, static_cast<long>(options_.connections));
    curl_multi_setopt(multi_.get(), CURLMOPT_MAX_TOTAL_CONNECTIONS, static_cast<long>(options_.connections));
  }
  ~Run() {
    for (auto& [easy, transfer] : active_) curl_multi_remove_handle(multi_.get(), easy);
  }
  Run(const Run&) = delete;
  Run& operator=(const Run&) = delete;

  HttpCounts run() {
    while (true) {
      if (state_.monitor && state_.monitor->cancelled()) throw Error("cancelled; run it again to go on");
      start_transfers();
      if (active_.empty() && waiting_.empty() && exhausted_) break;
      int running = 0;
      curl_multi_perform(multi_.get(), &running);
      bool finished = false;
      while (finish_one()) finished = true;
      if (work_.idle) work_.idle();
      throw_if_stopped();
      if (finished) continue;  // their places are free: nothing may come that would wake it
      if (curl_multi_poll(multi_.get(), nullptr, 0, wait_ms(), nullptr) != CURLM_OK)
        throw Error("libcurl: cannot wait");
    }
    return counts_;
  }

 private:
  [[nodiscard]] int wait_ms() const {
    Time until = Clock::now() + std::chrono::milliseconds(100);
    if (static_cast<int>(active_.size()) < options_.connections && !waiting_.empty())
      until = std::min(until, std::max(waiting_.begin()->first, paused_until_));
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(until - Clock::now()).count();
    return static_cast<int>(std::clamp<std::int64_t>(left + 1, 1, 100));
  }

  void start_transfers() {
    while (static_cast<int>(active_.size()) < options_.connections && Clock::now() >= paused_until_) {
      TransferPtr transfer;
      if (!waiting_.empty() && waiting_.begin()->first <= Clock::now()) {
        transfer = std::move(waiting_.begin()->second);
        waiting_.erase(waiting_.begin());
      } else if (!exhausted_ && waiting_.size() < 1000) {
        std::optional<HttpRequest> request = work_.next();
        if (!request) {
          exhausted_ = true;
          continue;
        }
        transfer = std::make_unique<Transfer>();
        transfer->request = std::move(*request);
        if (!idle_handles_.empty()) {
          transfer->easy = std::move(idle_handles_.back());
          idle_handles_.pop_back();
        }
      } else {
        return;
      }
      set_up(*transfer, options_);
      ++counts_.requests;
      CURL* easy = transfer->easy.get();
      curl_multi_add_handle(multi_.get(), easy);
      active_.emplace(easy, std::move(transfer));
    }
  }

  bool finish_one() {
    int left = 0;
    const CURLMsg* message = curl_multi_info_read(multi_.get(), &left);
    if (!message) return false;
    if (message->msg != CURLMSG_DONE) return true;
    CURL* easy = message->easy_handle;
    const CURLcode result = message->data.result;
    curl_multi_remove_handle(multi_.get(), easy);
    const auto found = active_.find(easy);
    TransferPtr transfer = std::move(found->second);
    active_.erase(found);
    finish(std::move(transfer), result);
    return true;
  }

  void finish(TransferPtr transfer, CURLcode result) {
    long status = 0;
    curl_easy_getinfo(transfer->easy.get(), CURLINFO_RESPONSE_CODE, &status);
    counts_.bytes += static_cast<std::int64_t>(transfer->body.size());
    Verdict verdict = judge(result, status, transfer->detail);
    if (transfer->too_large)
      verdict = {Judgement::never, fmt::format("the answer has more than {} MB", options_.most_bytes >> 20)};
    HttpReply reply{transfer->request.id,      static_cast<int>(status),
                    std::move(transfer->body), transfer->response.content_type,
                    transfer->response.etag,   transfer->response.last_modified};
    if (verdict.judgement == Judgement::good && work_.check)
      if (std::string wrong = work_.check(reply); !wrong.empty()) verdict = {Judgement::again, std::move(wrong)};
    if (verdict.judgement == Judgement::missing && !transfer->was_missing) {  // caches say so when they mean later
      transfer->was_missing = true;
      return ask_again(std::move(transfer), options_.first_pause_s);
    }
    switch (verdict.judgement) {
      case Judgement::again:
        return retry(std::move(transfer), status, verdict.why);
      case Judgement::never:
        return give_up(std::move(transfer), verdict.why, status);
      case Judgement::missing:
        reply.status = 404;
        break;
      default:
        break;
    }
    ++succeeded_;
    idle_handles_.push_back(std::move(transfer->easy));
    work_.take(std::move(reply));
  }

  void ask_again(TransferPtr transfer, double pause_s) {
    ++counts_.retries;
    waiting_.emplace(after(pause_s), std::move(transfer));
  }

  void retry(TransferPtr transfer, long status, const std::string& why) {
    double pause_s = pause_before(transfer->attempt + 1, options_);
    const auto asked = retry_after_s(transfer->response.retry_after, std::time(nullptr));
    if (asked && *asked > longest_wait_s)
      throw Error(fmt::format("{}: {}; the server asks to come again in {:.0f} minutes",
                              state_.shown(transfer->request.url), why, *asked / 60.0));
    if (asked) pause_s = std::max(pause_s, *asked);
    // What one is told, all obey.
    if (asked || status == 429) paused_until_ = std::max(paused_until_, after(pause_s));
    const int most = succeeded_ > 0 ? options_.attempts : std::min(options_.attempts, 4);
    if (transfer->attempt >= most) return give_up(std::move(transfer), why, status);
    ++transfer->attempt;
    ask_again(std::move(transfer), pause_s);
  }

  void give_up(TransferPtr transfer, const std::string& why, long status) {
    constexpr int hopeless = 8;
    const std::string what = fmt::format("{}: {}", state_.shown(transfer->request.url), state_.shown(why));
    if (succeeded_ == 0 && ++failed_ >= hopeless)
      throw Error(fmt::format("{} (and none of {} other requests succeeded)", what, failed_ - 1));
    work_.fail({transfer->request.id, what, static_cast<int>(status)});
  }

  HttpClient::State& state_;
  const HttpOptions& options_;
  const HttpWork& work_;
  std::unique_ptr<CURLM, CloseMulti> multi_;
  std::map<CURL*, TransferPtr> active_;
  std::multimap<Time, TransferPtr> waiting_;
  std::vector<EasyPtr> idle_handles_;
  Time paused_until_{};
  bool exhausted_ = false;
  std::int64_t succeeded_ = 0, failed_ = 0;
  HttpCounts counts_;
};
}  // namespace

HttpClient::HttpClient(HttpOptions options, const Secrets& secrets, Monitor* monitor)
    : state_(std::make_unique<State>(State{std::move(options), secrets, monitor})) {}
HttpClient::~HttpClient() = default;

HttpCounts HttpClient::run(const HttpWork& work) { return Run(*state_, work).run(); }

HttpReply HttpClient::get(const HttpRequest& request, const std::function<std::string(const HttpReply&)>& check) {
  HttpReply result;
  bool asked = false;
  std::string wrong;
  HttpWork work;
  work.next = [&]() -> std::optional<HttpRequest> {
    if (std::exchange(asked, true)) return std::nullopt;
    return request;
  };
  work.check = check;
  work.take = [&](HttpReply&& reply) { result = std::move(reply); };
  work.fail = [&](HttpFailure&& failure) { wrong = std::move(failure.what); };
  (void)run(work);
  if (!wrong.empty()) throw Error(wrong);
  if (result.status == 404)
    throw Error(fmt::format("{}: HTTP 404 (not there); check the url", state_->shown(request.url)));
  return result;
}

}  // namespace orthodrive::remote
