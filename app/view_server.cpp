// SPDX-License-Identifier: Apache-2.0
#include "view_server.hpp"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace orthodrive::app {
namespace {
using Clock = std::chrono::steady_clock;
using std::chrono::seconds;

// --- connections

/// Set while a connection for which there is no room is closed.
thread_local bool no_room = false;

/// A fixed number of threads and a short line before them.
class BoundedQueue : public httplib::TaskQueue {
 public:
  BoundedQueue() {
    for (int i = 0; i < ViewServer::threads; ++i) threads_.emplace_back([this] { work(); });
  }
  void enqueue(std::function<void()> job) override {
    {
      const std::lock_guard lock(mutex_);
      if (waiting_.size() < static_cast<std::size_t>(ViewServer::most_waiting)) {
        waiting_.push_back(std::move(job));
        arrived_.notify_one();
        return;
      }
    }
    no_room = true;
    job();
    no_room = false;
  }
  void shutdown() override {
    {
      const std::lock_guard lock(mutex_);
      ended_ = true;
    }
    arrived_.notify_all();
    for (std::thread& thread : threads_) thread.join();
  }

 private:
  void work() {
    for (std::unique_lock lock(mutex_);;) {
      arrived_.wait(lock, [this] { return ended_ || !waiting_.empty(); });
      if (waiting_.empty()) return;
      const std::function<void()> job = std::move(waiting_.front());
      waiting_.pop_front();
      lock.unlock();
      job();
      lock.lock();
    }
  }

  std::mutex mutex_;
  std::condition_variable arrived_;
  std::deque<std::function<void()>> waiting_;
  std::vector<std::thread> threads_;
  bool ended_ = false;
};

/// A connection on which a request has to come, and its answer to be taken, within a time. cpp-httplib bounds the time
/// of each piece only, and a head may have any number of lines.
class BoundedStream : public httplib::Stream {
 public:
  BoundedStream(socket_t socket, std::function<bool()> stopped) : socket_(socket), stopped_(std::move(stopped)) {}

  /// False: nothing came in time.
  bool wait_for_request(seconds longest) {
    head_bytes_ = 0;
    if (next_ == end_ && !wait(POLLIN, Clock::now() + longest)) return false;
    head_until_ = Clock::now() + seconds(ViewServer::head_s);
    answer_until_ = Clock::now() + seconds(ViewServer::answer_s);
    return true;
  }

  /// The end of the connection was seen, or a bound was hit.
  [[nodiscard]] bool has_ended() const { return ended_; }

  bool is_readable() const override { return next_ < end_ || wait(POLLIN, head_until_); }
  bool is_writable() const override { return wait(POLLOUT, write_until()); }
  ssize_t read(char* bytes, size_t most) override {
    ended_ = true;
    if (Clock::now() >= head_until_) return -1;
    if (next_ == end_) {
      if (!wait(POLLIN, head_until_)) return -1;
      const ssize_t count = recv(socket_, buffer_.data(), buffer_.size(), 0);
      if (count <= 0) return count;
      next_ = 0, end_ = static_cast<std::size_t>(count);
    }
    const std::size_t count = std::min(most, end_ - next_);
    head_bytes_ += count;
    if (head_bytes_ > ViewServer::most_head) return -1;
    std::copy_n(buffer_.begin() + static_cast<std::ptrdiff_t>(next_), count, bytes);
    next_ += count;
    ended_ = false;
    return static_cast<ssize_t>(count);
  }
  ssize_t write(const char* bytes, size_t count) override {
    return is_writable() ? send(socket_, bytes, count, MSG_NOSIGNAL | MSG_DONTWAIT) : -1;
  }
  void get_remote_ip_and_port(std::string& ip, int& port) const override { name_of(getpeername, ip, port); }
  void get_local_ip_and_port(std::string& ip, int& port) const override { name_of(getsockname, ip, port); }
  socket_t socket() const override { return socket_; }

 private:
  [[nodiscard]] Clock::time_point write_until() const {
    return std::min(answer_until_, Clock::now() + seconds(ViewServer::stalled_s));
  }
  [[nodiscard]] bool wait(short event, Clock::time_point until) const {
    constexpr int slice_ms = 100;  // so that the server ends soon when it is told to
    for (;;) {
      pollfd waiting{socket_, event, 0};
      const int ready = poll(&waiting, 1, slice_ms);
      if (ready > 0) return true;
      if ((ready < 0 && errno != EINTR) || Clock::now() >= until || stopped_()) return false;
    }
  }
  template <typename GetName>
  void name_of(GetName get_name, std::string& ip, int& port) const {
    sockaddr_in address{};
    socklen_t size = sizeof address;
    std::array<char, INET_ADDRSTRLEN> text{};
    if (get_name(socket_, reinterpret_cast<sockaddr*>(&address), &size) != 0) return;  // NOLINT: the socket API is such
    if (inet_ntop(AF_INET, &address.sin_addr, text.data(), text.size())) ip = text.data();
    port = ntohs(address.sin_port);
  }

