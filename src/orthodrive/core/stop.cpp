// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/core/stop.hpp"

#include <signal.h>
#include <unistd.h>

#include <atomic>
#include <thread>
#include <utility>

#include "orthodrive/core/atomic_file.hpp"

namespace orthodrive {
namespace {
using Clock = std::chrono::steady_clock;
std::atomic<int> asked_by{0};  // one process, one wish to end: the only state that stages share

void on_signal(int signal) { asked_by = signal; }
static_assert(std::atomic<int>::is_always_lock_free, "a signal handler may not wait");
}  // namespace

void request_stop(int signal) noexcept { asked_by = signal; }
bool stop_requested() noexcept { return asked_by != 0; }
void throw_if_stopped() {
  if (const int signal = asked_by) throw Stopped(signal);
}

// A handler, and not a mask with sigwait(): libraries start threads as they are loaded (OpenBLAS), which would take the
// signals that the others mask.
struct StopOnSignals::State {
  StopOptions options;
  std::atomic<bool> done{false};
  std::thread watch;

  [[noreturn]] void end_now(int signal) const {
    if (options.last_words) options.last_words();
    remove_own_atomic_files();
    _exit(128 + signal);
  }
  void run() const {
    constexpr std::chrono::milliseconds tick{50};
    while (!done && !stop_requested()) std::this_thread::sleep_for(tick);
    const auto until = Clock::now() + options.patience;
    while (!done && Clock::now() < until) std::this_thread::sleep_for(tick);
    if (!done) end_now(asked_by);
  }
};

StopOnSignals::StopOnSignals(StopOptions options) : state_(std::make_unique<State>()) {
  state_->options = std::move(options);
  struct sigaction action {};
  action.sa_handler = on_signal;
  action.sa_flags = SA_RESTART;  // libraries do not expect interrupted calls
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    struct sigaction before {};
    sigaction(signal, nullptr, &before);
    if (before.sa_handler == SIG_IGN) continue;
    sigaction(signal, &action, nullptr);
  }
  state_->watch = std::thread([state = state_.get()] { state->run(); });
}

StopOnSignals::~StopOnSignals() {
  state_->done = true;
  state_->watch.join();
}

}  // namespace orthodrive
