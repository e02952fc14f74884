// SPDX-License-Identifier: Apache-2.0
// Reading of photos: as they are, or warped on demand onto the grid of a site.

#include <fmt/format.h>
#include <gdal_utils.h>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <memory>
#include <mutex>
#include <utility>

#include "orthodrive/core/error.hpp"
#include "orthodrive/core/parallel.hpp"
#include "orthodrive/io/raster/photo_bands.hpp"
#include "orthodrive/io/raster/raster_io.hpp"
#include "orthodrive/io/raster/raster_support.hpp"

namespace orthodrive::io {
namespace fs = std::filesystem;

namespace {
std::string describe_extent(const Georeference& g, GDALDataset& dataset) {
  return describe_lonlat(bounds_of(outline_lonlat(g, dataset.GetRasterXSize(), dataset.GetRasterYSize()).outer));
}

InputError shows_nothing(const fs::path& path, GDALDataset& source, const Georeference& g, const SiteFrame& site) {
  return {path.string(),
          fmt::format("shows nothing of the area: it covers {}, the area is {}; take another photo or area",
                      describe_extent(g, source), describe_lonlat(lonlat_bounds(site.area.outer, site.crs)))};
}

/// Which pixels of a frame have their centre in a polygon, row by row. Computed once for the whole frame: computed for
/// a window, rounding could put a centre on the other side of an edge.
class InsidePixels {
 public:
  InsidePixels(const Polygon& area, const GridFrame& frame) : first_span_(static_cast<std::size_t>(frame.height) + 1) {
    rasterize(area, frame, [&](int row, int begin, int end) {
      spans_.push_back({begin, end});
      ++first_span_[static_cast<std::size_t>(row) + 1];
    });
    for (std::size_t row = 1; row < first_span_.size(); ++row) first_span_[row] += first_span_[row - 1];
  }
  /// Sets 0 outside the polygon; `valid` has the pixels [col, col + count) of the row.
  void clip(std::int64_t row, std::int64_t col, int count, std::uint8_t* valid) const {
    std::int64_t next = col;
    const std::int64_t end_col = col + count;
    const auto clear = [&](std::int64_t begin, std::int64_t end) {
      if (begin < end) std::memset(valid + (begin - col), 0, static_cast<std::size_t>(end - begin));
    };
    const auto index = static_cast<std::size_t>(row);
    for (std::size_t i = first_span_[index]; i < first_span_[index + 1]; ++i) {
      clear(next, std::min<std::int64_t>(spans_[i].begin, end_col));
      next = std::clamp<std::int64_t>(spans_[i].end, next, end_col);
    }
    clear(next, end_col);
  }

