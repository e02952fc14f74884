#pragma once
// Shared by the raster readers and writers of io: wrapping our rasters as GDAL datasets, georeferencing, completeness.

#include <cmath>

#include "orthodrive/geo/raster.hpp"
#include "orthodrive/io/gdal_support.hpp"

namespace orthodrive::io {

/// x = c[0] + col c[1] + row c[2], y = c[3] + col c[4] + row c[5], as GDAL has it.
struct Georeference {
  double c[6] = {0, 1, 0, 0, 0, 1};
  OGRSpatialReference reference;
};
/// Throws InputError, with the remedy, when the raster has no geotransform or no CRS.
[[nodiscard]] Georeference georeference_of(const std::filesystem::path& path, GDALDataset& dataset);
/// Throws InputError unless the raster lies north-up, with square pixels, in a CRS in metres.
[[nodiscard]] GridFrame north_up_frame(const std::filesystem::path& path, GDALDataset& dataset);
/// Edges of the pixel at the centre of the raster on the ground, whatever the CRS's unit.
struct PixelSize {
  double along_row_m = 0.0, along_column_m = 0.0;
  [[nodiscard]] double gsd_m() const { return std::sqrt(along_row_m * along_column_m); }
};
[[nodiscard]] PixelSize pixel_size(const Georeference& georeference, int width, int height);

/// Throws InputError when a block of a GeoTIFF lies beyond the end of the file: GDAL opens such a file without a word.
void require_complete(const std::filesystem::path& path, GDALDataset& dataset);

/// A dataset without bands of the size and place of the frame, for wrap_channels.
[[nodiscard]] DatasetPtr memory_dataset(int width, int height);
void place(GDALDataset& dataset, const GridFrame& frame, const Crs& crs);
/// Adds one band a channel that reads and writes the raster's memory. The raster must outlive the dataset.
template <typename T>
void wrap_channels(GDALDataset& dataset, Raster<T>& raster);

}  // namespace orthodrive::io
