#pragma once
// What a person at a terminal sees of a run.

#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>
#include <string>

#include "orthodrive/core/monitor.hpp"

namespace orthodrive::app {

/// Messages and a progress bar on stderr; the bar only on a terminal.
class TerminalMonitor final : public Monitor {
 public:
  bool quiet = false;
  void info(std::string_view message) override {
    if (quiet) return;
    clear_bar();
    fmt::print(stderr, "{}\n", message);
  }
  void progress(double fraction, std::string_view what) override {
    if (quiet || !terminal_) return;
    const int percent = static_cast<int>(fraction * 100.0);
    if (percent == last_percent_ && what == last_what_) return;
    last_percent_ = percent, last_what_ = what;
    constexpr int cells = 30;
    const int full = percent * cells / 100;
    fmt::print(stderr, "\r\033[K{:<12} [{:#>{}}{:.>{}}] {:3d} %", what, "", full, "", cells - full, percent);
    std::fflush(stderr);
    drawn_ = true;
  }
  void clear_bar() {
    if (drawn_) fmt::print(stderr, "\r\033[K");
    drawn_ = false;
  }

 private:
  bool terminal_ = isatty(STDERR_FILENO) != 0, drawn_ = false;
  int last_percent_ = -1;
  std::string last_what_;
};

}  // namespace orthodrive::app
