// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/io/raster/photo_bands.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>

#include "orthodrive/core/error.hpp"
#include "orthodrive/io/raster/computed_photo.hpp"
#include "orthodrive/io/raster/photo_collar.hpp"
#include "orthodrive/io/raster/raster_support.hpp"

namespace orthodrive::io {
namespace fs = std::filesystem;

namespace {

/// Which band is what, counted from 1; 0: there is none.
struct BandRoles {
  std::array<int, 3> colors{};
  int alpha = 0;
  std::array<int, 4> inks{};  ///< cyan, magenta, yellow, black
};

int band_of(GDALDataset& photo, GDALColorInterp role) {
  for (int b = photo.GetRasterCount(); b >= 1; --b)
    if (photo.GetRasterBand(b)->GetColorInterpretation() == role) return b;
  return 0;
}

BandRoles roles_of(GDALDataset& photo) {
  BandRoles roles;
  const int bands = photo.GetRasterCount();
  roles.alpha = band_of(photo, GCI_AlphaBand);
  const int colors = bands - (roles.alpha ? 1 : 0);
  const std::array<int, 3> named{band_of(photo, GCI_RedBand), band_of(photo, GCI_GreenBand),
                                 band_of(photo, GCI_BlueBand)};
  for (int c = 0; c < 3; ++c) roles.colors[c] = colors >= 3 ? c + 1 : 1;
  if (named[0] && named[1] && named[2]) roles.colors = named;
  const std::array<int, 4> inks{band_of(photo, GCI_CyanBand), band_of(photo, GCI_MagentaBand),
                                band_of(photo, GCI_YellowBand), band_of(photo, GCI_BlackBand)};
  if (std::all_of(inks.begin(), inks.end(), [](int b) { return b > 0; })) roles.inks = inks;
  return roles;
}

/// Samples of up to 64 blocks all over a band: a whole photo takes long to decode. Empty where it cannot be read:
/// whoever reads the photo will say so.
std::vector<double> samples_of(GDALRasterBand& band) {
  constexpr int most_blocks = 64, most_columns = 8, most_side = 256;
  int block_width = 0, block_height = 0;
  band.GetBlockSize(&block_width, &block_height);
  const int all_columns = (band.GetXSize() + block_width - 1) / block_width,
            all_rows = (band.GetYSize() + block_height - 1) / block_height;
  const int columns = std::min(most_columns, all_columns), rows = std::min(most_blocks / columns, all_rows);
  std::vector<double> samples;
  const GdalErrors silent;
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i) {
      const int col = static_cast<int>((2 * i + 1) * std::int64_t{all_columns} / (2 * columns)) * block_width,
                row = static_cast<int>((2 * j + 1) * std::int64_t{all_rows} / (2 * rows)) * block_height;
      const int width = std::min(block_width, band.GetXSize() - col),
                height = std::min(block_height, band.GetYSize() - row);
      const int side_x = std::min(width, block_height == 1 ? most_side * 4 : most_side),
                side_y = std::min(height, most_side);
      std::vector<double> block(static_cast<std::size_t>(side_x) * static_cast<std::size_t>(side_y));
      if (band.RasterIO(GF_Read, col, row, width, height, block.data(), side_x, side_y, GDT_Float64, 0, 0, nullptr) !=
          CE_None)
        return {};
      samples.insert(samples.end(), block.begin(), block.end());
    }
  return samples;
}

/// What a band of transparency means by "seen"; 0 where it is no such band. Masks are mostly clear-cut: of the pixels
/// that are not transparent, most have one value, if only at the soft rims of mosaics they have not.
double full_alpha(const std::vector<double>& alpha, double usual) {
  std::size_t shown = 0, full = 0;
  double first = 0.0;
  bool all_same = true;
  for (const double value : alpha) {
    if (value == 0.0) continue;
    if (shown == 0) first = value;
    ++shown;
    full += value == usual ? 1 : 0;
    all_same = all_same && value == first;
  }
  if (shown == 0) return usual;
  if (all_same) return first;
  return 2 * full >= shown ? usual : 0.0;
}

double usual_full_alpha(GDALDataType type) {
  return type == GDT_Byte ? 255.0 : type == GDT_Int16 ? 32767.0 : type == GDT_UInt16 ? 65535.0 : 1.0;
}

struct SampleRange {
  double low = 0.0, high = 255.0;
};

/// The range that the colours fill, but for half a per cent at each end: single odd samples must not darken the photo.
/// Samples of no data, and pixels that are 0 or the most in all bands, do not count.
SampleRange range_of(const fs::path& path, GDALDataset& photo, const std::array<int, 3>& colors) {
  constexpr double left_out = 0.005;
  std::array<std::vector<double>, 3> bands;
  for (std::size_t c = 0; c < 3; ++c) bands[c] = samples_of(*photo.GetRasterBand(colors[c]));
  GDALRasterBand& first = *photo.GetRasterBand(colors[0]);
  int has_nodata = 0;
  const double nodata = first.GetNoDataValue(&has_nodata), most = usual_full_alpha(first.GetRasterDataType());
  std::vector<double> counted;
  for (std::size_t i = 0; i < bands[0].size() && i < bands[1].size() && i < bands[2].size(); ++i) {
    const auto all_are = [&](double value) {
      return std::all_of(bands.begin(), bands.end(), [&](const auto& band) { return band[i] == value; });
    };
    if (all_are(0.0) || (first.GetRasterDataType() != GDT_Float32 && all_are(most)) || (has_nodata && all_are(nodata)))
      continue;
    for (const auto& band : bands)
      if (std::isfinite(band[i])) counted.push_back(band[i]);
  }
  std::sort(counted.begin(), counted.end());
  const auto quantile = [&](double q) {
    return counted[static_cast<std::size_t>(q * static_cast<double>(counted.size() - 1))];
  };
  if (counted.empty() || !(quantile(left_out) < quantile(1.0 - left_out)))
    throw InputError(path.string(),
                     fmt::format("has {} samples of one value; convert it: gdal_translate -ot Byte -scale LOW HIGH IN "
                                 "OUT.tif",
                                 GDALGetDataTypeName(first.GetRasterDataType())));
  const bool is_8_bit = counted.front() >= 0.0 && counted.back() <= 255.0 && counted.back() > 1.0;
  return is_8_bit ? SampleRange{} : SampleRange{quantile(left_out), quantile(1.0 - left_out)};
}

/// As inks are laid over each other, without a profile of the press.
DatasetPtr rgb_of_inks(GDALDataset& photo, const std::array<int, 4>& inks) {
  return computed_photo(photo, 3, [&photo, inks](int band, const ComputedWindow& window, std::uint8_t* pixels) {
    const std::size_t size = static_cast<std::size_t>(window.width) * static_cast<std::size_t>(window.height);
    std::vector<std::uint8_t> black(size);
    if (!read_band(*photo.GetRasterBand(inks[static_cast<std::size_t>(band - 1)]), window, pixels) ||
        !read_band(*photo.GetRasterBand(inks[3]), window, black.data()))
      return false;
    for (std::size_t i = 0; i < size; ++i)
      pixels[i] = static_cast<std::uint8_t>(((255 - pixels[i]) * (255 - black[i]) + 127) / 255);
    return true;
  });
}

/// Entries that are transparent, or that stand for no data, become alpha.
DatasetPtr rgb_of_palette(GDALDataset& photo, GDALRasterBand& band) {
  const GDALColorTable& table = *band.GetColorTable();
  int shows_all = 1;
  (void)band.GetNoDataValue(&shows_all);
  bool some_hidden = shows_all != 0;
  for (int i = 0; i < table.GetColorEntryCount(); ++i) some_hidden = some_hidden || table.GetColorEntry(i)->c4 < 255;
  std::vector<std::string> arguments{"-expand", some_hidden ? "rgba" : "rgb"};
  if (photo.GetRasterCount() > 1) arguments.insert(arguments.end(), {"-b", "1"});
  return translate_to_vrt(photo, arguments);
}

/// Looks at the band of transparency: the value that means "seen", and none of it where it is no such band.
double look_at_alpha(const fs::path& path, GDALDataset& photo, BandRoles& roles, std::vector<PhotoOddity>& oddities) {
  GDALRasterBand& band = *photo.GetRasterBand(roles.alpha);
  const double usual = usual_full_alpha(band.GetRasterDataType());
  const double full = full_alpha(samples_of(band), usual);
  const Vec2 middle{0.5 * photo.GetRasterXSize(), 0.5 * photo.GetRasterYSize()};
  if (full <= 0.0) {
    oddities.push_back(
        {"photo.alpha_is_none",
         fmt::format("{}: band {} is said to be transparency and holds values all over, as near infrared "
                     "does: it is left out; name it: gdal_translate -colorinterp_{} undefined IN OUT.tif",
                     path.filename().string(), roles.alpha, roles.alpha),
         middle});
    roles.alpha = 0;
  } else if (full != usual) {
    oddities.push_back({"photo.alpha_range",
                        fmt::format("{}: the transparency of band {} goes to {:g}, not to {:g}: {:g} is taken for seen",
                                    path.filename().string(), roles.alpha, full, usual, full),
                        middle});
  }
  return full;
}

/// Options that bring the colours to 1..255; 0 is left for no data.
void scale_samples(const fs::path& path, GDALDataset& photo, const std::array<int, 3>& colors,
                   std::vector<std::string>& arguments, std::vector<PhotoOddity>& oddities) {
  GDALRasterBand& first = *photo.GetRasterBand(colors[0]);
  const char* type = GDALGetDataTypeName(first.GetRasterDataType());
  if (colors[0] == colors[1])  // terrain has one band, too
    throw InputError(
        path.string(),
        fmt::format("has {} samples, need 8 bit; convert it: gdal_translate -ot Byte -scale IN OUT.tif", type));
  const SampleRange range = range_of(path, photo, colors);
  const bool as_it_is = range.low == 0.0 && range.high == 255.0;
  for (const char* band : {"-scale_1", "-scale_2", "-scale_3"})
    arguments.insert(arguments.end(), {band, fmt::format("{:.10g}", range.low), fmt::format("{:.10g}", range.high),
                                       as_it_is ? "0" : "1", "255"});
  arguments.insert(arguments.end(), {"-ot", "Byte"});
  int has_nodata = 0;
  (void)first.GetNoDataValue(&has_nodata);
  if (has_nodata) arguments.insert(arguments.end(), {"-a_nodata", "0"});
  if (as_it_is) return;
  oddities.push_back(
      {"photo.sample_range",
       fmt::format("{}: has {} samples, and no format says which are black and white: {:.6g} and {:.6g}, between "
                   "which 99 % of them lie; choose others: gdal_translate -ot Byte -scale LOW HIGH IN OUT.tif",
                   path.filename().string(), type, range.low, range.high),
       {0.5 * photo.GetRasterXSize(), 0.5 * photo.GetRasterYSize()}});
}

void tell_inks(const fs::path& path, GDALDataset& photo, std::vector<PhotoOddity>& oddities) {
  oddities.push_back({"photo.inks",
                      fmt::format("{}: its bands are inks (CMYK), taken for colours without a profile of the press; "
                                  "convert it with its profile where colours matter",
                                  path.filename().string()),
                      {0.5 * photo.GetRasterXSize(), 0.5 * photo.GetRasterYSize()}});
}

bool was_inks(GDALDataset& photo) {
  const char* space = photo.GetMetadataItem("SOURCE_COLOR_SPACE", "IMAGE_STRUCTURE");
  return space && std::string_view(space) == "CMYK";
}
}  // namespace

