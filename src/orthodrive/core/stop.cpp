#include "orthodrive/core/stop.hpp"

#include <signal.h>
#include <unistd.h>

#include <atomic>
#include <thread>

#include "orthodrive/core/atomic_file.hpp"

namespace orthodrive {
namespace {
using Clock = std::chrono::steady_clock;
std::atomic<int> asked_by{0};  // one process, one wish to end: the only state that stages share

/// The next of these signals within the time; 0 if none came.
int wait_for_signal(const sigset_t& signals, std::chrono::milliseconds most) {
  const timespec time{most.count() / 1000, (most.count() % 1000) * 1000000};
  const int signal = sigtimedwait(&signals, nullptr, &time);
  return signal > 0 ? signal : 0;
}
}  // namespace

void request_stop(int signal) noexcept { asked_by = signal; }
bool stop_requested() noexcept { return asked_by != 0; }
void throw_if_stopped() {
  if (const int signal = asked_by) throw Stopped(signal);
}

struct StopOnSignals::State {
  StopOptions options;
  sigset_t signals{}, mask_before{};
  std::atomic<bool> done{false};
  std::thread watch;

  [[noreturn]] void end_now(int signal) const {
    if (options.last_words) options.last_words();
    remove_own_atomic_files();
    _exit(128 + signal);
  }
  void run() const {
    constexpr std::chrono::milliseconds tick{50};
    int signal = 0;
    while (!done && signal == 0) signal = wait_for_signal(signals, tick);
    if (signal == 0) return;
    request_stop(signal);
    const auto until = Clock::now() + options.patience;
    while (!done && Clock::now() < until) (void)wait_for_signal(signals, tick);  // a second Ctrl-C says nothing new
    if (!done) end_now(signal);
  }
};

StopOnSignals::StopOnSignals(StopOptions options) : state_(std::make_unique<State>()) {
  state_->options = std::move(options);
  sigemptyset(&state_->signals);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    struct sigaction before {};
    sigaction(signal, nullptr, &before);
    if (before.sa_handler != SIG_IGN) sigaddset(&state_->signals, signal);
  }
  pthread_sigmask(SIG_BLOCK, &state_->signals, &state_->mask_before);
  state_->watch = std::thread([state = state_.get()] { state->run(); });
}

StopOnSignals::~StopOnSignals() {
  state_->done = true;
  state_->watch.join();
  pthread_sigmask(SIG_SETMASK, &state_->mask_before, nullptr);
}

}  // namespace orthodrive
