// SPDX-License-Identifier: Apache-2.0
#pragma once
// Rasters that lie beside each other as one. Internal to io.

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "orthodrive/core/atomic_file.hpp"
#include "orthodrive/geo/pixel_box.hpp"
#include "orthodrive/geo/polygon.hpp"
#include "orthodrive/io/raster/cut_raster.hpp"
#include "orthodrive/io/support/gdal_support.hpp"

namespace orthodrive::io {

struct JoinedRasters {
  std::unique_ptr<AtomicFile> drawn;     ///< where they had to be drawn on one grid: the file of the mosaic
  std::vector<DatasetPtr> sources;       ///< stay open; of many local ones GDAL opens some at a time, and this is empty
  DatasetPtr mosaic;                     ///< none: there is one source and nothing to add to it
  std::vector<std::string> vrt_options;  ///< of gdalbuildvrt
  std::vector<Polygon> outlines;         ///< of the rasters in their CRS
  std::string vertical_datum;            ///< where their CRSs have one and the mosaic's has none
  [[nodiscard]] GDALDataset& raster() const { return mosaic ? *mosaic : *sources.front(); }
  /// A mosaic's pixels in the window (pixels of the mosaic) that no raster shows become invalid, where the rasters
  /// have no other sign for it: photos get alpha, heights nodata.
  void mark_holes(const std::vector<std::string>& names, const PixelBox& window);
};

/// Opens all. The first lies on top. What fits on one grid is joined as it is; rasters in several CRSs, or of several
/// pixels or types, are drawn into a file beside `to`: draw_rasters(). Throws InputError when one cannot be read, or
/// they do not go together.
[[nodiscard]] JoinedRasters join_rasters(const std::vector<std::string>& names, const SiteFrame& site,
                                         const std::filesystem::path& to, const CutRasterOptions& options);

}  // namespace orthodrive::io
