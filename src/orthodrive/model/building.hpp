#pragma once
// A building as maps know it.

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "orthodrive/geo/polygon.hpp"

namespace orthodrive {

/// https://wiki.openstreetmap.org/wiki/Simple_3D_Buildings
struct Building {
  Polygon footprint;        ///< site CRS
  std::string use = "yes";  ///< OSM's building=*
  double height_m = 0.0;    ///< ground to the top of the roof; 0: not known
  double levels = 0.0;      ///< storeys below the roof; 0: not known
  std::string roof_shape;   ///< OSM's roof:shape; empty: not known
  /// Linear red, green and blue of building:colour or else building:material, and of roof:colour; none: not known.
  std::optional<std::array<float, 3>> wall_color, roof_color;
  std::string osm_id;  ///< "way/123", "relation/45"; empty: not of OSM
};

}  // namespace orthodrive
