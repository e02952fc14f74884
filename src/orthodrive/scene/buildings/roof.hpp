// SPDX-License-Identifier: Apache-2.0
#pragma once
// Roofs over footprints.

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "orthodrive/geo/polygon.hpp"

namespace orthodrive::scene {

/// As OSM's roof:shape names them; cones are pyramids over round footprints.
enum class RoofShape : std::uint8_t {
  flat,
  skillion,
  gabled,
  half_hipped,
  hipped,
  pyramidal,
  gambrel,
  mansard,
  saltbox,
  round,
  dome,
  onion,
};
/// Nothing for names that are none.
[[nodiscard]] std::optional<RoofShape> roof_shape_of(std::string_view name);

/// Heights are over the eaves.
struct Roof {
  RoofShape shape = RoofShape::flat;  ///< what was possible
  double rise_m = 0.0;                ///< from the eaves to the ridge
  std::vector<std::array<Vec3, 3>> slopes;
  std::vector<std::array<Vec3, 3>> gables;  ///< upright, over walls
  std::array<Vec3, 2> ridge{};              ///< its ends; both the same without one
};

struct RoofWish {
  RoofShape shape = RoofShape::flat;
  double pitch = 0.7;         ///< tangent of the slopes
  double max_rise_m = 100.0;  ///< the pitch is less where the roof would rise higher
  double rise_m = 0.0;        ///< instead of both, where it is positive
  /// Down the slope of a skillion roof, across the ridge of gabled ones; of the footprint's two directions the nearer
  /// one counts.
  std::optional<Vec2> downwards;
  bool ridge_across = false;  ///< the ridge lies across the longer side
};

/// A roof over a footprint as overlays give them (outer counter-clockwise, holes clockwise, on the plan grid).
/// - Skillion, gabled, gambrel, saltbox and round ones have a profile across the ridge, which lies along the longer
///   side of the narrowest rectangle around the footprint. Gabled ones only over footprints that fill 85 % of it,
///   others become hipped; half-hipped ones over rectangles (four corners within 12 degrees of a right angle).
/// - Hipped: every edge of the footprint is an eave, by the straight skeleton (Aichholzer et al., A novel type of
///   skeleton for polygons, 1995; CGAL). Mansard: a steep slope of 0.25 of the width around a hipped roof.
/// - Pyramidal ones, domes and onions rise around the centroid, which must see every edge; others become hipped.
/// Footprints of more than 40 corners (200 for profiles and what rises around the centroid), that touch themselves, or
/// whose skeleton fails or crosses itself, are flat.
[[nodiscard]] Roof make_roof(const Polygon& footprint, const RoofWish& wish);

}  // namespace orthodrive::scene
