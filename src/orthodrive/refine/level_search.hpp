// SPDX-License-Identifier: Apache-2.0
#pragma once
// The cheapest path through a row of grids of offset x width levels, found exactly by dynamic programming (Viterbi).

#include <cstddef>
#include <cstdint>
#include <vector>

namespace orthodrive::refine {

/// From one segment to the next, offset and width each change by one level at most. A path costs the costs of its
/// states and `step_cost` for every level changed. Of several cheapest paths the same one is found every time.
class LevelSearch {
 public:
  /// A state is offset level * widths + width level.
  LevelSearch(int offsets, int widths, double step_cost);

  [[nodiscard]] int states() const { return offsets_ * widths_; }
  /// The next segment; `cost` has one entry per state.
  void add_segment(const std::vector<double>& cost);
  /// One state per segment. Needs one segment at least.
  [[nodiscard]] std::vector<int> cheapest() const;
  /// Of that path.
  [[nodiscard]] double cheapest_cost() const;

 private:
  int offsets_, widths_;
  double step_cost_;
  std::vector<double> total_, next_;
  std::vector<std::uint8_t> came_from_;  // [segment][state] 3 * (offset step + 1) + width step + 1
};

}  // namespace orthodrive::refine
