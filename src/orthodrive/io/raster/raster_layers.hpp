// SPDX-License-Identifier: Apache-2.0
#pragma once
// Rasters in several CRSs, or of several kinds, drawn on one grid. Internal to io.

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "orthodrive/core/atomic_file.hpp"
#include "orthodrive/io/raster/opened_rasters.hpp"

namespace orthodrive::io {

/// A box around the area and `margin_m` in a CRS: its edges bend there.
[[nodiscard]] Box2 box_in_crs(const SiteFrame& site, double margin_m, const OGRSpatialReference& reference);
/// Throws InputError for more than a file can be expected to hold.
void require_possible_pixels(const std::string& name, double pixels, double gsd_m);
/// As gdalbuildvrt makes it. Names are in the order of precedence; open datasets take the place of names.
[[nodiscard]] DatasetPtr built_vrt(const std::vector<std::string>& names, const std::vector<DatasetPtr>& sources,
                                   const std::vector<std::string>& extra);

/// A raster that lies in a temporary file of its own, which goes with it.
struct DrawnRaster {
  std::unique_ptr<AtomicFile> file;
  DatasetPtr raster;
};

/// Draws the part around the area, the first raster on top: photos with alpha (8 bit), else one band of heights
/// (Float32, NaN where there is none). Their common CRS stays, with the grid of the finest; several become the site's.
/// Neighbours of one CRS are joined before they are resampled: no step along their edges. Heights are never shifted to
/// another datum. The file lies beside `to`. Throws InputError where the area has none of them, and for rasters that
/// do not go together.
[[nodiscard]] DrawnRaster draw_rasters(std::vector<OpenedRaster>& rasters, const SiteFrame& site,
                                       const std::filesystem::path& to, const CutRasterOptions& options);

}  // namespace orthodrive::io
