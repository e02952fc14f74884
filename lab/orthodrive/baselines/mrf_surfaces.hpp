// SPDX-License-Identifier: Apache-2.0
#pragma once
// From the rectangles that the MRF places to road surfaces, both ways of the reference (thesis sec. 3.2.3).

#include <cstddef>
#include <span>
#include <vector>

#include "orthodrive/geo/polygon.hpp"
#include "orthodrive/geo/polyline.hpp"

namespace orthodrive::baselines {

/// A straight piece of road; a row of them follows a road, each beginning near where the one before ends.
struct SegmentRectangle {
  Vec2 a, b;    ///< ends of the centre line
  Vec2 normal;  ///< unit, to the left of a -> b
  double width_m = 0.0;
};

/// A surface as nodes have it: one node before, one between every two and one behind the rectangles.
struct NodeSurface {
  Polyline line;
  std::vector<double> width_m;
};

/// The thesis's way: at every node the orientation, the width and the place are the means of the two rectangles' ends.
/// `closed`: the last rectangle leads on to the first, and the first and the last node are one.
[[nodiscard]] NodeSurface smooth_surface(std::span<const SegmentRectangle> rectangles, bool closed);

/// The paper's way: the left and the right corners of the rectangles in order, each row simplified by Douglas and
/// Peucker. The outline as one ring, which may cross itself where a rectangle juts out of a tight bend. Empty without
/// rectangles.
[[nodiscard]] Ring simplified_outline(std::span<const SegmentRectangle> rectangles, double tolerance_m);
/// The same outline as nodes: half way between its borders. Jumps between two rectangles that the tolerance leaves in
/// the outline become a slope here, because a node has one width; the outline is the exact one.
[[nodiscard]] NodeSurface simplified_surface(std::span<const SegmentRectangle> rectangles, bool closed,
                                             double tolerance_m);

}  // namespace orthodrive::baselines