 private:
  struct Span {
    int begin, end;
  };
  std::vector<Span> spans_;
  std::vector<std::size_t> first_span_;  ///< of each row, and the end
};

/// A photo whose blocks are whole rows (JPEG, PNG) is decoded from its top again when a window goes back to rows that
/// were dropped. A row of windows should stay in the block cache.
void keep_rows_of_windows(GDALDataset& photo) {
  constexpr std::int64_t rows = 2048;
  int block_width = 0, block_height = 0;
  photo.GetRasterBand(1)->GetBlockSize(&block_width, &block_height);
  if (block_width == photo.GetRasterXSize()) enlarge_block_cache(rows * block_width * photo.GetRasterCount());
}

/// The photo on the grid of the site. GDAL's warped virtual raster computes it in blocks of a fixed grid, which is why
/// a pixel is the same in every window: coordinates are interpolated across a block.
class WarpedPhoto {
 public:
  WarpedPhoto(fs::path path, const SiteFrame& site, const ReadPhotoOptions& options)
      : path_(std::move(path)), source_(open_dataset(path_, GDAL_OF_RASTER)), g_(georeference_of(path_, *source_)) {
    require_complete(path_, *source_);
    const PixelSize source_pixel = pixel_size(g_, source_->GetRasterXSize(), source_->GetRasterYSize());
    const double gsd_m = options.gsd_m > 0.0 ? options.gsd_m : rounded_gsd_m(source_pixel.gsd_m());
    frame_ = covering_grid(bounds_of(site.area.outer), gsd_m);
    const Polygon outline = outline_lonlat(g_, source_->GetRasterXSize(), source_->GetRasterYSize());
    if (!bounds_of(outline.outer).overlaps(lonlat_bounds(site.area.outer, site.crs))) throw nothing_of(site);
    inside_ = InsidePixels(site.area, frame_);
    rgb_ = rgb_photo(path_, *source_);
    keep_rows_of_windows(*source_);
    warp(site, source_pixel, options);
  }
  [[nodiscard]] const GridFrame& frame() const { return frame_; }
  /// What is odd about it: where that is on the map, or in the middle of the area if it lies outside.
  [[nodiscard]] Findings findings(const SiteFrame& site) const {
    const Box2 box = bounds_of(site.area.outer);
    const OGRSpatialReference target = spatial_reference(site.crs);
    const GdalErrors silent;
    const std::unique_ptr<OGRCoordinateTransformation> to_site(
        OGRCreateCoordinateTransformation(&g_.reference, &target));
    Findings findings;
    for (const PhotoOddity& odd : rgb_.oddities) {
      Vec2 p{g_.c[0] + odd.pixel.x * g_.c[1] + odd.pixel.y * g_.c[2],
             g_.c[3] + odd.pixel.x * g_.c[4] + odd.pixel.y * g_.c[5]};
      if (!to_site || !to_site->Transform(1, &p.x, &p.y) || !box.contains(p))
        p = {0.5 * (box.min_x + box.max_x), 0.5 * (box.min_y + box.max_y)};
      findings.push_back({Severity::warning, odd.code, odd.message, p.x, p.y});
    }
    return findings;
  }
  [[nodiscard]] InputError nothing_of(const SiteFrame& site) const { return shows_nothing(path_, *source_, g_, site); }

  [[nodiscard]] PhotoWindow read(const PixelBox& box) {
    PhotoWindow window{Raster<std::uint8_t>(box.width, box.height, 3), Raster<std::uint8_t>(box.width, box.height)};
    const PixelBox wanted = intersection(box, pixels_of(frame_));
    if (wanted.empty()) return window;
    const auto start_of_block = [](std::int64_t pixel, int block) { return static_cast<int>(pixel / block * block); };
    for (int row = start_of_block(wanted.row, block_height_); row < wanted.end_row(); row += block_height_)
      for (int col = start_of_block(wanted.col, block_width_); col < wanted.end_col(); col += block_width_)
        copy_block({col, row, std::min(block_width_, frame_.width - col), std::min(block_height_, frame_.height - row)},
                   wanted, box, window);
    for (std::int64_t row = wanted.row; row < wanted.end_row(); ++row)
      inside_.clip(row, wanted.col, wanted.width,
                   &window.valid.at(static_cast<int>(wanted.col - box.col), static_cast<int>(row - box.row)));
    return window;
  }

