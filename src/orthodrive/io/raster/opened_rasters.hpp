// SPDX-License-Identifier: Apache-2.0
#pragma once
// Rasters that are to become one, as they were found: each in its own CRS. Internal to io.

#include <optional>
#include <string>
#include <vector>

#include "orthodrive/io/raster/cut_raster.hpp"
#include "orthodrive/io/support/gdal_support.hpp"

namespace orthodrive::io {

[[nodiscard]] bool is_on_server(const std::string& name);
/// Throws InputError that begins with the name.
[[nodiscard]] DatasetPtr open_raster(const std::string& name, bool of_strangers);
/// Three bands or more of 8 bit.
[[nodiscard]] bool is_photo(GDALDataset& raster);

struct OpenedRaster {
  std::string name;
  DatasetPtr dataset;              ///< null: a file that is opened again when it is read
  OGRSpatialReference horizontal;  ///< of the raster, else as it was told; without heights; empty: nobody knows it
  bool names_crs = false;
  bool has_place = false;
  double c[6] = {0, 1, 0, 0, 0, 1};  ///< where it has a place: as in Georeference
  int width = 0, height = 0, bands = 0;
  GDALDataType type = GDT_Unknown;
  std::vector<GDALColorInterp> colours;  ///< of the bands
  std::optional<double> nodata;          ///< as the first band declares it
  bool palette = false, scaled = false;  ///< of the first band
  std::string vertical_unit;             ///< of the first band, or of its CRS; empty: metres, or not told
  std::string vertical_datum;            ///< of its CRS; empty: not told
  bool compound = false;                 ///< its CRS has heights, too
};

/// Whether they are the same on the map, whatever their names and heights are.
[[nodiscard]] bool same_crs(const OGRSpatialReference& a, const OGRSpatialReference& b);

[[nodiscard]] std::string wkt_of(const OGRSpatialReference& reference);
[[nodiscard]] bool is_north_up(const OpenedRaster& raster);
/// North-up rasters with the same CRS, kinds of bands and pixels, to a hundredth: gdalbuildvrt joins them. Pictures
/// have the same nodata, too; numbers may have several, see nodata_for_all().
[[nodiscard]] bool fit_on_one_grid(const OpenedRaster& a, const OpenedRaster& b);
/// For gdalbuildvrt, which takes the nodata of one raster for that of all: what no sample has, where they differ.
[[nodiscard]] std::vector<std::string> nodata_for_all(const std::vector<const OpenedRaster*>& rasters);
/// A value that no height has.
[[nodiscard]] std::string no_height_of(GDALDataType type);

/// Opens all, in the order of the names. A raster without a CRS has the one that the options tell, else that of the
/// others if these agree. Throws InputError where one cannot be read, and where one among several has none at last.
[[nodiscard]] std::vector<OpenedRaster> open_all(const std::vector<std::string>& names,
                                                 const CutRasterOptions& options);

}  // namespace orthodrive::io
