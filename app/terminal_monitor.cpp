// SPDX-License-Identifier: Apache-2.0
#include "terminal_monitor.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "orthodrive/core/stop.hpp"

namespace orthodrive::app {
namespace {
double steady_s() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

/// "2026-01-31T12:00:00.123Z"
std::string utc_now() {
  using namespace std::chrono;
  const auto now = system_clock::now();
  const auto ms = duration_cast<milliseconds>(now.time_since_epoch()).count() % 1000;
  return fmt::format("{:%Y-%m-%dT%H:%M:%S}.{:03d}Z", fmt::gmtime(system_clock::to_time_t(now)), ms);
}

/// "45 s", "12 min", "3 h 05 min"
std::string duration_text(double seconds) {
  const long s = std::lround(seconds);
  if (s < 100) return fmt::format("{} s", s);
  const long minutes = (s + 30) / 60;
  return minutes < 100 ? fmt::format("{} min", minutes) : fmt::format("{} h {:02d} min", minutes / 60, minutes % 60);
}

/// One write per line: lines of threads and of a process that is ended do not mix.
void put_line(const nlohmann::ordered_json& line) {
  const std::string text = line.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
  (void)!write(STDERR_FILENO, text.data(), text.size());
}
}  // namespace

TerminalMonitor::TerminalMonitor() : terminal_(isatty(STDERR_FILENO) != 0) {}

void TerminalMonitor::log(std::string_view level, std::string_view message) const {
  put_line({{"time", utc_now()}, {"level", level}, {"stage", stage_}, {"message", message}});
}

void TerminalMonitor::info(std::string_view message) {
  throw_if_stopped();
  if (quiet) return;
  if (json) return log("info", message);
  clear_bar();
  fmt::print(stderr, "{}\n", message);
}

void TerminalMonitor::fail(std::string_view message) {
  if (json) return log("error", message);
  clear_bar();
  fmt::print(stderr, "orthodrive: {}\n", message);
}

void TerminalMonitor::progress(double fraction, std::string_view what) {
  throw_if_stopped();
  if (quiet || !(terminal_ || json)) return;
  const double now_s = steady_s();
  const std::optional<ProgressPace> pace = clock_.update(fraction, what, now_s);
  const int percent = static_cast<int>(fraction * 100.0);
  const bool same = percent == last_percent_ && what == last_what_;
  // A log gets a line a second and the end of each piece of work; a terminal every percent.
  if (json ? (what == last_what_ && fraction < 1.0 && now_s < last_s_ + 1.0) || (same && percent == 100)
           : same && now_s < last_s_ + 1.0)
    return;
  last_percent_ = percent, last_what_ = what, last_s_ = now_s;
  draw(fraction, what, pace);
}

void TerminalMonitor::draw(double fraction, std::string_view what, const std::optional<ProgressPace>& pace) {
  if (json) {
    nlohmann::ordered_json line{{"time", utc_now()},
                                {"level", "info"},
                                {"stage", stage_.empty() ? std::string(what) : stage_},
                                {"work", what},
                                {"progress", fraction}};
    if (pace) line["rate_per_s"] = pace->rate_per_s, line["remaining_s"] = pace->remaining_s;
    return put_line(line);
  }
  constexpr int cells = 30;
  const int full = last_percent_ * cells / 100;
  const std::string rest =
      pace ? fmt::format("  {:.2g} %/s, {} left", 100.0 * pace->rate_per_s, duration_text(pace->remaining_s)) : "";
  fmt::print(stderr, "\r\033[K{:<12} [{:#>{}}{:.>{}}] {:3d} %{}", what, "", full, "", cells - full, last_percent_,
             rest);
  std::fflush(stderr);
  drawn_ = true;
}

void TerminalMonitor::clear_bar() {
  if (drawn_) fmt::print(stderr, "\r\033[K");
  drawn_ = false;
}

}  // namespace orthodrive::app
