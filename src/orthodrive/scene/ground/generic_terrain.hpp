// SPDX-License-Identifier: Apache-2.0
#pragma once
// A terrain for roads alone, where no terrain model is given.
//
// The thesis (sec. 4.1) makes a "generic landscape" of a reference line, so that the vertical tension between the road
// and its surroundings is least. We take that as a membrane: the heights z(x, y) with the least integral of |grad z|^2,
// which equal the roads' on the ground, lie below the decks of bridges and over tunnels, and end level at the rim. So
// no ground is higher than the highest road or lower than the lowest one, but for the cover of tunnels and the
// clearance below decks. Solved on a raster by projected successive over-relaxation (Cryer, The solution of a quadratic
// programming problem using systematic overrelaxation, 1971) in red-black order, from the coarsest raster on.

#include <string>

#include "orthodrive/geo/polygon.hpp"
#include "orthodrive/model/rasters/rasters.hpp"
#include "roadquery/map/road_map.hpp"

namespace orthodrive::scene {

struct GenericTerrainOptions {
  double cell_m = 5.0;       ///< edge of a cell
  double most_cells = 16e6;  ///< cells are larger where the area has more
};

/// Convex hull of the roads and all that lies within margin_m of them: the area where no other is given. Throws
/// InputError for roads without any surface and for those over 200 km apart. `name`: of their file.
[[nodiscard]] Polygon area_around_roads(const roadquery::RoadMap& roads, double margin_m, const std::string& name);

/// Heights over the box. Throws InputError as above.
[[nodiscard]] HeightGrid generic_terrain(const roadquery::RoadMap& roads, const Box2& box, const std::string& name,
                                         const GenericTerrainOptions& options = {});

}  // namespace orthodrive::scene
