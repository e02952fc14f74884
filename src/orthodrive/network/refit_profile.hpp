#pragma once
// The profile of a connecting road that lies on its junction's surface, for readers that know roads alone.

#include "roadquery/road_map.hpp"

namespace orthodrive::network {

/// Largest vertical distance of a road's lanes from the surface.
[[nodiscard]] double distance_from_surface_m(const roadquery::Road& road, const roadquery::JunctionSurface& surface);

/// Elevation and superelevation of least squares across the lanes of each cross section, C2 along the road, in pieces
/// of at least 1.5 m, as few as keep the lanes within 2 cm or as near as pieces halved down to 5 mm do; height,
/// gradient and banking at both ends stay, which are the arms'. The lateral shape stays: the superelevation takes up
/// what the surface does not share of a crown.
[[nodiscard]] roadquery::Road refitted(const roadquery::Road& road, const roadquery::JunctionSurface& surface);

}  // namespace orthodrive::network
