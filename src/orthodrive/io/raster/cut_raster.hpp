// SPDX-License-Identifier: Apache-2.0
#pragma once
// The part of large rasters, here or on a server, that a site needs.

#include <filesystem>
#include <string>
#include <vector>

#include "orthodrive/model/site_frame.hpp"

namespace orthodrive::io {

struct CutRasterOptions {
  double margin_m = 100.0;                  ///< around the area
  double gsd_m = 0.0;                       ///< 0 or finer than the raster: its own pixels
  std::string vertical_unit;                ///< of heights, "m", "ft" or "us-ft": where the raster does not say it
  std::string vertical_datum;               ///< kept in the file, read_dtms() tells it; empty: not known
  std::vector<std::string> crs_by_default;  ///< of each raster that names no CRS, in the order of the names
  bool of_strangers = false;  ///< names were read in answers of a server: no file may lead on to other files
  int attempts = 8;           ///< of a request to a server
  double stall_s = 30.0;
};
struct CutRaster {
  Crs crs;
  double gsd_m = 0.0;
  int width = 0, height = 0;
};

/// Writes a cloud-optimised GeoTIFF of the part around the area, on the raster's own grid. Several rasters are joined;
/// the first covers the later ones, and what none of them shows is invalid. Those in several CRSs are brought to the
/// site's, with the finest pixels; those that name no CRS have the one told, else that of the others. Of servers GDAL
/// reads ranges, not whole files. Names are GDAL's; those of http(s) may be files alone, no lists that lead on to other
/// files. Throws InputError where they show nothing of the area, and for more pixels than a file can be expected to
/// hold.
CutRaster cut_raster(const std::vector<std::string>& names, const SiteFrame& site, const std::filesystem::path& to,
                     const CutRasterOptions& options);

}  // namespace orthodrive::io
