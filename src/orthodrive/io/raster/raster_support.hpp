// SPDX-License-Identifier: Apache-2.0
#pragma once
// Shared by the raster readers and writers of io: wrapping our rasters as GDAL datasets, georeferencing, completeness.

#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "orthodrive/geo/raster.hpp"
#include "orthodrive/io/raster/raster_io.hpp"
#include "orthodrive/io/support/gdal_support.hpp"
#include "orthodrive/model/rasters/class_table.hpp"

namespace orthodrive::io {

/// Metadata of a raster of heights: their datum, where its CRS names none.
inline constexpr const char* vertical_datum_item = "VERTICAL_DATUM";

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

/// WGS84, densified: its edges bend.
[[nodiscard]] Polygon outline_lonlat(const Georeference& georeference, int width, int height);
/// To a centimetre.
[[nodiscard]] double rounded_gsd_m(double gsd_m);
/// Options of gdalwarp: how a raster of that pixel size goes to `gsd_m`. GDAL would guess the scale from the windows,
/// which a turned grid makes larger: it would blur a photo that only changes its CRS.
[[nodiscard]] std::vector<std::string> cubic_resampling(const PixelSize& source, double gsd_m);
/// A view of the source, which must outlive it, by options of gdal_translate.
[[nodiscard]] DatasetPtr translate_to_vrt(GDALDataset& source, std::vector<std::string> arguments);

/// Throws InputError when a block of a GeoTIFF lies beyond the end of the file: GDAL opens such a file without a word.
void require_complete(const std::filesystem::path& path, GDALDataset& dataset);

/// A dataset without bands of the size and place of the frame, for wrap_channels.
[[nodiscard]] DatasetPtr memory_dataset(int width, int height);
void place(GDALDataset& dataset, const GridFrame& frame, const Crs& crs);
/// Palette, nodata and class table of a label map.
void dress_as_labels(GDALDataset& dataset, const ClassTable& classes);
/// Colours of the bands, the fourth alpha.
void dress_as_photo(GDALDataset& dataset);
/// NaN is nodata.
void dress_as_dtm(GDALDataset& dataset);
[[nodiscard]] std::vector<std::string> photo_cog_options(const WritePhotoOptions& options);
const std::vector<std::string>& dtm_cog_options();
const std::vector<std::string>& label_cog_options();
const std::vector<std::string>& confidence_cog_options();
/// Writes the copy aside, then puts it in the target's place. Throws Error naming the target.
void create_copy(const std::filesystem::path& target, const char* driver_name, GDALDataset& source,
                 const std::vector<std::string>& options);
/// Adds one band a channel that reads and writes the raster's memory. The raster must outlive the dataset.
template <typename T>
void wrap_channels(GDALDataset& dataset, Raster<T>& raster);

}  // namespace orthodrive::io
