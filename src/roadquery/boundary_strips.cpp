#include "roadquery/boundary_strips.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

namespace roadquery {

BoundaryStrips::BoundaryStrips(std::span<const std::array<double, 2>> ring) {
  constexpr double strip_m = 1.0;
  constexpr std::size_t most_in_strips = 16;  // times the edges: memory stays linear whatever the ring looks like
  west_ = south_ = std::numeric_limits<double>::infinity(), east_ = north_ = -west_;
  std::vector<Edge> all;
  for (std::size_t i = 0, before = ring.size() - 1; i < ring.size(); before = i++) {
    all.push_back({ring[before][0], ring[before][1], ring[i][0], ring[i][1]});
    west_ = std::min(west_, ring[i][0]), east_ = std::max(east_, ring[i][0]);
    south_ = std::min(south_, ring[i][1]), north_ = std::max(north_, ring[i][1]);
  }
  strips_ = static_cast<std::uint32_t>(std::clamp((north_ - south_) / strip_m, 1.0, 4096.0));
  for (;; strips_ /= 2) {
    per_m_ = north_ > south_ ? strips_ / (north_ - south_) : 0.0;
    std::size_t count = 0;
    for (const Edge& edge : all) count += strips_of(edge).last - strips_of(edge).first + 1;
    if (strips_ == 1 || count <= most_in_strips * all.size()) break;
  }
  begin_.assign(strips_ + 1, 0);
  for (const Edge& edge : all)
    for (std::uint32_t k = strips_of(edge).first; k <= strips_of(edge).last; ++k) ++begin_[k + 1];
  for (std::uint32_t k = 0; k < strips_; ++k) begin_[k + 1] += begin_[k];
  edges_.resize(begin_.back());
  std::vector<std::uint32_t> next(begin_.begin(), begin_.end() - 1);
  for (const Edge& edge : all)
    for (std::uint32_t k = strips_of(edge).first; k <= strips_of(edge).last; ++k) edges_[next[k]++] = edge;
}

/// Rises with y, so that a strip has all edges that pass one of its points.
std::uint32_t BoundaryStrips::strip_of(double y) const {
  return static_cast<std::uint32_t>(std::clamp((y - south_) * per_m_, 0.0, strips_ - 1.0));
}

BoundaryStrips::Range BoundaryStrips::strips_of(const Edge& edge) const {
  return {strip_of(std::min(edge.y0, edge.y1)), strip_of(std::max(edge.y0, edge.y1))};
}

bool BoundaryStrips::contains(double x, double y) const {
  constexpr double rounding_m = 1e-6;  // of where an edge is crossed
  if (!(x >= west_ - rounding_m && x <= east_ + rounding_m && y >= south_ && y <= north_)) return false;
  const std::uint32_t strip = strip_of(y);
  bool inside = false;
  for (std::uint32_t i = begin_[strip]; i < begin_[strip + 1]; ++i) {
    const Edge& e = edges_[i];
    if ((e.y0 > y) == (e.y1 > y)) continue;
    if (x < e.x0 + (y - e.y0) / (e.y1 - e.y0) * (e.x1 - e.x0)) inside = !inside;
  }
  return inside;
}

}  // namespace roadquery
