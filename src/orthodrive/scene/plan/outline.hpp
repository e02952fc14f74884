// SPDX-License-Identifier: Apache-2.0
#pragma once
// The border of a polygon set, with heights at its points: inside tests and the nearest place of the border.

#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <vector>

#include "orthodrive/geo/polygon.hpp"
#include "orthodrive/geo/spatial_index.hpp"

namespace orthodrive::scene {

/// The inside lies to the left from a to b.
struct BorderSegment {
  Vec2 a, b;
  double a_z_m = 0.0, b_z_m = 0.0;
};

struct NearestBorder {
  double distance_m = std::numeric_limits<double>::infinity();
  double z_m = 0.0;
};

class Outline {
 public:
  Outline() = default;
  /// Rings must be oriented (outer counter-clockwise, holes clockwise). `reach_m` limits nearest().
  /// Without a height function the heights are 0.
  Outline(const MultiPolygon& polygons, double reach_m, const std::function<double(Vec2)>& height_m = {},
          int threads = 0);

  [[nodiscard]] bool contains(Vec2 p) const;  ///< even-odd; border points may go either way
  /// Infinite distance when the border is further than the reach.
  [[nodiscard]] NearestBorder nearest(Vec2 p) const;
  [[nodiscard]] const std::vector<BorderSegment>& segments() const { return segments_; }

 private:
  double reach_m_ = 0.0;
  std::vector<BorderSegment> segments_;
  SpatialIndex index_;
};

}  // namespace orthodrive::scene
