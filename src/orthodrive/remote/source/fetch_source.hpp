// SPDX-License-Identifier: Apache-2.0
#pragma once
// A [[fetch]] table of a site file: a source on a server, and the local file that it becomes.

#include <filesystem>
#include <string>
#include <vector>

namespace orthodrive::remote {

enum class FetchKind { wmts, xyz, tms, wms, cog, overpass, osm_extract, raster, stac, atom, sheets };

struct FetchSource {
  FetchKind kind = FetchKind::xyz;
  std::filesystem::path to;       ///< the local file
  std::string to_text;            ///< as the site file has it, for messages
  std::string url;                ///< with {env:NAME} for keys; xyz and tms: a template
  std::vector<std::string> urls;  ///< of raster, cog and sheets, in place of `url`
  std::filesystem::path folder;   ///< of the site file: local paths in `url` are relative to it
  std::string subdomains;         ///< one letter each for {s}
  std::string crs;                ///< of rasters that name none; empty: not told
  std::string layer;  ///< of stac the asset, of atom words of the dataset, of sheets the property with the address
  std::string style, format, tile_matrix_set, time;
  double resolution_m = 0.5;  ///< wanted edge of a pixel on the ground; of rasters 0 = as it is
  int min_zoom = 0, max_zoom = 22;
  std::string licence, attribution;
  std::string vertical_datum, vertical_unit;  ///< of terrain; empty: not known
};

/// "wmts" and so on; throws OptionError that names the kinds.
[[nodiscard]] FetchKind fetch_kind_of(const std::string& name);
[[nodiscard]] const char* name_of(FetchKind kind);
[[nodiscard]] bool is_tiled(FetchKind kind);
/// An index on a server says which files show the area.
[[nodiscard]] bool is_in_sheets(FetchKind kind);
/// Becomes a GeoTIFF on the grid of the source.
[[nodiscard]] bool is_raster(FetchKind kind);

}  // namespace orthodrive::remote
