// SPDX-License-Identifier: Apache-2.0
#pragma once
// Evaluation of roads: reference line, profile, lanes, surface. Pure functions, no allocation, safe from any thread.

#include <span>

#include "roadquery/map/road_map.hpp"

namespace roadquery {

struct PlanPoint {
  double x = 0.0, y = 0.0, hdg = 0.0, curvature = 0.0;
  double speed = 1.0;  ///< |d(x, y)/ds|: 1 except in a ParamPoly3 whose curve is not as long as the element says
};
struct SurfacePoint {
  double x = 0.0, y = 0.0, z = 0.0;
  double normal[3] = {0.0, 0.0, 1.0};  ///< unit, upwards
};

/// Point of one element at distance ds from its start.
[[nodiscard]] PlanPoint evaluate(const PlanElement& element, double ds);
/// Reference line at s, clamped to [0, length].
[[nodiscard]] PlanPoint reference_point(const Road& road, double s);
/// Value of a piecewise cubic at s; 0 when empty and before the first one starts.
[[nodiscard]] double evaluate(std::span<const Cubic> cubics, double s);
[[nodiscard]] double derivative(std::span<const Cubic> cubics, double s);
[[nodiscard]] double second_derivative(std::span<const Cubic> cubics, double s);

[[nodiscard]] double elevation(const Road& road, double s);
[[nodiscard]] double gradient(const Road& road, double s);        ///< dz/ds of the reference line
[[nodiscard]] double superelevation(const Road& road, double s);  ///< rad
[[nodiscard]] double lane_width(const Lane& lane, double s_in_section);
/// The section at s; roads have at least one.
[[nodiscard]] const LaneSection& section_at(const Road& road, double s);
/// t of the outer edges of the carriageway (sum of the lane widths and the lane offset): left >= right.
struct Edges {
  double left_t = 0.0, right_t = 0.0;
};
[[nodiscard]] Edges road_edges(const Road& road, double s);
/// Id of the lane at (s, t); 0 beside the lanes, and in a section without lanes on that side.
[[nodiscard]] int lane_id_at(const Road& road, double s, double t);
/// Height of the lateral profile over the superelevated plane, and its derivatives; 0 for roads without shapes and
/// before the first one.
struct ShapePoint {
  double h = 0.0, dh_ds = 0.0, dh_dt = 0.0;
};
[[nodiscard]] ShapePoint shape(const Road& road, double s, double t);
/// t of the point of the cross section at s that lies `left_m` horizontally to the left of the reference line.
[[nodiscard]] double t_at(const Road& road, double s, double left_m);
/// A cross section of a road and the place on it.
struct RoadPosition {
  double s = 0.0, t = 0.0;
  double beyond_m = 0.0;  ///< 0: on it; else it is at the road's end, and the point lies this far ahead (< 0: behind)
};
/// The surface over (x, y), by Newton's method from s_near on. Beside the lanes their lateral profile goes on. Where
/// the road folds, beyond its centre of curvature, the method may end at any s, and beyond_m says what it missed by.
[[nodiscard]] RoadPosition position_over(const Road& road, double x, double y, double s_near);
/// Heights of a lane over the road's surface at its inner and outer border, and how they change per metre of s.
struct LaneHeightAt {
  double value[2] = {}, rise[2] = {};
};
[[nodiscard]] LaneHeightAt lane_height_at(std::span<const LaneHeight> heights, double s_in_section);
/// Height of the lane at (s, t) over the road's surface, along z, and its derivatives; 0 beside the lanes.
[[nodiscard]] ShapePoint lane_height(const Road& road, double s, double t);
/// The roads' surfaces as if no lane lay higher than them.
void remove_lane_heights(RoadMap& map);
/// z of surface_point, for less.
[[nodiscard]] double surface_height(const Road& road, double s, double t);
/// Surface at (s, t): the reference point, moved by t along the left normal turned by the superelevation about the
/// tangent with its slope, and by the shape at right angles to both (cross_section.hpp); lanes with heights lie so much
/// higher, along z.
[[nodiscard]] SurfacePoint surface_point(const Road& road, double s, double t);
/// The same for who has the reference point at s already.
[[nodiscard]] SurfacePoint surface_point(const Road& road, double s, double t, const PlanPoint& reference);

}  // namespace roadquery
