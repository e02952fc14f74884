#pragma once
// How fast the roads of a class are built to be driven: what bounds their curves, crests and superelevation.

#include <string>

namespace orthodrive {

/// Design speed in km/h by highway value; unknown values count as service.
/// RAL 2012 table 7: EKL 1 - 4 have 110, 100, 90, 70 km/h; RASt 06: 50 and 70 km/h on main streets without frontages.
/// RAA 2008: 120 - 130 km/h on motorways, 40 - 80 km/h on ramps. OSM does not tell whether a primary or secondary road
/// is inside a town, so these get the value between the two.
[[nodiscard]] double design_speed_kmh(const std::string& highway);

/// Streets with houses, where speeds are low and nobody superelevates: residential, living_street, service, track,
/// unknown.
[[nodiscard]] bool is_local_street(const std::string& highway);

}  // namespace orthodrive
