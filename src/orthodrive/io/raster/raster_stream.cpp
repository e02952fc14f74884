// SPDX-License-Identifier: Apache-2.0
// Writing of rasters box by box. GDAL's block cache is not used for what is written: it flushes blocks from whatever
// thread needs room, and a full disk would be blamed on the photo that thread reads.

#include <fmt/format.h>

#include <cassert>
#include <cstring>
#include <map>
#include <system_error>
#include <vector>

#include "orthodrive/core/atomic_file.hpp"
#include "orthodrive/core/error.hpp"
#include "orthodrive/io/raster/raster_io.hpp"
#include "orthodrive/io/raster/raster_support.hpp"

namespace orthodrive::io {
namespace fs = std::filesystem;

namespace {
constexpr int tile_px = 512;
constexpr std::size_t tile_pixels = std::size_t{tile_px} * tile_px;
constexpr std::size_t most_open_tiles = 64;  // 16 MB of one byte a pixel

struct StreamFormat {
  int bands = 1;
  GDALDataType type = GDT_Byte;
  std::size_t bytes = 1;  ///< of a sample
  std::uint8_t fill = 0;  ///< of every byte where nothing was written
  std::vector<std::string> cog_options;
};
}  // namespace

struct RasterStream::State {
  State(fs::path target, const Crs& crs, const GridFrame& frame, StreamFormat stream_format)
      : target(std::move(target)),
        frame(frame),
        format(std::move(stream_format)),
        columns((frame.width + tile_px - 1) / tile_px),
        stored(static_cast<std::size_t>(columns) * static_cast<std::size_t>((frame.height + tile_px - 1) / tile_px)) {
    start_gdal();
    fs::path windows = this->target;
    windows.replace_filename(this->target.stem().string() + ".windows.tif");
    const AtomicFile aside(windows);
    const ScopedGdalOption no_side_car("GDAL_PAM_ENABLED", "NO");
    GdalOptions options({"TILED=YES", fmt::format("BLOCKXSIZE={}", tile_px), fmt::format("BLOCKYSIZE={}", tile_px),
                         "COMPRESS=ZSTD", "ZSTD_LEVEL=1", "SPARSE_OK=TRUE", "BIGTIFF=IF_SAFER", "INTERLEAVE=BAND"});
    GdalErrors errors;
    dataset.reset(GetGDALDriverManager()->GetDriverByName("GTiff")->Create(
        aside.path().c_str(), frame.width, frame.height, format.bands, format.type, options.get()));
    if (!dataset) fail(errors);
    place(*dataset, frame, crs);
  }  // `aside` goes, and with it the name of the file: it lives as long as the dataset

  [[noreturn]] void fail(const GdalErrors& errors) const {
    throw Error(fmt::format("{}: cannot be written ({}); is the disk full or the folder read-only?", target.string(),
                            errors.text()));
  }

  /// Calls access(band, bytes) for the planes of a tile's pixels, one for each band.
  template <typename Access>
  void for_planes(std::vector<std::uint8_t>& pixels, const Access& access) const {
    for (int b = 0; b < format.bands; ++b) {
      GdalErrors errors;
      const CPLErr result = access(*dataset->GetRasterBand(b + 1),
                                   pixels.data() + static_cast<std::size_t>(b) * tile_pixels * format.bytes);
      if (result != CE_None || errors.any()) fail(errors);
    }
  }

  void store_tiles() {
    for (auto& [index, pixels] : open) {
      for_planes(pixels, [this, index = index](GDALRasterBand& band, std::uint8_t* plane) {
        return band.WriteBlock(index % columns, index / columns, plane);
      });
      stored[static_cast<std::size_t>(index)] = true;
    }
    open.clear();
  }

  /// 512 x 512 pixels, also at the far edges of the raster; band after band.
  std::vector<std::uint8_t>& tile(int index) {
    const auto found = open.find(index);
    if (found != open.end()) return found->second;
    if (open.size() >= most_open_tiles) store_tiles();
    std::vector<std::uint8_t> pixels(static_cast<std::size_t>(format.bands) * format.bytes * tile_pixels, format.fill);
    if (stored[static_cast<std::size_t>(index)])
      for_planes(pixels, [this, index](GDALRasterBand& band, std::uint8_t* plane) {
        return band.ReadBlock(index % columns, index / columns, plane);
      });
    return open.emplace(index, std::move(pixels)).first->second;
  }

