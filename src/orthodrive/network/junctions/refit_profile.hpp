// SPDX-License-Identifier: Apache-2.0
#pragma once
// The profile of a connecting road that lies on its junction's surface, for readers that know roads alone.

#include "roadquery/surface/road_surface.hpp"

namespace orthodrive::network {

/// Largest vertical distance of a road's lanes from the surface.
[[nodiscard]] double distance_from_surface_m(const roadquery::Road& road, const roadquery::JunctionSurface& surface);

/// Between the edges of lanes at s, straight through the air: a little more than their widths say across a crown.
/// `sign`: -1 where the lanes are counted against the road's direction.
[[nodiscard]] double distance_across_m(const roadquery::Road& road, double s, double sign,
                                       const roadquery::Edges& lanes);

/// What a profile has at one end of a road, along s.
struct ProfileEnd {
  double z = 0.0, gradient = 0.0, banking = 0.0;  ///< m, 1, rad
};
/// Of a road that goes on from one end of `other` with its reference line at t and its lanes between left and right, t
/// counted on `other` to the left of the direction in which the road runs; `sign`: -1 where that is against other's s.
/// Height and banking are those of the straight line through the edges of the lanes, the gradient is other's at t.
[[nodiscard]] ProfileEnd end_beside(const roadquery::Road& other, bool at_end, double sign, double t,
                                    const roadquery::Edges& lanes);

struct ProfileEnds {
  ProfileEnd start, end;
};
/// What lies on the surface there, over the lanes: the same for all roads with these lanes, whatever their direction.
[[nodiscard]] ProfileEnd end_on(const roadquery::Road& road, const roadquery::JunctionSurface& surface, bool at_end);

/// Elevation and superelevation of least squares across the lanes of each cross section, C2 along the road, in pieces
/// of at least 1.5 m, as few as keep the lanes within 5 mm or as near as pieces halved down to that do, with the ends
/// given: the arms'. The lateral shape stays: the superelevation takes up what the surface does not share of a crown.
[[nodiscard]] roadquery::Road refitted(const roadquery::Road& road, const roadquery::JunctionSurface& surface,
                                       const ProfileEnds& ends);

}  // namespace orthodrive::network
