// SPDX-License-Identifier: Apache-2.0
#pragma once
// Rasters that lie beside each other as one. Internal to io.

#include <string>
#include <vector>

#include "orthodrive/geo/pixel_box.hpp"
#include "orthodrive/geo/polygon.hpp"
#include "orthodrive/io/raster/cut_raster.hpp"
#include "orthodrive/io/support/gdal_support.hpp"

namespace orthodrive::io {

[[nodiscard]] bool is_on_server(const std::string& name);
/// Throws InputError that begins with the name.
[[nodiscard]] DatasetPtr open_raster(const std::string& name, bool of_strangers);
/// Three bands or more of 8 bit.
[[nodiscard]] bool is_photo(GDALDataset& raster);

struct JoinedRasters {
  std::vector<DatasetPtr> sources;       ///< stay open; of many local ones GDAL opens some at a time, and this is empty
  DatasetPtr mosaic;                     ///< none: there is one source and nothing to add to it
  std::vector<std::string> vrt_options;  ///< of gdalbuildvrt
  std::vector<Polygon> outlines;         ///< of the rasters in their CRS
  [[nodiscard]] GDALDataset& raster() const { return mosaic ? *mosaic : *sources.front(); }
  /// A mosaic's pixels in the window (pixels of the mosaic) that no raster shows become invalid, where the rasters
  /// have no other sign for it: photos get alpha, heights nodata.
  void mark_holes(const std::vector<std::string>& names, const PixelBox& window);
};

/// Opens all. The first lies on top. Throws InputError when one cannot be read or has another CRS than the first.
[[nodiscard]] JoinedRasters join_rasters(const std::vector<std::string>& names, const CutRasterOptions& options);

}  // namespace orthodrive::io