  fs::path target;
  GridFrame frame;
  StreamFormat format;
  int columns;               ///< of tiles
  std::vector<bool> stored;  ///< tiles that were written to the file, perhaps before all their boxes had come
  std::map<int, std::vector<std::uint8_t>> open;
  DatasetPtr dataset;
};

RasterStream::RasterStream(std::unique_ptr<State> state) : state_(std::move(state)) {}
RasterStream::RasterStream(RasterStream&&) noexcept = default;
RasterStream::~RasterStream() = default;

template <typename T>
void RasterStream::write(const PixelBox& box, const Raster<T>& pixels) {
  State& s = *state_;
  assert(sizeof(T) == s.format.bytes && pixels.channels == s.format.bands);
  const PixelBox inside = intersection(box, pixels_of(s.frame));
  for (int tile_row = static_cast<int>(inside.row / tile_px); tile_row * std::int64_t{tile_px} < inside.end_row();
       ++tile_row)
    for (int tile_col = static_cast<int>(inside.col / tile_px); tile_col * std::int64_t{tile_px} < inside.end_col();
         ++tile_col) {
      const PixelBox tile{std::int64_t{tile_px} * tile_col, std::int64_t{tile_px} * tile_row, tile_px, tile_px};
      const PixelBox part = intersection(tile, inside);
      std::vector<std::uint8_t>& target = s.tile(tile_row * s.columns + tile_col);
      for (int band = 0; band < pixels.channels; ++band)
        for (std::int64_t row = part.row; row < part.end_row(); ++row) {
          const T* from = &pixels.at(static_cast<int>(part.col - box.col), static_cast<int>(row - box.row), band);
          std::uint8_t* to = &target[(static_cast<std::size_t>(band) * tile_pixels +
                                      static_cast<std::size_t>((row - tile.row) * tile_px + part.col - tile.col)) *
                                     sizeof(T)];
          for (int col = 0; col < part.width; ++col, from += pixels.channels, to += sizeof(T))
            std::memcpy(to, from, sizeof(T));
        }
    }
}
template void RasterStream::write(const PixelBox&, const Raster<std::uint8_t>&);
template void RasterStream::write(const PixelBox&, const Raster<float>&);

void RasterStream::finish() {
  State& s = *state_;
  s.store_tiles();
  GdalErrors errors;
  if (s.dataset->FlushCache(false); errors.any()) s.fail(errors);
  create_copy(s.target, "COG", *s.dataset, s.format.cog_options);
  s.dataset.reset();
}

RasterStream stream_labels(const fs::path& path, const Crs& crs, const GridFrame& frame, const ClassTable& classes) {
  auto state = std::make_unique<RasterStream::State>(
      path, crs, frame, StreamFormat{.fill = label_nodata, .cog_options = label_cog_options()});
  dress_as_labels(*state->dataset, classes);
  return RasterStream(std::move(state));
}

RasterStream stream_confidence(const fs::path& path, const Crs& crs, const GridFrame& frame) {
  return RasterStream(
      std::make_unique<RasterStream::State>(path, crs, frame, StreamFormat{.cog_options = confidence_cog_options()}));
}

RasterStream stream_photo(const fs::path& path, const Crs& crs, const GridFrame& frame,
                          const WritePhotoOptions& options) {
  auto state = std::make_unique<RasterStream::State>(
      path, crs, frame, StreamFormat{.bands = 3, .cog_options = photo_cog_options(options)});
  dress_as_photo(*state->dataset);
  return RasterStream(std::move(state));
}

RasterStream stream_dtm(const fs::path& path, const Crs& crs, const GridFrame& frame) {
  auto state = std::make_unique<RasterStream::State>(
      path, crs, frame, StreamFormat{.type = GDT_Float32, .bytes = sizeof(float), .cog_options = dtm_cog_options()});
  dress_as_dtm(*state->dataset);
  return RasterStream(std::move(state));
}

}  // namespace orthodrive::io
