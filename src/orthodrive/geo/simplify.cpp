// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/geo/simplify.hpp"

#include <algorithm>
#include <utility>

#include "orthodrive/geo/segment.hpp"

namespace orthodrive {

std::vector<bool> simplify(std::span<const Vec2> line, double tolerance_m) {
  std::vector<bool> stays(line.size(), false);
  if (line.empty()) return stays;
  stays.front() = stays.back() = true;
  std::vector<std::pair<std::size_t, std::size_t>> open{{0, line.size() - 1}};
  while (!open.empty()) {
    const auto [first, last] = open.back();
    open.pop_back();
    double farthest_m = tolerance_m;
    std::size_t split = first;
    for (std::size_t i = first + 1; i < last; ++i) {
      const double d = distance(line[i], nearest_on_segment(line[first], line[last], line[i]));
      if (d > farthest_m) farthest_m = d, split = i;
    }
    if (split == first) continue;
    stays[split] = true;
    open.push_back({first, split}), open.push_back({split, last});
  }
  return stays;
}

}  // namespace orthodrive
