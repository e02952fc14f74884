#pragma once
// Rasters: files <-> model, through GDAL. All reading ends in the site CRS; all writing goes aside first.

#include <filesystem>
#include <optional>
#include <span>

#include "orthodrive/model/rasters.hpp"
#include "orthodrive/model/site_frame.hpp"

namespace orthodrive::io {

struct RasterInfo {
  Crs crs;
  int width = 0, height = 0, bands = 0;
  double gsd_m = 0.0;          ///< ground sampling distance at the centre, in metres whatever the CRS's unit
  Polygon outline_lonlat;      ///< WGS84, densified
};
/// Throws InputError when the file is missing, not a raster, truncated, or without georeferencing.
[[nodiscard]] RasterInfo raster_info(const std::filesystem::path& path);

struct ReadPhotoOptions {
  double gsd_m = 0.0;  ///< 0: the photo's own, rounded to a centimetre
  int threads = 0;
};
/// Warps the photo (cubic; average when it is much finer than gsd_m) onto the covering grid of the area's bounds.
/// valid is 0 outside the source, at its nodata / alpha / mask, and outside the area polygon.
[[nodiscard]] Photo read_photo(const std::filesystem::path& path, const SiteFrame& site, const ReadPhotoOptions& options = {});
/// The photo as it is, on its own grid. It must be north-up in a metric CRS (as synth and read_photo make them).
[[nodiscard]] Photo read_photo_native(const std::filesystem::path& path);

/// Reads the first DTM that covers and fills nodata holes of it from the next ones. A DTM whose CRS is the site CRS is
/// read on its own grid without resampling (cropped to area + margin); others are warped (cubic) to the site CRS at their own GSD.
/// Throws InputError when the area is not covered: by how much, and by which box the file lies.
[[nodiscard]] HeightGrid read_dtm(const std::filesystem::path& path, const SiteFrame& site, double margin_m = 50.0);
/// Share of the area (0..1) in which the grid has heights.
[[nodiscard]] double coverage(const HeightGrid& grid, const SiteFrame& site);

/// Palette COG with the class table (JSON) in the metadata item ORTHODRIVE_CLASSES, nodata 255.
void write_labels(const std::filesystem::path& path, const LabelMap& labels);
/// Throws InputError when there is no class table in the metadata and none is given.
[[nodiscard]] LabelMap read_labels(const std::filesystem::path& path, const std::optional<ClassTable>& classes = {});
void write_confidence(const std::filesystem::path& path, const ConfidenceMap& confidence);

struct WritePhotoOptions {
  int jpeg_quality = 0;  ///< 0: lossless (deflate)
};
void write_photo(const std::filesystem::path& path, const Photo& photo, const WritePhotoOptions& options = {});
void write_dtm(const std::filesystem::path& path, const HeightGrid& grid);

/// Encoded images for glTF and the report. rgb has 3 channels.
[[nodiscard]] std::vector<std::uint8_t> encode_jpeg(const Raster<std::uint8_t>& rgb, int quality = 85);
void write_png(const std::filesystem::path& path, const Raster<std::uint8_t>& rgb);
/// 3 channels from any PNG/JPEG without georeferencing (training data).
[[nodiscard]] Raster<std::uint8_t> read_image(const std::filesystem::path& path);

/// Serialisation of class tables: {"name":..., "classes":[{"name","color","role","cost_false_positive","cost_false_negative"}]}.
[[nodiscard]] std::string class_table_to_json(const ClassTable& table);
[[nodiscard]] ClassTable class_table_from_json(const std::string& text);

}  // namespace orthodrive::io
