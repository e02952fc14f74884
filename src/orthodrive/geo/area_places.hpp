// SPDX-License-Identifier: Apache-2.0
#pragma once
// Places that stand for an area, however small or thin it is.

#include <functional>

#include "orthodrive/geo/polygon.hpp"

namespace orthodrive {

/// Calls visit(p) for places all over the area: the pixel centres inside it of a grid of `step_m`, or of a finer one
/// where that gives fewer than 400. An area without width, such as the hull of one straight road, is visited along its
/// outline. At least one place where the outer ring has a point; order and places depend on the arguments alone.
void visit_area(const Polygon& area, double step_m, const std::function<void(Vec2)>& visit);

}  // namespace orthodrive
