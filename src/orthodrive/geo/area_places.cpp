// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/geo/area_places.hpp"

#include <algorithm>
#include <cmath>

namespace orthodrive {
namespace {

constexpr double enough_places = 400.0;

void visit_outline(const Ring& ring, const std::function<void(Vec2)>& visit) {
  double length_m = 0.0;
  for (std::size_t i = 0; i < ring.size(); ++i) length_m += distance(ring[i], ring[(i + 1) % ring.size()]);
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const Vec2 from = ring[i], along = ring[(i + 1) % ring.size()] - from;
    const int steps = length_m > 0.0 ? static_cast<int>(std::ceil(enough_places * length(along) / length_m)) : 0;
    for (int k = 0; k < std::max(1, steps); ++k) visit(from + along * (k / std::max(1.0, static_cast<double>(steps))));
  }
}

}  // namespace

void visit_area(const Polygon& area, double step_m, const std::function<void(Vec2)>& visit) {
  const Box2 box = bounds_of(area.outer);
  const double longest_m = std::max(box.width(), box.height()), size_m2 = area_m2(area);
  // A strip of a five-hundredth of its length has a row of places yet; a thinner one is a line.
  const double finest_m = longest_m / 2000.0;
  const double finer_m = std::min(step_m, std::max(finest_m, std::sqrt(std::max(0.0, size_m2) / enough_places)));
  bool is_line = !(finer_m > 0.0) || size_m2 < 0.5 * enough_places * finer_m * finer_m;
  if (!is_line) {
    const GridFrame grid = covering_grid(box, finer_m);
    bool any = false;
    rasterize(area, grid, [&](int row, int begin, int end) {
      any = true;
      for (int col = begin; col < end; ++col) visit(grid.center_of(col, row));
    });
    is_line = !any;
  }
  if (is_line) visit_outline(area.outer, visit);
}

}  // namespace orthodrive