 private:
  void warp(const SiteFrame& site, const PixelSize& source_pixel, const ReadPhotoOptions& read_options) {
    // Where the photo is much finer, cubic convolution would see only the pixels around each centre.
    std::vector<std::string> arguments = frame_.gsd_m > 2.0 * source_pixel.gsd_m()
                                             ? std::vector<std::string>{"-r", "average"}
                                             : cubic_resampling(source_pixel, frame_.gsd_m);
    const Box2 box = frame_.bounds();
    const auto exact = [](double value) { return fmt::format("{:.17g}", value); };
    arguments.insert(arguments.end(), {"-of", "VRT", "-dstalpha", "-t_srs", site.crs.definition});
    arguments.insert(arguments.end(), {"-te", exact(box.min_x), exact(box.min_y), exact(box.max_x), exact(box.max_y)});
    arguments.insert(arguments.end(), {"-ts", std::to_string(frame_.width), std::to_string(frame_.height)});
    // An error of 0.02 px is below what anyone sees; exact coordinates take ten times as long. No overviews unless
    // asked for: they are a second, blurred photo.
    arguments.insert(arguments.end(), {"-et", "0.02", "-wo", "UNIFIED_SRC_NODATA=YES"});
    arguments.insert(arguments.end(), {"-ovr", read_options.overviews ? "AUTO" : "NONE"});
    arguments.insert(arguments.end(), {"-wo", fmt::format("NUM_THREADS={}", worker_count(read_options.threads))});
    GdalOptions list(arguments);
    GdalErrors errors;
    GDALWarpAppOptions* options = GDALWarpAppOptionsNew(list.get(), nullptr);
    GDALDatasetH sources[1] = {GDALDataset::ToHandle(rgb_.view ? rgb_.view.get() : source_.get())};
    int usage_error = 0;
    warped_.reset(GDALDataset::FromHandle(GDALWarp("", nullptr, 1, sources, options, &usage_error)));
    GDALWarpAppOptionsFree(options);
    if (!warped_ || warped_->GetRasterCount() != 4 || warped_->GetRasterXSize() != frame_.width ||
        warped_->GetRasterYSize() != frame_.height)
      throw InputError(path_.string(),
                       fmt::format("cannot be brought to {} ({}); warp it yourself: gdalwarp -t_srs {} IN OUT.tif",
                                   site.crs.definition, errors.text(), site.crs.definition));
    warped_->GetRasterBand(1)->GetBlockSize(&block_width_, &block_height_);
  }

  void copy_block(const PixelBox& block, const PixelBox& wanted, const PixelBox& box, PhotoWindow& window) {
    thread_local std::vector<std::uint8_t> rgba;
    rgba.resize(4 * static_cast<std::size_t>(block.width) * static_cast<std::size_t>(block.height));
    read_block(block, rgba.data());
    const PixelBox part = intersection(block, wanted);
    for (std::int64_t row = part.row; row < part.end_row(); ++row) {
      const std::uint8_t* from = rgba.data() + 4 * ((row - block.row) * block.width + part.col - block.col);
      const int col_in_window = static_cast<int>(part.col - box.col), row_in_window = static_cast<int>(row - box.row);
      std::uint8_t *rgb = &window.rgb.at(col_in_window, row_in_window),
                   *valid = &window.valid.at(col_in_window, row_in_window);
      for (int i = 0; i < part.width; ++i, from += 4, rgb += 3) {
        rgb[0] = from[0], rgb[1] = from[1], rgb[2] = from[2];
        valid[i] = from[3] >= 128 ? 1 : 0;
      }
    }
  }

  void read_block(const PixelBox& block, std::uint8_t* rgba) {
    const std::lock_guard lock(mutex_);  // a dataset is for one thread at a time; the windows share its block cache
    // GDAL gives a thread 65536 pixels at least, which is a whole block of ours.
    const ScopedGdalOption several_threads_a_block("WARP_THREAD_CHUNK_SIZE", "16384");
    GdalErrors errors;
    int bands[4] = {1, 2, 3, 4};
    if (warped_->RasterIO(GF_Read, static_cast<int>(block.col), static_cast<int>(block.row), block.width, block.height,
                          rgba, block.width, block.height, GDT_Byte, 4, bands, 4, GSpacing{4} * block.width, 1,
                          nullptr) != CE_None ||
        errors.any())
      throw InputError(
          path_.string(),
          fmt::format("cannot be read to its end ({}); is it truncated? Get the file again", errors.text()));
  }

  fs::path path_;
  DatasetPtr source_;
  Georeference g_;
  RgbPhoto rgb_;       ///< a view of the source, which it must not outlive
  DatasetPtr warped_;  ///< likewise of that
  GridFrame frame_;
  InsidePixels inside_{{}, {}};
  int block_width_ = 0, block_height_ = 0;
  std::mutex mutex_;
};

/// The photo on its own grid.
class NativePhoto {
 public:
  explicit NativePhoto(fs::path path)
      : path_(std::move(path)),
        source_(open_dataset(path_, GDAL_OF_RASTER)),
        frame_(north_up_frame(path_, *source_)),
        crs_(crs_of(*source_->GetSpatialRef())) {
    require_complete(path_, *source_);
    view_ = rgb_photo(path_, *source_).view;
    keep_rows_of_windows(*source_);
  }
  [[nodiscard]] const GridFrame& frame() const { return frame_; }
  [[nodiscard]] const Crs& crs() const { return crs_; }

