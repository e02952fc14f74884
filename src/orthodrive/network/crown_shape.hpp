#pragma once
// A crown that changes along a road as <shape> entries of OpenDRIVE.

#include <span>
#include <vector>

#include "roadquery/road_map.hpp"

namespace orthodrive::network {

/// Two straight halves that fall away from the reference line by `fall` (m/m, cubics of s): h(t) = -fall |t|. Shapes
/// are linear in s between their knots (1.7, 9.4.3): knots lie so near to each other that this misses the cubics by
/// 1e-4 at most and that the gradient jumps by 0.1 % at most at a knot, 4 m off the reference line. Empty for no fall.
[[nodiscard]] std::vector<roadquery::ShapeCubic> crown_shape(std::span<const roadquery::Cubic> fall, double length_m);

}  // namespace orthodrive::network
