// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/refine/level_search.hpp"

#include <algorithm>
#include <cstdlib>
#include <limits>

namespace orthodrive::refine {

LevelSearch::LevelSearch(int offsets, int widths, double step_cost)
    : offsets_(offsets),
      widths_(widths),
      step_cost_(step_cost),
      total_(static_cast<std::size_t>(states()), 0.0),
      next_(total_.size()) {}

void LevelSearch::add_segment(const std::vector<double>& cost) {
  for (int o = 0; o < offsets_; ++o)
    for (int w = 0; w < widths_; ++w) {
      const int state = o * widths_ + w;
      double best = std::numeric_limits<double>::infinity();
      std::uint8_t step = 4;
      for (int d = -1; d <= 1; ++d)
        for (int e = -1; e <= 1; ++e) {
          if (o + d < 0 || o + d >= offsets_ || w + e < 0 || w + e >= widths_) continue;
          const double candidate = total_[state + d * widths_ + e] + step_cost_ * (std::abs(d) + std::abs(e));
          if (candidate < best) best = candidate, step = static_cast<std::uint8_t>(3 * (d + 1) + e + 1);
        }
      next_[state] = best + cost[state];
      came_from_.push_back(step);
    }
  total_.swap(next_);
}

std::vector<int> LevelSearch::cheapest() const {
  const std::size_t segments = came_from_.size() / total_.size();
  std::vector<int> best(segments);
  best.back() = static_cast<int>(std::min_element(total_.begin(), total_.end()) - total_.begin());
  for (std::size_t segment = segments; segment-- > 1;) {
    const int step = came_from_[segment * total_.size() + static_cast<std::size_t>(best[segment])];
    best[segment - 1] = best[segment] + (step / 3 - 1) * widths_ + step % 3 - 1;
  }
  return best;
}

double LevelSearch::cheapest_cost() const { return *std::min_element(total_.begin(), total_.end()); }

}  // namespace orthodrive::refine
