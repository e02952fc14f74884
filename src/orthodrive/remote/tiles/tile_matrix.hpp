// SPDX-License-Identifier: Apache-2.0
#pragma once
// Grids of map tiles (OGC Two Dimensional Tile Matrix Set, 17-083r2): address <-> place.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "orthodrive/geo/crs.hpp"
#include "orthodrive/geo/polygon.hpp"

namespace orthodrive::remote {

/// One level. Columns count to the east, rows to the south, from the outer corner of the first tile.
struct TileMatrix {
  std::string identifier;
  double resolution = 1.0;  ///< edge of a pixel in units of the CRS
  double left = 0.0, top = 0.0;
  int tile_width = 256, tile_height = 256;
  std::int64_t columns = 1, rows = 1;
};

struct TileMatrixSet {
  std::string identifier;
  Crs crs;
  std::vector<TileMatrix> matrices;  ///< coarsest first
};

struct TileAddress {
  std::int64_t column = 0, row = 0;
  friend auto operator<=>(const TileAddress&, const TileAddress&) = default;
};

/// Half the equator of WGS84's sphere in web mercator, m: where its square ends.
constexpr double web_mercator_half = 20037508.342789244;
/// The latitude at which that square ends, degrees.
constexpr double web_mercator_latitude = 85.0511287798066;

/// EPSG:3857 cut in four a level, 256 pixels a tile: what XYZ, TMS and MBTiles count in. Identifiers are the levels.
[[nodiscard]] TileMatrixSet web_mercator_quad(int min_zoom, int max_zoom);
/// The level of the quad that a matrix of EPSG:3857 is; none where it is another grid.
[[nodiscard]] std::optional<int> quad_zoom(const TileMatrix& matrix);

/// In units of the CRS.
[[nodiscard]] Box2 bounds_of_tile(const TileMatrix& matrix, TileAddress tile);

/// Tiles that have a part of the polygon (in the CRS of the matrix), by row, then column. Counts only: no list is made
/// of more than `most`, nullopt then.
[[nodiscard]] std::optional<std::vector<TileAddress>> tiles_over(const TileMatrix& matrix, const Polygon& area,
                                                                 std::size_t most);
/// Tiles that the box of the polygon has: an upper bound of the above.
[[nodiscard]] double most_tiles_over(const TileMatrix& matrix, const Polygon& area);

/// Index of the coarsest matrix whose pixel is at most so large (in units of the CRS), else of the finest. A thousandth
/// too large counts as fine enough. There must be one.
[[nodiscard]] std::size_t fine_enough(const TileMatrixSet& set, double resolution);

}  // namespace orthodrive::remote