RgbPhoto rgb_bands(const fs::path& path, GDALDataset& photo) {
  RgbPhoto result;
  GDALRasterBand& first = *photo.GetRasterBand(1);
  if (first.GetColorTable()) {
    result.view = rgb_of_palette(photo, first);
    return result;
  }
  BandRoles roles = roles_of(photo);
  if (roles.inks[0] && first.GetRasterDataType() == GDT_Byte) {
    tell_inks(path, photo, result.oddities);
    result.view = rgb_of_inks(photo, roles.inks);
    return result;
  }
  if (was_inks(photo)) tell_inks(path, photo, result.oddities);
  const double full = roles.alpha ? look_at_alpha(path, photo, roles, result.oddities) : 0.0;
  std::vector<std::string> arguments;
  for (const int color : roles.colors) arguments.insert(arguments.end(), {"-b", std::to_string(color)});
  if (roles.alpha) arguments.insert(arguments.end(), {"-b", std::to_string(roles.alpha), "-colorinterp_4", "alpha"});
  const bool is_byte = first.GetRasterDataType() == GDT_Byte;
  if (!is_byte) scale_samples(path, photo, roles.colors, arguments, result.oddities);
  if (roles.alpha && full != 255.0)
    arguments.insert(arguments.end(), {"-scale_4", "0", fmt::format("{:.10g}", full), "0", "255"});
  const bool in_order = roles.colors == std::array<int, 3>{1, 2, 3};
  const bool as_it_is = is_byte && in_order &&
                        (roles.alpha == 4 ? full == 255.0 && photo.GetRasterCount() == 4
                                          : roles.alpha == 0 && photo.GetRasterCount() == 3);
  if (!as_it_is) result.view = translate_to_vrt(photo, arguments);
  return result;
}

RgbPhoto rgb_photo(const fs::path& path, GDALDataset& photo) {
  RgbPhoto result = rgb_bands(path, photo);
  GDALDataset& rgb = result.view ? *result.view : photo;
  std::optional<PhotoCollar> collar = find_collar(rgb);
  if (!collar) return result;
  result.oddities.push_back(
      {"photo.collar",
       fmt::format("{}: {:.0f} % of it are flat and {} up to its border, and nothing declares it: taken for no data; "
                   "declare it: nearblack -setalpha IN -o OUT.tif",
                   path.filename().string(), std::max(1.0, 100.0 * collar->share), collar->colors()),
       collar->middle_px});
  result.view = without_collar(std::move(result.view), rgb, std::move(*collar));
  return result;
}

}  // namespace orthodrive::io
