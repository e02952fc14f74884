// SPDX-License-Identifier: Apache-2.0
#pragma once
// Rasters: files <-> model, through GDAL. All reading ends in the site CRS; all writing goes aside first.

#include <array>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "orthodrive/core/finding.hpp"
#include "orthodrive/model/rasters/raster_source.hpp"
#include "orthodrive/model/rasters/rasters.hpp"
#include "orthodrive/model/site_frame.hpp"

namespace orthodrive::io {

struct RasterInfo {
  Crs crs;
  int width = 0, height = 0, bands = 0;
  double gsd_m = 0.0;      ///< ground sampling distance at the centre, in metres whatever the CRS's unit
  Polygon outline_lonlat;  ///< WGS84, densified
};
/// Throws InputError when the file is missing, not a raster, truncated, or without georeferencing.
[[nodiscard]] RasterInfo raster_info(const std::filesystem::path& path);
/// The file and what GDAL reads with it: world files, masks, overviews, .aux.xml, the sources of a VRT. The path alone
/// when no raster can be opened there. Sorted, the path first.
[[nodiscard]] std::vector<std::filesystem::path> raster_files(const std::filesystem::path& path);

struct ReadPhotoOptions {
  double gsd_m = 0.0;  ///< 0: the photo's own, rounded to a centimetre; of several: that of the first in the area
  int threads = 0;
  bool overviews = false;  ///< read the file's overviews where they are fine enough: fast, but a second, blurred photo
};
/// Warps the photo (cubic; average when it is much finer than gsd_m) onto the covering grid of the area's bounds.
/// valid is 0 outside the source, at its nodata / alpha / mask, and outside the area polygon.
[[nodiscard]] Photo read_photo(const std::filesystem::path& path, const SiteFrame& site,
                               const ReadPhotoOptions& options = {});
/// The same photo window by window, each warped when it is asked for; every window has the bytes that read_photo gives.
/// Memory does not grow with the photo. Pixels without data are no error here. Throws InputError when the photo lies
/// somewhere else, and from its read() when the file cannot be read to its end. What its format does not say, or says
/// wrongly, is seen in its pixels and becomes findings: photo.alpha_is_none, photo.alpha_range, photo.collar,
/// photo.inks, photo.sample_range (io/raster/photo_bands.hpp).
[[nodiscard]] PhotoSource open_photo(const std::filesystem::path& path, const SiteFrame& site,
                                     const ReadPhotoOptions& options = {}, Findings* findings = nullptr);
/// Several photos, best first, as one (model/rasters/photo_mosaic.hpp); one alone as above. One that shows nothing of
/// the area becomes a finding `photo.elsewhere` and is left out. Throws InputError when all lie somewhere else. What
/// seams need is estimated as the photos are opened, which reads each of them once, or its overviews.
[[nodiscard]] PhotoSource open_photo(const std::vector<std::filesystem::path>& paths, const SiteFrame& site,
                                     const ReadPhotoOptions& options = {}, Findings* findings = nullptr);
[[nodiscard]] Photo read_photo(const std::vector<std::filesystem::path>& paths, const SiteFrame& site,
                               const ReadPhotoOptions& options = {});
/// The photo as it is, on its own grid. It must be north-up in a metric CRS (as synth and read_photo make them).
[[nodiscard]] Photo read_photo_native(const std::filesystem::path& path);
/// The same window by window: memory does not grow with the photo.
[[nodiscard]] PhotoSource open_photo_native(const std::filesystem::path& path);

/// Heights over the box and a little more, NaN where the file has none. A terrain model whose CRS is the one asked for
/// is read on its own grid without resampling; others are warped (cubic, exact coordinates) at their own GSD. Heights
/// in a unit that the file states (feet) become metres; below -1500 and above 30000 they are nodata that it does not
/// state.
[[nodiscard]] HeightGrid read_heights(const std::filesystem::path& path, const Crs& crs, const Box2& box);
/// Heights over the area and the margin around it. Throws InputError when less than 98 % of the area is covered: by how
/// much, and which box the file covers.
[[nodiscard]] HeightGrid read_dtm(const std::filesystem::path& path, const SiteFrame& site, double margin_m = 50.0);
/// What sites need: where terrain ends, roads and ground go on with findings; less of it is the wrong file.
constexpr double least_site_coverage = 0.5;

struct ReadDtmsOptions {
  double margin_m = 50.0;  ///< around the area
  double least_coverage =
      0.98;  ///< share of the area; a rim thinner than a pixel or a pond without returns is no obstacle
};
/// Several terrain models, best first, that cover the area together (model/rasters/sample_height.hpp: merged_source).
/// One that is 3.28 times as high as another is in feet and becomes metres, with a finding `terrain.feet`. Where two
/// differ by a constant, one is shifted onto the other (`terrain.shifted`): heights over the ellipsoid onto those over
/// sea level, else those without a named vertical datum, else the later one. Where they differ otherwise
/// (`terrain.models_differ`), or only by the names of their datums, heights stay as they are. Throws as read_dtm.
[[nodiscard]] std::vector<HeightGrid> read_dtms(const std::vector<std::filesystem::path>& paths, const SiteFrame& site,
                                                const ReadDtmsOptions& options = {}, Findings* findings = nullptr);
/// Share of the area (0..1) in which at least one of the grids has heights.
[[nodiscard]] double coverage(std::span<const HeightGrid> grids, const SiteFrame& site);

/// Palette COG with the class table (JSON) in the metadata item ORTHODRIVE_CLASSES, nodata 255.
void write_labels(const std::filesystem::path& path, const LabelMap& labels);
/// `fallback` is the class table of files of others, which have none in their metadata. Throws InputError when there is
/// neither, and when a label is not in the table.
[[nodiscard]] LabelMap read_labels(const std::filesystem::path& path, const std::optional<ClassTable>& fallback = {});
/// The same window by window; what a window shows is checked when it is read.
[[nodiscard]] LabelSource open_labels(const std::filesystem::path& path,
                                      const std::optional<ClassTable>& fallback = {});
void write_confidence(const std::filesystem::path& path, const ConfidenceMap& confidence);
/// As write_confidence makes it: one band of 8 bit, north-up in a metric CRS.
[[nodiscard]] ConfidenceMap read_confidence(const std::filesystem::path& path);

struct WritePhotoOptions {
  int jpeg_quality = 0;  ///< 0: lossless (deflate)
};
void write_photo(const std::filesystem::path& path, const Photo& photo, const WritePhotoOptions& options = {});
void write_dtm(const std::filesystem::path& path, const HeightGrid& grid);

/// A raster written box by box, in any order; each pixel once. Boxes wait in a compressed file without a name, so
/// memory does not grow with the raster and a killed run leaves nothing. finish() makes the same file as write_labels,
/// write_confidence, write_photo (all pixels valid) or write_dtm; without it an earlier file stays untouched. One
/// thread at a time.
class RasterStream {
 public:
  RasterStream(RasterStream&&) noexcept;
  ~RasterStream();
  /// T: std::uint8_t, of heights float. As many channels as the raster has.
  template <typename T>
  void write(const PixelBox& box, const Raster<T>& pixels);
  void finish();

