// SPDX-License-Identifier: Apache-2.0
#pragma once
// What roads are built for, by highway class: how fast they are driven, and what their profiles may do.

#include <string>

namespace orthodrive {

struct DesignLimits {
  double design_speed_kmh = 0.0;  ///< bounds curves, crests and banking
  double gradient = 0.0;          ///< largest, up or down
  double crest_radius_m = 0.0;    ///< least; curvature d2z/ds2 >= -1 / crest_radius_m
  double sag_radius_m = 0.0;      ///< least; curvature d2z/ds2 <= 1 / sag_radius_m
  bool is_local = false;          ///< a street with houses, a driveway or a track, not banked in curves
};

/// Minima for existing roads of the class, in towns as in hills: OSM's class does not say where a road lies. Unknown
/// values count as service.
[[nodiscard]] DesignLimits design_limits(const std::string& highway);

/// Vertical curvature (1/m) at which an occupant feels 0.3 m/s2: what drivers find comfortable (AASHTO, A Policy on
/// Geometric Design of Highways and Streets, 2011, sec. 3.4.6, sag curves by comfort). What a road usually keeps to.
[[nodiscard]] double comfortable_curvature_1pm(double design_speed_kmh);
/// Least length of a vertical curve, m: 0.6 V (the same, sec. 3.4.6).
[[nodiscard]] double vertical_curve_length_m(double design_speed_kmh);

}  // namespace orthodrive
