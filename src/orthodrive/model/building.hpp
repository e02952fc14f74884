// SPDX-License-Identifier: Apache-2.0
#pragma once
// A building as maps know it.

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "orthodrive/geo/polygon.hpp"

namespace orthodrive {

/// A building or, where the map has them, a part of one.
/// https://wiki.openstreetmap.org/wiki/Simple_3D_Buildings
struct Building {
  Polygon footprint;          ///< site CRS
  std::string use = "yes";    ///< OSM's building=*; of parts that of building:part=*
  bool is_part = false;       ///< building:part=*: parts stand for the building whose outline they lie in
  bool has_walls = true;      ///< not building=roof and carport: roofs on posts
  double height_m = 0.0;      ///< ground to the top of the roof; 0: not known
  double min_height_m = 0.0;  ///< ground to where it begins; less than the height where that is known
  double levels = 0.0;        ///< storeys below the roof, counted from the ground; 0: not known
  std::string roof_shape;     ///< OSM's roof:shape; empty: not known
  double roof_height_m = 0.0, roof_levels = 0.0, roof_angle_rad = 0.0;  ///< 0: not known
  std::optional<double> roof_direction_rad;                             ///< down the slope, counter-clockwise from east
  bool ridge_across = false;            ///< roof:orientation=across: the ridge lies across the longer side
  std::string material, roof_material;  ///< building:material, roof:material; empty: not known
  /// Linear red, green and blue of building:colour or else building:material, and of roof:colour or else roof:material;
  /// none: not known.
  std::optional<std::array<float, 3>> wall_color, roof_color;
  std::string osm_id;  ///< "way/123", "relation/45"; empty: not of OSM
};

}  // namespace orthodrive
