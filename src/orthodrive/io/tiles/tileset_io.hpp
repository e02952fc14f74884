// SPDX-License-Identifier: Apache-2.0
#pragma once
// The tree of the tiles: tileset.json of 3D Tiles 1.1.

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "orthodrive/core/finding.hpp"
#include "orthodrive/geo/crs.hpp"
#include "orthodrive/geo/geoid.hpp"
#include "orthodrive/geo/vec.hpp"

namespace orthodrive::io {

/// What tileset.json needs of a tile once its glb is written.
struct TileEntry {
  std::string uri;
  int level = 0, column = 0, row = 0;  ///< as in SceneTile
  Vec3 origin;                         ///< site CRS: of the positions in the file
  Box2 bounds;                         ///< site CRS
  double min_z_m = 0.0, max_z_m = 0.0;
  double geometric_error_m = 0.0;  ///< of the tile drawn in place of finer ones
};

/// Metres of the site CRS around a place to earth-centred metres.
struct Placement {
  Vec3 east, north, up, at;
  [[nodiscard]] Vec3 ecef(Vec3 local) const { return at + east * local.x + north * local.y + up * local.z; }
};
/// Tangent at `origin` to the surface of equal height: turned by the meridian convergence, stretched in plan by the
/// scale of the projection. Heights of the site CRS count from the geoid and are not stretched.
[[nodiscard]] Placement placement_at(const CoordinateTransform& lonlat_from_site, const Geoid& geoid, Vec3 origin);

/// A tree of the entries: a tile's parent is the one of the level above at (column / 2, row / 2); each tile has its own
/// placement_at(). asset.extras holds {"orthodrive": {"crs", "origin": [x, y, z]}}, each tile's extras its own origin
/// less that of the site, so that a viewer can place all in the site CRS. The order of the entries does not matter.
/// Finding "scene.no_geoid" where heights count from the ellipsoid because PROJ has no grid.
void write_tileset(const std::filesystem::path& folder, const std::vector<TileEntry>& tiles, const Crs& crs,
                   Vec3 site_origin, Findings& findings);

}  // namespace orthodrive::io
