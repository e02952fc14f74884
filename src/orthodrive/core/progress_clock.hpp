// SPDX-License-Identifier: Apache-2.0
#pragma once
// How fast work goes on and how long the rest of it takes, from fractions told from time to time.

#include <algorithm>
#include <optional>
#include <string>
#include <string_view>

namespace orthodrive {

struct ProgressPace {
  double rate_per_s = 0.0;   ///< fraction of the work per second, mean since its first report
  double remaining_s = 0.0;  ///< at that rate
};

/// Work begins anew with another name or with a fraction that falls.
class ProgressClock {
 public:
  /// `now_s` from any clock that does not jump. None until there is something to go by: 1 s and 1 % of the work.
  std::optional<ProgressPace> update(double fraction, std::string_view what, double now_s) {
    if (what != what_ || fraction < fraction_) what_ = what, start_s_ = now_s, start_ = fraction;
    fraction_ = fraction;
    const double seconds = now_s - start_s_, done = fraction - start_;
    if (seconds < 1.0 || done < 0.01) return std::nullopt;
    const double rate = done / seconds;
    return ProgressPace{rate, std::max(0.0, 1.0 - fraction) / rate};
  }

 private:
  std::string what_;
  double start_s_ = 0.0, start_ = 0.0, fraction_ = 2.0;
};

}  // namespace orthodrive
