// SPDX-License-Identifier: Apache-2.0
#pragma once
// Which tiles of which service an area needs.

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "orthodrive/model/site_frame.hpp"
#include "orthodrive/remote/http/http_client.hpp"
#include "orthodrive/remote/http/secrets.hpp"
#include "orthodrive/remote/source/fetch_source.hpp"
#include "orthodrive/remote/tiles/tile_matrix.hpp"

namespace orthodrive::remote {

/// More is refused: at 256 pixels and 0.3 m these are 11 000 km2.
constexpr std::size_t most_tiles = 2000000;

struct TilePlan {
  Crs crs;
  TileMatrix matrix;
  std::optional<int> zoom;  ///< of web mercator's quad: MBTiles can hold it
  double gsd_m = 0.0;       ///< on the ground in the middle of the area
  std::vector<TileAddress> tiles;
  std::function<std::string(TileAddress)> url_of;  ///< with keys
  std::string identity;  ///< what tells tiles of one service and level from others, without keys
  std::string format;    ///< MIME type asked for; empty: as the service likes
  std::string matrix_set;
  double estimated_mb = 0.0;
};

/// Asks a WMTS or WMS for its capabilities; xyz and tms need none. Throws InputError or OptionError with one line on
/// what to do: no such layer, no grid that can be used, an area off the grid or across the antimeridian, too many
/// tiles.
[[nodiscard]] TilePlan plan_tiles(const FetchSource& source, const SiteFrame& site, HttpClient& client,
                                  Secrets& secrets);

/// The area and a margin around it, in another CRS. Throws InputError (of `name`) across the antimeridian, where web
/// mercator ends, and for an empty area.
[[nodiscard]] Polygon area_in(const SiteFrame& site, const Crs& crs, double margin_m, const std::string& name);
/// The box of that in degrees.
[[nodiscard]] Box2 lonlat_box(const SiteFrame& site, double margin_m, const std::string& name);

}  // namespace orthodrive::remote
