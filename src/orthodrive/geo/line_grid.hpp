#pragma once
// Which segments of many lines are near a place? A hash grid over them.

#include <cstdint>
#include <unordered_map>
#include <vector>

#include "orthodrive/geo/polyline.hpp"

namespace orthodrive {

class LineGrid {
 public:
  struct Segment {
    std::uint32_t line = 0, index = 0;  ///< from point `index` of a line to the next
    friend auto operator<=>(const Segment&, const Segment&) = default;
  };
  /// Cells of about the reach of the queries to come are best. Does not keep the lines.
  explicit LineGrid(const std::vector<Polyline>& lines, double cell_m = 32.0);

  /// All segments that come within reach of p, and some that do not, in order of line and index.
  [[nodiscard]] std::vector<Segment> near(Vec2 p, double reach_m) const;

 private:
  double cell_m_;
  std::unordered_map<std::uint64_t, std::vector<Segment>> cells_;  // looked up by key only
};

}  // namespace orthodrive
