// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/io/raster/tile_image.hpp"

#include <cpl_vsi.h>
#include <fmt/format.h>

#include <algorithm>
#include <atomic>

#include "orthodrive/core/atomic_file.hpp"
#include "orthodrive/core/error.hpp"
#include "orthodrive/core/printable.hpp"
#include "orthodrive/io/raster/raster_support.hpp"

namespace orthodrive::io {
namespace {
namespace fs = std::filesystem;

InputError no_image(const std::string& why) {
  return {"an image", fmt::format("cannot be decoded ({})", printable(why))};
}

/// Red, green, blue and alpha from whatever bands a picture has.
Raster<std::uint8_t> rgba_of(GDALDataset& picture) {
  Raster<std::uint8_t> image(picture.GetRasterXSize(), picture.GetRasterYSize(), 4, 255);
  const int bands = picture.GetRasterCount();
  if (bands == 3) {  // all at once is what GDAL's JPEG driver is fastest at
    Raster<std::uint8_t> rgb(image.width, image.height, 3);
    int order[3] = {1, 2, 3};
    if (picture.RasterIO(GF_Read, 0, 0, image.width, image.height, rgb.data.data(), image.width, image.height, GDT_Byte,
                         3, order, 3, GSpacing{3} * image.width, 1, nullptr) != CE_None)
      throw Error("its pixels");
    for (std::size_t i = 0; i < rgb.data.size() / 3; ++i) std::copy_n(&rgb.data[3 * i], 3, &image.data[4 * i]);
    return image;
  }
  const GDALColorTable* palette = picture.GetRasterBand(1)->GetColorTable();
  const int source_of[4] = {1, bands >= 3 ? 2 : 1, bands >= 3 ? 3 : 1, bands == 4 ? 4 : bands == 2 ? 2 : 0};
  for (int c = 0; c < 4; ++c) {
    if (source_of[c] == 0) continue;
    GDALRasterBand& band = *picture.GetRasterBand(source_of[c]);
    if (band.RasterIO(GF_Read, 0, 0, image.width, image.height, image.data.data() + c, image.width, image.height,
                      GDT_Byte, 4, GSpacing{4} * image.width, nullptr) != CE_None)
      throw Error("its pixels");
  }
  if (palette)
    for (std::size_t i = 0; i < image.data.size(); i += 4) {
      GDALColorEntry entry{};
      palette->GetColorEntryAsRGB(image.data[i], &entry);
      if (const GDALColorEntry* stored = palette->GetColorEntry(image.data[i])) entry.c4 = stored->c4;
      const short values[4] = {entry.c1, entry.c2, entry.c3, entry.c4};
      for (std::size_t c = 0; c < 4; ++c)
        image.data[i + c] = static_cast<std::uint8_t>(std::clamp<int>(values[c], 0, 255));
    }
  return image;
}
}  // namespace

std::string image_format(std::string_view bytes) {
  if (bytes.starts_with("\xFF\xD8\xFF")) return "jpg";
  if (bytes.starts_with("\x89PNG\r\n\x1A\n")) return "png";
  if (bytes.starts_with("RIFF") && bytes.substr(0, 12).ends_with("WEBP")) return "webp";
  return {};
}

Raster<std::uint8_t> decode_tile(std::string_view bytes) {
  static std::atomic<std::uint64_t> counter{0};
  constexpr int largest_px = 4096;
  if (image_format(bytes).empty()) throw no_image("no JPEG, PNG or WebP");
  start_gdal();
  const std::string name = fmt::format("/vsimem/orthodrive-tile-{}", counter++);
  // GDAL takes the buffer as non-const and does not write to it: the drivers open it for reading.
  auto* data = reinterpret_cast<GByte*>(const_cast<char*>(bytes.data()));
  VSIFCloseL(VSIFileFromMemBuffer(name.c_str(), data, bytes.size(), FALSE));
  const std::unique_ptr<const std::string, void (*)(const std::string*)> unlinked(
      &name, [](const std::string* file) { VSIUnlink(file->c_str()); });
  const char* const drivers[] = {"JPEG", "PNG", "WEBP", nullptr};
  const char* const no_siblings[] = {nullptr};
  const ScopedGdalOption no_side_car("GDAL_PAM_ENABLED", "NO");
  GdalErrors errors;
  const DatasetPtr picture(GDALDataset::Open(name.c_str(), GDAL_OF_RASTER, drivers, nullptr, no_siblings));
  if (!picture) throw no_image(errors.text());
  if (picture->GetRasterXSize() > largest_px || picture->GetRasterYSize() > largest_px)
    throw no_image(fmt::format("more than {} pixels a side", largest_px));
  if (picture->GetRasterCount() < 1 || picture->GetRasterCount() > 4) throw no_image("not one to four bands");
  try {
    Raster<std::uint8_t> image = rgba_of(*picture);
    if (errors.any()) throw Error(errors.text());
    return image;
  } catch (const Error& error) {
    throw no_image(errors.any() ? errors.text() : error.what());
  }
}

void write_tile_mosaic(const fs::path& path, const TileMosaic& m,
                       const std::function<std::optional<Raster<std::uint8_t>>(int, int)>& tile_at,
                       const std::function<void(double)>& progress) {
  start_gdal();
  const std::int64_t width = std::int64_t{m.columns} * m.tile_width, height = std::int64_t{m.rows} * m.tile_height;
  if (width > 2000000000 || height > 2000000000)
    throw Error(fmt::format("{}: {} x {} pixels are more than a GeoTIFF holds; take a smaller area", path.string(),
                            width, height));
  fs::path windows = path;
  windows.replace_filename(path.stem().string() + ".windows.tif");
  const AtomicFile aside(windows);
  const auto fail = [&](const GdalErrors& errors) {
    throw Error(fmt::format("{}: cannot be written ({}); is the disk full or the folder read-only?", path.string(),
                            errors.text()));
  };
  const ScopedGdalOption no_side_car("GDAL_PAM_ENABLED", "NO");
  const bool whole_blocks = m.tile_width % 16 == 0 && m.tile_height % 16 == 0;
  std::vector<std::string> options{"TILED=YES",        "COMPRESS=ZSTD",    "ZSTD_LEVEL=1", "SPARSE_OK=TRUE",
                                   "BIGTIFF=IF_SAFER", "INTERLEAVE=PIXEL", "ALPHA=YES"};
  if (whole_blocks) {
    options.push_back(fmt::format("BLOCKXSIZE={}", m.tile_width));
    options.push_back(fmt::format("BLOCKYSIZE={}", m.tile_height));
  }
  GdalErrors errors;
  DatasetPtr dataset(GetGDALDriverManager()->GetDriverByName("GTiff")->Create(
      aside.path().c_str(), static_cast<int>(width), static_cast<int>(height), 4, GDT_Byte,
      GdalOptions(options).get()));
  if (!dataset) fail(errors);
  const OGRSpatialReference reference = spatial_reference(m.crs);
  dataset->SetSpatialRef(&reference);
  double c[6] = {m.left, m.resolution, 0.0, m.top, 0.0, -m.resolution};
  dataset->SetGeoTransform(c);
  dress_as_photo(*dataset);
  int bands[4] = {1, 2, 3, 4};
  for (int row = 0; row < m.rows; ++row) {
    for (int column = 0; column < m.columns; ++column) {
      std::optional<Raster<std::uint8_t>> tile = tile_at(column, row);
      if (!tile) continue;
      if (dataset->RasterIO(GF_Write, column * m.tile_width, row * m.tile_height, m.tile_width, m.tile_height,
                            tile->data.data(), m.tile_width, m.tile_height, GDT_Byte, 4, bands, 4,
                            GSpacing{4} * m.tile_width, 1, nullptr) != CE_None)
        fail(errors);
    }
    if (progress) progress(static_cast<double>(row + 1) / m.rows);
  }
  if (dataset->FlushCache(false); errors.any()) fail(errors);
  create_copy(path, "COG", *dataset, photo_cog_options({.jpeg_quality = 95}));
}

}  // namespace orthodrive::io
