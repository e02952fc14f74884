// SPDX-License-Identifier: Apache-2.0
#pragma once
// The ground between surveyed heights.

#include <vector>

#include "orthodrive/geo/raster.hpp"
#include "orthodrive/geo/vec.hpp"

namespace orthodrive::synth {

/// Heights on a coarse grid, bicubic between (Catmull-Rom), so continuously differentiable.
struct HeightField {
  GridFrame frame;
  std::vector<double> height_m;  ///< row-major
  [[nodiscard]] double at(Vec2 p) const;
};

/// Gaussian process regression (Rasmussen and Williams, Gaussian Processes for Machine Learning, 2006, alg. 2.1) about
/// the plane that fits best, with exp(-d^2 / 2 l^2), l = 250 m, and a noise of 6 m: heights from the web come from
/// coarse cells and jump. Far from all points the ground is the plane. O(n^3) in the number of points, which may lie on
/// each other.
[[nodiscard]] HeightField fit_heights(const std::vector<Vec3>& points, const Box2& box);

}  // namespace orthodrive::synth