  socket_t socket_;
  std::function<bool()> stopped_;
  std::array<char, 4096> buffer_{};
  std::size_t next_ = 0, end_ = 0, head_bytes_ = 0;
  bool ended_ = false;
  Clock::time_point head_until_, answer_until_;
};

// --- requests

bool is_ours(std::string host, int port) {
  std::transform(host.begin(), host.end(), host.begin(), [](unsigned char c) { return std::tolower(c); });
  const std::array<std::string, 3> names{"127.0.0.1", "localhost", "[::1]"};
  return std::any_of(names.begin(), names.end(), [&](const std::string& name) {
    return host == fmt::format("{}:{}", name, port) || (port == 80 && host == name);
  });
}

void refuse(httplib::Response& response, int status, const std::string& text) {
  response.status = status;
  response.set_content(text + "\n", "text/plain; charset=utf-8");
}

/// The one part of the file that is asked for, as cpp-httplib wants it: within the file. It believes any numbers, and
/// gathers any number of parts in memory; so more than one part is answered with the whole file, which a server may do.
/// False: the part lies behind the end.
bool bound_ranges(httplib::Ranges& ranges, std::size_t size) {
  if (ranges.size() != 1 || size == 0) {
    ranges.clear();
    return true;
  }
  const auto end = static_cast<ssize_t>(size);
  auto& [first, last] = ranges.front();
  if (first < 0 && last < 0)
    ranges.clear();  // "bytes=-"
  else if (first < 0)
    first = std::max<ssize_t>(0, end - last), last = end - 1;
  else
    last = last < 0 ? end - 1 : std::min(last, end - 1);
  return ranges.empty() || (first <= last && first < end);
}

void send_file(const ServedFile& file, const httplib::Request& request, httplib::Response& response) {
  auto& ranges = const_cast<httplib::Request&>(request).ranges;  // httplib's own object, which is not const
  if (!bound_ranges(ranges, file.size)) {
    ranges.clear();
    response.set_header("Content-Range", fmt::format("bytes */{}", file.size));
    refuse(response, 416, "The file ends before that part.");
    return;
  }
  // three.js makes addresses of its own (blob:) of the pictures in tiles, and fetches them.
  response.set_header("Content-Security-Policy",
                      file.of_viewer ? "default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; worker-src 'self'; "
                                       "style-src 'self'; img-src 'self' blob: data:; connect-src 'self' blob:; "
                                       "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
                                     : "default-src 'none'; sandbox");
  if (file.size == 0) {
    response.set_content("", file.content_type);
    return;
  }
  response.set_content_provider(
      file.size, file.content_type, [file](std::size_t offset, std::size_t length, httplib::DataSink& sink) {
        std::array<char, 65536> bytes;
        const ssize_t count =
            pread(*file.descriptor, bytes.data(), std::min(length, bytes.size()), static_cast<off_t>(offset));
        return count > 0 && sink.write(bytes.data(), static_cast<std::size_t>(count));  // no more: the file was cut
      });
}

bool has_body(const httplib::Request& request) {
  return request.has_header("Transfer-Encoding") ||
         (request.has_header("Content-Length") && request.get_header_value("Content-Length") != "0");
}

}  // namespace

ViewServer::ViewServer(ViewFiles files) : files_(std::move(files)) {
  new_task_queue = [] { return new BoundedQueue; };
  // httplib's default is SO_REUSEPORT, with which two servers share a port without an error and answer in turns.
  set_socket_options([](socket_t socket) {
    const int yes = 1;
    setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof(yes));
  });
  set_keep_alive_timeout(5);                           // seconds; a busy browser connects some time before it asks
  set_keep_alive_max_count(10'000);                    // a page with its tiles asks for hundreds of files
  set_tcp_nodelay(true);                               // head and body are sent one after the other
  set_default_headers({{"Cache-Control", "no-cache"},  // a site may be built anew under the same address
                       {"X-Content-Type-Options", "nosniff"},
                       {"Cross-Origin-Resource-Policy", "same-origin"},
                       {"Referrer-Policy", "no-referrer"}});
  set_pre_routing_handler([this](const httplib::Request& request, httplib::Response& response) {
    answer(request, response);
    return HandlerResponse::Handled;
  });
}

void ViewServer::expect_calls(int port) {
  port_ = port;
  ::listen(svr_sock_, most_waiting);  // httplib lets 5 wait before they are accepted
}

void ViewServer::answer(const httplib::Request& request, httplib::Response& response) const {
  if (request.get_header_value_count("Host") != 1 || !is_ours(request.get_header_value("Host"), port_)) {
    refuse(response, 403,
           fmt::format("This server answers to http://127.0.0.1:{0}/ and http://localhost:{0}/ only.", port_));
    return;
  }
  const std::string origin = request.get_header_value("Origin");
  if (!origin.empty() && !(origin.rfind("http://", 0) == 0 && is_ours(origin.substr(7), port_))) {
    refuse(response, 403, "This server answers to its own pages only.");
    return;
  }
  if ((request.method != "GET" && request.method != "HEAD") || has_body(request)) {
    response.set_header("Allow", "GET, HEAD");
    refuse(response, 405, "This server gives out files only.");
    return;
  }
  if (const auto file = files_.open(request.path)) {
    send_file(*file, request, response);
    return;
  }
  refuse(response, 404, "There is no such file, or none that the viewer needs.");
}

bool ViewServer::process_and_close_socket(socket_t socket) {
  bool done = false;
  if (!no_room) {
    BoundedStream stream(socket, [this] { return svr_sock_ == INVALID_SOCKET; });
    bool is_last = false;
    for (std::size_t left = keep_alive_max_count_; left > 0 && !is_last; --left) {
      if (svr_sock_ == INVALID_SOCKET || !stream.wait_for_request(seconds(keep_alive_timeout_sec_))) break;
      bool refused = false;
      done = process_request(stream, left == 1, is_last, [&](httplib::Request& request) {
        // httplib packs text with Brotli at its best and slowest: a second for 0.5 MB, on a line that needs no packing.
        request.headers.erase("Accept-Encoding");
        if (request.ranges.size() > 1) request.ranges.clear();
        refused = (request.method != "GET" && request.method != "HEAD") || has_body(request);
      });
      if (!done || refused || stream.has_ended())
        break;  // the body of what was refused is not read: it must not be taken for a request
    }
  }
  ::shutdown(socket, SHUT_RDWR);
  ::close(socket);
  return done;
}

}  // namespace orthodrive::app