  [[nodiscard]] PhotoWindow read(const PixelBox& box) {
    PhotoWindow window{Raster<std::uint8_t>(box.width, box.height, 3), Raster<std::uint8_t>(box.width, box.height)};
    const PixelBox wanted = intersection(box, pixels_of(frame_));
    if (wanted.empty()) return window;
    const int left = static_cast<int>(wanted.col - box.col), top = static_cast<int>(wanted.row - box.row);
    const std::lock_guard lock(mutex_);  // a dataset is for one thread at a time
    GdalErrors errors;
    GDALDataset& rgb = view_ ? *view_ : *source_;
    int bands[3] = {1, 2, 3};
    const bool read = rgb.RasterIO(GF_Read, static_cast<int>(wanted.col), static_cast<int>(wanted.row), wanted.width,
                                   wanted.height, &window.rgb.at(left, top), wanted.width, wanted.height, GDT_Byte, 3,
                                   bands, 3, GSpacing{3} * box.width, 1, nullptr) == CE_None &&
                      read_valid(rgb, wanted, left, top, window.valid);
    if (!read)
      throw InputError(path_.string(),
                       fmt::format("cannot be read to its end ({}); get the file again", errors.text()));
    return window;
  }

 private:
  /// A pixel is invalid only where every band says so: black in one band alone is a colour.
  static bool read_valid(GDALDataset& rgb, const PixelBox& wanted, int left, int top, Raster<std::uint8_t>& valid) {
    Raster<std::uint8_t> mask(wanted.width, wanted.height);
    for (int b = 1; b <= 3; ++b) {
      GDALRasterBand& band = *rgb.GetRasterBand(b);
      if (band.GetMaskFlags() & GMF_ALL_VALID)
        std::fill(mask.data.begin(), mask.data.end(), std::uint8_t{255});
      else if (band.GetMaskBand()->RasterIO(GF_Read, static_cast<int>(wanted.col), static_cast<int>(wanted.row),
                                            wanted.width, wanted.height, mask.data.data(), wanted.width, wanted.height,
                                            GDT_Byte, 0, 0, nullptr) != CE_None)
        return false;
      for (int row = 0; row < wanted.height; ++row)
        for (int col = 0; col < wanted.width; ++col)
          valid.at(left + col, top + row) |= mask.at(col, row) >= 128 ? 1 : 0;
      if (band.GetMaskFlags() & (GMF_ALL_VALID | GMF_PER_DATASET)) break;
    }
    return true;
  }

