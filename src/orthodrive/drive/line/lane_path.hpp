// SPDX-License-Identifier: Apache-2.0
#pragma once
// The raw way along a route: points on the roads, not yet a line that a car can follow.

#include <vector>

#include "orthodrive/core/error.hpp"
#include "orthodrive/drive/routes/route.hpp"
#include "orthodrive/geo/polyline.hpp"
#include "roadquery/surface/road_surface.hpp"

namespace orthodrive {

/// Long enough for a car to stand on and to move.
inline constexpr double least_route_m = 6.0;

/// A route below least_route_m: nothing to drive on.
struct TooShortError : Error {
  using Error::Error;
};

/// A way in steps of 1 m (nearly; all steps of one path are alike).
struct LanePath {
  bool closed = false;  ///< the last point leads to the first, which is not repeated
  Polyline points;
  std::vector<double> half_width_m;  ///< of the lanes that may be used, to both sides of the point
  std::vector<int> step;             ///< which step of the route each point is on
};

/// Along the centres of the outermost driving lanes (on narrow roads nearer to the middle). Where the centres of two
/// steps do not meet, the jump is made up over 12 m a metre of it on the road that has room for it (half on each when
/// both or neither have). Throws TooShortError for a way below least_route_m.
[[nodiscard]] LanePath path_along_lanes(const roadquery::RoadMap& map, const Route& route);

/// Along the middle of all driving lanes of each road; jumps are made up as above. Throws as above.
[[nodiscard]] LanePath path_along_centre(const roadquery::RoadMap& map, const Route& route);

/// Along the middle of all driving lanes of each road, jumps and all, where the whole width may be used. Throws as
/// above.
[[nodiscard]] LanePath path_along_middle(const roadquery::RoadMap& map, const Route& route);

/// Outer borders of the outermost driving lanes: sidewalks and shoulders are no room to drive in.
[[nodiscard]] roadquery::Edges driving_edges(const roadquery::Road& road, double s);

}  // namespace orthodrive
