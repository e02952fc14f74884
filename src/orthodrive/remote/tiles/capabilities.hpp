// SPDX-License-Identifier: Apache-2.0
#pragma once
// What WMTS 1.0.0 (OGC 07-057r7) and WMS 1.1.1 / 1.3.0 (OGC 06-042) servers say of themselves, as their XML has it:
// nothing is looked up, so that any bytes may be given.

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace orthodrive::remote {

struct WmtsMatrix {
  std::string identifier;
  double scale_denominator = 0.0;           ///< with pixels of 0.28 mm
  double corner[2] = {0.0, 0.0};            ///< TopLeftCorner, in the axis order of the CRS
  int tile_width = 256, tile_height = 256;  ///< pixels
  std::int64_t columns = 1, rows = 1;       ///< of tiles
};

struct WmtsMatrixSet {
  std::string identifier, crs;  ///< as written, often an URN
  std::vector<WmtsMatrix> matrices;
};

struct TileLimits {
  std::int64_t min_column = 0, max_column = 0, min_row = 0, max_row = 0;  ///< inclusive
};

struct WmtsLayer {
  std::string identifier;
  std::vector<std::string> styles;  ///< the default first
  std::vector<std::string> formats;
  std::vector<std::string> matrix_sets;
  std::map<std::string, std::map<std::string, TileLimits>> limits;  ///< by matrix set and matrix
  std::map<std::string, std::string> dimensions;                    ///< name (Time) to default value
  std::map<std::string, std::string> resource_urls;                 ///< REST: format to template
};

struct WmtsCapabilities {
  std::vector<WmtsLayer> layers;
  std::vector<WmtsMatrixSet> matrix_sets;
  std::string kvp_url;  ///< GetTile by query; empty: REST only
  std::string attribution;
};

struct WmsLayer {
  std::string name;
  std::vector<std::string> crs;  ///< with those of the layers above it
  bool has_box = false;
  double west = 0.0, south = 0.0, east = 0.0, north = 0.0;  ///< degrees
};

struct WmsCapabilities {
  std::string version;
  std::vector<WmsLayer> layers;  ///< those with a name
  std::vector<std::string> formats;
  std::string map_url;
  int max_width = 0, max_height = 0;  ///< of a picture; 0: not said
};

/// Documents of up to 64 MB, 100 000 layers, 100 levels of WMS layers; entities of a DTD are not expanded. Throws
/// InputError that begins with `name` (an address) for what is no such document: a page of HTML, a service's exception
/// (with its text), truncated XML.
[[nodiscard]] WmtsCapabilities parse_wmts_capabilities(std::string_view xml, const std::string& name);
[[nodiscard]] WmsCapabilities parse_wms_capabilities(std::string_view xml, const std::string& name);

/// "EPSG:n" of "urn:ogc:def:crs:EPSG::n", "EPSG:n", "http://www.opengis.net/def/crs/EPSG/0/n"; the old names of web
/// mercator (900913, 102100, 3785) become EPSG:3857. "OGC:CRS84" stays. Empty for what has no code.
[[nodiscard]] std::string crs_code_of(const std::string& text);

/// Names in the order of their likeness to `wanted` (edit distance without case; a part of the other counts as near).
[[nodiscard]] std::vector<std::string> by_likeness(std::vector<std::string> names, const std::string& wanted);

}  // namespace orthodrive::remote
