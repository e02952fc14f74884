// SPDX-License-Identifier: Apache-2.0
// Writing of rasters: cloud-optimised GeoTIFF through GDAL's COG driver, PNG and JPEG. Always aside first.

#include <cpl_vsi.h>
#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <limits>

#include "orthodrive/core/atomic_file.hpp"
#include "orthodrive/core/error.hpp"
#include "orthodrive/core/stop.hpp"
#include "orthodrive/io/raster/raster_io.hpp"
#include "orthodrive/io/raster/raster_support.hpp"
#include "orthodrive/model/rasters/class_table_json.hpp"

namespace orthodrive::io {
namespace fs = std::filesystem;

namespace {
/// GDAL takes memory to read from as non-const; CreateCopy does not write to its source.
template <typename T>
void wrap_for_reading(GDALDataset& dataset, const Raster<T>& raster) {
  wrap_channels(dataset, const_cast<Raster<T>&>(raster));
}

struct RemoveLeftovers {
  fs::path unfinished;
  ~RemoveLeftovers() { remove_leftovers(unfinished); }
};

/// GDAL asks after every block; FALSE ends the copy.
int CPL_STDCALL go_on(double, const char*, void*) { return stop_requested() ? FALSE : TRUE; }
}  // namespace

void create_copy(const fs::path& target, const char* driver_name, GDALDataset& source,
                 const std::vector<std::string>& options) {
  AtomicFile out(target);
  const RemoveLeftovers leftovers{out.path()};
  const ScopedGdalOption no_side_car("GDAL_PAM_ENABLED", "NO");
  GDALDriver* driver = GetGDALDriverManager()->GetDriverByName(driver_name);
  GdalOptions list(options);
  GdalErrors errors;
  DatasetPtr made(driver->CreateCopy(out.path().c_str(), &source, FALSE, list.get(), go_on, nullptr));
  const bool created = made != nullptr;
  made.reset();  // what GDAL still held is written now, and may fail now
  throw_if_stopped();
  if (!created || errors.any())
    throw Error(fmt::format("{}: cannot be written ({}); is the disk full or the folder read-only?", target.string(),
                            errors.text()));
  try {
    require_complete(out.path(), *open_dataset(out.path(), GDAL_OF_RASTER));
  } catch (const InputError&) {
    throw Error(fmt::format("{}: cannot be written to its end; is the disk full?", target.string()));
  }
  out.commit();
}

namespace {
DatasetPtr placed(const GridFrame& frame, const Crs& crs) {
  DatasetPtr dataset = memory_dataset(frame.width, frame.height);
  place(*dataset, frame, crs);
  return dataset;
}
}  // namespace

void dress_as_labels(GDALDataset& dataset, const ClassTable& classes) {
  GDALRasterBand& band = *dataset.GetRasterBand(1);
  GDALColorTable colors;
  for (std::size_t i = 0; i < classes.classes.size(); ++i) {
    const auto& c = classes.classes[i].color;
    const GDALColorEntry entry{c[0], c[1], c[2], 255};
    colors.SetColorEntry(static_cast<int>(i), &entry);
  }
  band.SetColorTable(&colors);
  band.SetColorInterpretation(GCI_PaletteIndex);
  band.SetNoDataValue(label_nodata);
  dataset.SetMetadataItem("ORTHODRIVE_CLASSES", class_table_to_json(classes).c_str());
}

void dress_as_photo(GDALDataset& dataset) {
  constexpr GDALColorInterp meaning[] = {GCI_RedBand, GCI_GreenBand, GCI_BlueBand, GCI_AlphaBand};
  for (int b = 1; b <= dataset.GetRasterCount(); ++b) dataset.GetRasterBand(b)->SetColorInterpretation(meaning[b - 1]);
}

void dress_as_dtm(GDALDataset& dataset) {
  dataset.GetRasterBand(1)->SetNoDataValue(std::numeric_limits<double>::quiet_NaN());
}

std::vector<std::string> photo_cog_options(const WritePhotoOptions& options) {
  if (options.jpeg_quality > 0)  // the driver turns alpha into a mask, which JPEG's losses do not touch
    return {"COMPRESS=JPEG", fmt::format("QUALITY={}", options.jpeg_quality), "OVERVIEW_RESAMPLING=AVERAGE",
            "BIGTIFF=IF_SAFER"};
  return {"COMPRESS=DEFLATE", "PREDICTOR=YES", "OVERVIEW_RESAMPLING=AVERAGE", "BIGTIFF=IF_SAFER"};
}

const std::vector<std::string>& dtm_cog_options() {
  static const std::vector<std::string> options{"COMPRESS=DEFLATE", "PREDICTOR=YES", "OVERVIEW_RESAMPLING=AVERAGE",
                                                "BIGTIFF=IF_SAFER"};
  return options;
}

// IF_SAFER: a mosaic may grow beyond the 4 GB of a plain TIFF, which a compressed file does not know beforehand.
const std::vector<std::string>& label_cog_options() {
  static const std::vector<std::string> options{"COMPRESS=DEFLATE", "OVERVIEW_RESAMPLING=NEAREST", "BIGTIFF=IF_SAFER",
                                                "NUM_THREADS=ALL_CPUS"};
  return options;
}

const std::vector<std::string>& confidence_cog_options() {
  // LEVEL: probabilities are noise to deflate, a higher one takes its time for nothing.
  static const std::vector<std::string> options{"COMPRESS=DEFLATE", "LEVEL=1", "OVERVIEW_RESAMPLING=AVERAGE",
                                                "BIGTIFF=IF_SAFER", "NUM_THREADS=ALL_CPUS"};
  return options;
}

void write_labels(const fs::path& path, const LabelMap& map) {
  const DatasetPtr dataset = placed(map.frame, map.crs);
  wrap_for_reading(*dataset, map.labels);
  dress_as_labels(*dataset, map.classes);
  create_copy(path, "COG", *dataset, label_cog_options());
}

void write_confidence(const fs::path& path, const ConfidenceMap& map) {
  const DatasetPtr dataset = placed(map.frame, map.crs);
  wrap_for_reading(*dataset, map.confidence);
  create_copy(path, "COG", *dataset, confidence_cog_options());
}

void write_photo(const fs::path& path, const Photo& photo, const WritePhotoOptions& options) {
  const DatasetPtr dataset = placed(photo.frame, photo.crs);
  wrap_for_reading(*dataset, photo.rgb);
  Raster<std::uint8_t> alpha;
  if (std::find(photo.valid.data.begin(), photo.valid.data.end(), 0) != photo.valid.data.end()) {
    alpha = photo.valid;
    for (std::uint8_t& a : alpha.data) a = a ? 255 : 0;
    wrap_channels(*dataset, alpha);
  }
  dress_as_photo(*dataset);
  create_copy(path, "COG", *dataset, photo_cog_options(options));
}

void write_dtm(const fs::path& path, const HeightGrid& grid) {
  const DatasetPtr dataset = placed(grid.frame, grid.crs);
  wrap_for_reading(*dataset, grid.height_m);
  dress_as_dtm(*dataset);
  create_copy(path, "COG", *dataset, dtm_cog_options());
}

void write_png(const fs::path& path, const Raster<std::uint8_t>& rgb) {
  const DatasetPtr dataset = memory_dataset(rgb.width, rgb.height);
  wrap_for_reading(*dataset, rgb);
  create_copy(path, "PNG", *dataset, {});
}

namespace {
std::vector<std::uint8_t> encode(const Raster<std::uint8_t>& image, const char* driver,
                                 const std::vector<std::string>& options) {
  const DatasetPtr dataset = memory_dataset(image.width, image.height);
  wrap_for_reading(*dataset, image);
  static std::atomic<int> counter{0};
  const std::string name = fmt::format("/vsimem/orthodrive-image-{}", counter++);
  const ScopedGdalOption no_side_car("GDAL_PAM_ENABLED", "NO");
  GdalOptions list(options);
  GdalErrors errors;
  DatasetPtr made(GetGDALDriverManager()->GetDriverByName(driver)->CreateCopy(name.c_str(), dataset.get(), FALSE,
                                                                              list.get(), nullptr, nullptr));
  const bool created = made != nullptr;
  made.reset();
  vsi_l_offset size = 0;
  const std::unique_ptr<GByte, decltype(&VSIFree)> bytes(VSIGetMemFileBuffer(name.c_str(), &size, TRUE), VSIFree);
  if (!created || errors.any() || !bytes)
    throw Error(fmt::format("an image cannot be encoded as {}: {}", driver, errors.text()));
  return {bytes.get(), bytes.get() + size};
}
}  // namespace

std::vector<std::uint8_t> encode_jpeg(const Raster<std::uint8_t>& rgb, int quality) {
  return encode(rgb, "JPEG", {fmt::format("QUALITY={}", quality)});
}

std::vector<std::uint8_t> encode_webp(const Raster<std::uint8_t>& rgb, int quality) {
  return encode(rgb, "WEBP", {fmt::format("QUALITY={}", quality)});
}

std::vector<std::uint8_t> encode_png(const Raster<std::uint8_t>& image) { return encode(image, "PNG", {}); }

}  // namespace orthodrive::io
