#pragma once
// A ring cut into horizontal strips, so that a point is compared with a few of its edges.

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace roadquery {

class BoundaryStrips {
 public:
  /// The ring has no point twice at its ends; its numbers are finite.
  explicit BoundaryStrips(std::span<const std::array<double, 2>> ring);

  /// As contains() of junction_surface.hpp, to the last digit.
  [[nodiscard]] bool contains(double x, double y) const;

 private:
  struct Edge {
    double x0, y0, x1, y1;
  };
  struct Range {
    std::uint32_t first, last;
  };
  [[nodiscard]] std::uint32_t strip_of(double y) const;
  [[nodiscard]] Range strips_of(const Edge& edge) const;

  double west_, east_, south_, north_, per_m_ = 0.0;
  std::uint32_t strips_ = 1;
  std::vector<std::uint32_t> begin_;  // of each strip in edges_, and the count of all
  std::vector<Edge> edges_;
};

}  // namespace roadquery