 private:
  struct State;
  explicit RasterStream(std::unique_ptr<State> state);
  friend RasterStream stream_labels(const std::filesystem::path&, const Crs&, const GridFrame&, const ClassTable&);
  friend RasterStream stream_confidence(const std::filesystem::path&, const Crs&, const GridFrame&);
  friend RasterStream stream_photo(const std::filesystem::path&, const Crs&, const GridFrame&,
                                   const WritePhotoOptions&);
  friend RasterStream stream_dtm(const std::filesystem::path&, const Crs&, const GridFrame&);
  std::unique_ptr<State> state_;
};
[[nodiscard]] RasterStream stream_labels(const std::filesystem::path& path, const Crs& crs, const GridFrame& frame,
                                         const ClassTable& classes);
[[nodiscard]] RasterStream stream_confidence(const std::filesystem::path& path, const Crs& crs, const GridFrame& frame);
[[nodiscard]] RasterStream stream_photo(const std::filesystem::path& path, const Crs& crs, const GridFrame& frame,
                                        const WritePhotoOptions& options = {});
[[nodiscard]] RasterStream stream_dtm(const std::filesystem::path& path, const Crs& crs, const GridFrame& frame);

/// A picture on its own grid, whichever way that lies in whatever CRS; geographic ones count (longitude, latitude).
struct PlacedImage {
  Crs crs;
  /// GDAL's: x = c[0] + c[1] col + c[2] row, y = c[3] + c[4] col + c[5] row, from the outer corner of the first pixel.
  std::array<double, 6> world_from_pixel{};
  Raster<std::uint8_t> rgb;
};
[[nodiscard]] PlacedImage read_placed_image(const std::filesystem::path& path);

/// Encoded images for glTF and the report. rgb has 3 channels.
[[nodiscard]] std::vector<std::uint8_t> encode_jpeg(const Raster<std::uint8_t>& rgb, int quality = 85);
[[nodiscard]] std::vector<std::uint8_t> encode_webp(const Raster<std::uint8_t>& rgb, int quality = 80);
/// Lossless; 1 or 3 channels.
[[nodiscard]] std::vector<std::uint8_t> encode_png(const Raster<std::uint8_t>& image);
void write_png(const std::filesystem::path& path, const Raster<std::uint8_t>& rgb);
/// 3 channels from any PNG/JPEG without georeferencing (training data).
[[nodiscard]] Raster<std::uint8_t> read_image(const std::filesystem::path& path);
/// The same of a file in memory, up to 8192 pixels a side. Throws InputError where it cannot be decoded.
[[nodiscard]] Raster<std::uint8_t> decode_image(std::span<const std::uint8_t> bytes);

}  // namespace orthodrive::io
