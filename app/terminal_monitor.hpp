// SPDX-License-Identifier: Apache-2.0
#pragma once
// What a person at a terminal, or a program that reads a log, sees of a run.

#include <string>
#include <string_view>

#include "orthodrive/core/monitor.hpp"
#include "orthodrive/core/progress_clock.hpp"

namespace orthodrive::app {

/// Messages and a progress bar on stderr; the bar only on a terminal. With `json` a JSON object per line instead: time
/// (UTC), level, stage, then message, or progress (0..1) with rate_per_s and remaining_s. Ends a run that was asked to
/// stop (core/stop.hpp): info and progress throw Stopped then.
class TerminalMonitor final : public Monitor {
 public:
  TerminalMonitor();
  bool quiet = false;
  bool json = false;
  void info(std::string_view message) override;
  void progress(double fraction, std::string_view what) override;
  /// The stage that the following lines belong to.
  void set_stage(std::string stage) { stage_ = std::move(stage); }
  /// A last line of a run, whatever `quiet` says.
  void fail(std::string_view message);
  void clear_bar();

 private:
  void draw(double fraction, std::string_view what, const std::optional<ProgressPace>& pace);
  void log(std::string_view level, std::string_view message) const;

  bool terminal_ = false, drawn_ = false;
  int last_percent_ = -1;
  double last_s_ = -1.0;  ///< of the last line or bar
  std::string last_what_, stage_;
  ProgressClock clock_;
};

}  // namespace orthodrive::app
