// SPDX-License-Identifier: Apache-2.0
#pragma once
// The surface of a junction: a height field over its paved area that meets the roads at its arms exactly. Pure
// functions, no allocation in contains() and evaluate(), safe from any thread.
//
// Between the nodes of the grid: bicubic, Catmull-Rom (Keys, Cubic convolution interpolation for digital image
// processing, IEEE Trans. ASSP 29, 1981), C1, exact for planes and quadratic surfaces. Along the arms the field turns
// into the arm's own surface, carried on straight: what OpenDRIVE 1.8 calls the transitionLength of a joint segment
// (12.10). With S the smooth step of fifth degree, the point a_i inside the end line of arm i (its last cross section
// in plan) and b_i beside its strip,
//
//     w_i = (1 - S(a_i / 2 m)) (1 - S(b_i / 1 m))    l_i = w_i / (1 - w_i)    z = (field + sum l_i arm_i) / (1 + sum
//     l_i)
//
// On the end line of an arm its share is 1 and has slope 0, whatever other arms are near (Shepard, A two-dimensional
// interpolation function for irregularly-spaced data, 1968): z and its slope are the road's across the whole cross
// section, crown included. 2 m is how far the network stage ends roads behind the carriageways that they meet.

#include <span>

#include "roadquery/map/road_map.hpp"
#include "roadquery/surface/road_surface.hpp"

namespace roadquery {

struct JunctionHeight {
  double z = 0.0, dz_dx = 0.0, dz_dy = 0.0;
};

constexpr double junction_transition_m = 2.0, beside_arm_m = 1.0;

/// The junction's own surface; null where it has none that a point can lie on.
[[nodiscard]] inline const JunctionSurface* surface_of(const Junction& junction) {
  return junction.surface && junction.surface->boundary.size() >= 3 ? &*junction.surface : nullptr;
}

/// Whether (x, y) lies inside the boundary (even-odd rule; a point on the boundary may count either way).
[[nodiscard]] bool contains(const JunctionSurface& surface, double x, double y);

/// A surface without its boundary, wherever its numbers are kept.
struct JunctionField {
  double x = 0.0, y = 0.0, spacing_m = 1.0;
  int columns = 0, rows = 0;
  const double* z = nullptr;
  std::span<const JunctionArm> arms;
};
[[nodiscard]] inline JunctionField field_of(const JunctionSurface& surface) {
  return {surface.x, surface.y, surface.spacing_m, surface.columns, surface.rows, surface.z.data(), surface.arms};
}

/// Height and slopes, C1 in x and y. Defined everywhere: beyond the grid the field stays as at its border, far from it
/// the value means nothing. NaN without nodes.
[[nodiscard]] JunctionHeight evaluate(const JunctionField& field, double x, double y);
[[nodiscard]] inline JunctionHeight evaluate(const JunctionSurface& surface, double x, double y) {
  return evaluate(field_of(surface), x, y);
}

/// The two steps of evaluate(): the field between four by four nodes, the first of them `first` and a row `columns`
/// long, u_x and u_y, each from 0 to 1, between the second and the third; and the arms.
[[nodiscard]] JunctionHeight evaluate_nodes(const double* first, int columns, double u_x, double u_y,
                                            double inverse_spacing);
[[nodiscard]] JunctionHeight blend_arms(const JunctionHeight& field, std::span<const JunctionArm> arms, double x,
                                        double y);

/// t of the edges of what cars use: lanes from the centre outwards up to a sidewalk, a border or one of type other.
[[nodiscard]] Edges carriageway_edges(const Road& road, double s);

/// The end of a road that a junction begins at. The cross section of its carriageway: edges, reference line and every
/// <shape> between.
[[nodiscard]] JunctionArm junction_arm(const Road& road, ContactPoint end);

/// Height of an arm's strip `in_m` into the junction and `left_m` beside its line, seen into the junction. The arm has
/// at least two places.
[[nodiscard]] double arm_height(const JunctionArm& arm, double in_m, double left_m);
/// How far into the junction the strip begins, `left_m` beside its line: 0 but for a banked road on a slope. The arm
/// has at least two places.
[[nodiscard]] double arm_begin(const JunctionArm& arm, double left_m);

/// Sets the arms of every junction that has a surface: all road ends that are linked to it or, linked to another
/// junction, count somewhere inside its boundary on its level (where two surfaces overlap both turn into the same
/// arms), but for those of short_ways() between two surfaces; by road id, start before end. To be called when roads or
/// surfaces have changed; read_opendrive() and the network stage do.
void join_arms(RoadMap& map);

}  // namespace roadquery
