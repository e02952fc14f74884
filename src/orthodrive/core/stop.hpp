// SPDX-License-Identifier: Apache-2.0
#pragma once
// Ending a run early and well: a request that loops look at, and signals of the system as such requests.

#include <chrono>
#include <exception>
#include <functional>
#include <memory>

namespace orthodrive {

/// The run was asked to end. Not an Error: who turns errors into findings must let it pass. Caught once, in app/main.
struct Stopped final : std::exception {
  explicit Stopped(int by_signal) : signal(by_signal) {}
  [[nodiscard]] const char* what() const noexcept override { return "stopped; run again to go on"; }
  int signal;  ///< SIGINT, SIGTERM or SIGHUP
};

/// Asks the process to end at the next place that looks. From any thread; it cannot be taken back.
void request_stop(int signal) noexcept;
[[nodiscard]] bool stop_requested() noexcept;
/// Throws Stopped when the process was asked to end. Costs next to nothing: call it once per item of a long loop.
void throw_if_stopped();

struct StopOptions {
  std::chrono::milliseconds patience{1500};  ///< time that the run has to end by itself
  std::function<void()> last_words;          ///< called before a process that did not is ended; must not wait
};

/// While it lives, SIGINT, SIGTERM and SIGHUP are requests to stop. What does not come to such a place in time (one
/// long call of a library) is ended where it is: temporaries of AtomicFile are removed, then the process exits with 128
/// + the signal. A signal that was ignored before (nohup) stays ignored. After it signals change nothing: the work is
/// done, and the program, which unloads its libraries, ends with its exit code and all its output. Make one at a time.
class StopOnSignals {
 public:
  explicit StopOnSignals(StopOptions options = {});
  ~StopOnSignals();
  StopOnSignals(const StopOnSignals&) = delete;
  StopOnSignals& operator=(const StopOnSignals&) = delete;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace orthodrive