  fs::path path_;
  DatasetPtr source_;
  DatasetPtr view_;  ///< of the source, which it must not outlive; null: the source is as wanted
  GridFrame frame_;
  Crs crs_;
  std::mutex mutex_;
};
}  // namespace

PhotoSource open_photo(const fs::path& path, const SiteFrame& site, const ReadPhotoOptions& options,
                       Findings* findings) {
  const auto photo = std::make_shared<WarpedPhoto>(path, site, options);
  if (findings)
    for (Finding& finding : photo->findings(site)) findings->push_back(std::move(finding));
  return {site.crs, photo->frame(), [photo](const PixelBox& box) { return photo->read(box); }};
}

Photo read_photo(const fs::path& path, const SiteFrame& site, const ReadPhotoOptions& options) {
  WarpedPhoto reader(path, site, options);
  PhotoWindow whole = reader.read(pixels_of(reader.frame()));
  if (!std::memchr(whole.valid.data.data(), 1, whole.valid.data.size())) throw reader.nothing_of(site);
  return {site.crs, reader.frame(), std::move(whole.rgb), std::move(whole.valid)};
}

PhotoSource open_photo_native(const fs::path& path) {
  const auto photo = std::make_shared<NativePhoto>(path);
  return {photo->crs(), photo->frame(), [photo](const PixelBox& box) { return photo->read(box); }};
}

Photo read_photo_native(const fs::path& path) {
  NativePhoto reader(path);
  PhotoWindow whole = reader.read(pixels_of(reader.frame()));
  return {reader.crs(), reader.frame(), std::move(whole.rgb), std::move(whole.valid)};
}

namespace {
/// All of a picture is held in memory, and a small file may say that it is huge.
void require_plausible_size(const fs::path& path, GDALDataset& picture) {
  constexpr std::int64_t most_pixels = std::int64_t{1} << 30, always_taken = std::int64_t{1} << 26;
  constexpr std::int64_t pixels_of_a_byte = 1000;  // as deflate packs one colour
  const std::int64_t pixels = std::int64_t{picture.GetRasterXSize()} * picture.GetRasterYSize();
  if (pixels <= always_taken) return;
  const bool refers_to_others = std::string_view(picture.GetDriverName()) == "VRT";
  std::error_code of_memory;
  const std::uintmax_t bytes = fs::file_size(path, of_memory);
  const bool fits = refers_to_others || of_memory || static_cast<std::uintmax_t>(pixels / pixels_of_a_byte) <= bytes;
  if (pixels > most_pixels || !fits)
    throw InputError(path.string(),
                     fmt::format("says that it has {} x {} pixels, more than {} or than its bytes can hold; get the "
                                 "file again, or cut it",
                                 picture.GetRasterXSize(), picture.GetRasterYSize(), most_pixels));
}

Raster<std::uint8_t> pixels_of(const fs::path& path, const DatasetPtr& source) {
  require_plausible_size(path, *source);
  const DatasetPtr view = rgb_bands(path, *source).view;
  GDALDataset& rgb = view ? *view : *source;
  Raster<std::uint8_t> image(rgb.GetRasterXSize(), rgb.GetRasterYSize(), 3);
  GdalErrors errors;
  int bands[3] = {1, 2, 3};
  if (rgb.RasterIO(GF_Read, 0, 0, image.width, image.height, image.data.data(), image.width, image.height, GDT_Byte, 3,
                   bands, 3, GSpacing{3} * image.width, 1, nullptr) != CE_None)
    throw InputError(path.string(), fmt::format("cannot be read to its end ({}); get the file again", errors.text()));
  return image;
}
}  // namespace

Raster<std::uint8_t> read_image(const fs::path& path) { return pixels_of(path, open_dataset(path, GDAL_OF_RASTER)); }

PlacedImage read_placed_image(const fs::path& path) {
  const DatasetPtr source = open_dataset(path, GDAL_OF_RASTER);
  const Georeference g = georeference_of(path, *source);
  require_complete(path, *source);
  PlacedImage image{.crs = crs_of(g.reference), .rgb = pixels_of(path, source)};
  std::copy_n(std::begin(g.c), image.world_from_pixel.size(), image.world_from_pixel.begin());
  return image;
}

Raster<std::uint8_t> decode_image(std::span<const std::uint8_t> bytes) {
  static std::atomic<int> counter{0};
  const std::string name = fmt::format("/vsimem/orthodrive-encoded-{}", counter++);
  std::vector<GByte> copy(bytes.begin(), bytes.end());
  VSIFCloseL(VSIFileFromMemBuffer(name.c_str(), copy.data(), copy.size(), FALSE));
  const std::unique_ptr<const std::string, void (*)(const std::string*)> unlinked(
      &name, [](const std::string* file) { VSIUnlink(file->c_str()); });
  constexpr int largest_px = 8192;
  GdalErrors errors;
  // Other formats refer to files and addresses: a picture inside a file must be a picture.
  const char* const pictures[] = {"PNG", "JPEG", "WEBP", nullptr};
  const DatasetPtr source(GDALDataset::Open(name.c_str(), GDAL_OF_RASTER, pictures));
  if (!source) throw InputError("an image", fmt::format("cannot be decoded ({})", errors.text()));
  if (source->GetRasterXSize() > largest_px || source->GetRasterYSize() > largest_px)
    throw InputError("an image", fmt::format("has more than {} pixels a side", largest_px));
  return pixels_of(name, source);
}

}  // namespace orthodrive::io
