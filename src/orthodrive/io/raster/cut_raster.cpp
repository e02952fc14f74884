// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/io/raster/cut_raster.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "orthodrive/core/error.hpp"
#include "orthodrive/core/printable.hpp"
#include "orthodrive/io/raster/join_rasters.hpp"
#include "orthodrive/io/raster/raster_layers.hpp"
#include "orthodrive/io/raster/raster_support.hpp"

namespace orthodrive::io {
namespace {
namespace fs = std::filesystem;

/// In whole pixels of the raster; clipped to it.
PixelBox window_of(const Georeference& g, GDALDataset& raster, const SiteFrame& site, double margin_m,
                   const std::string& name) {
  if (g.c[2] != 0.0 || g.c[4] != 0.0) throw InputError(name, "lies turned; warp it first: gdalwarp IN OUT.tif");
  const Box2 box = box_in_crs(site, margin_m, g.reference);
  const double columns[2] = {(box.min_x - g.c[0]) / g.c[1], (box.max_x - g.c[0]) / g.c[1]},
               rows[2] = {(box.max_y - g.c[3]) / g.c[5], (box.min_y - g.c[3]) / g.c[5]};
  const auto limited = [](double value, int most) {
    return static_cast<int>(std::clamp(value, 0.0, static_cast<double>(most)));
  };
  const int col = limited(std::floor(std::min(columns[0], columns[1])), raster.GetRasterXSize()),
            end_col = limited(std::ceil(std::max(columns[0], columns[1])), raster.GetRasterXSize());
  const int row = limited(std::floor(std::min(rows[0], rows[1])), raster.GetRasterYSize()),
            end_row = limited(std::ceil(std::max(rows[0], rows[1])), raster.GetRasterYSize());
  if (end_col <= col || end_row <= row)
    throw InputError(
        name, fmt::format(
                  "shows nothing of the area: it covers {}, the area is {}; take another source or area",
                  describe_lonlat(bounds_of(outline_lonlat(g, raster.GetRasterXSize(), raster.GetRasterYSize()).outer)),
                  describe_lonlat(lonlat_bounds(site.area.outer, site.crs))));
  return {col, row, end_col - col, end_row - row};
}

/// Red, green, blue and alpha of a photo: near infrared is left out.
std::vector<std::string> band_arguments(GDALDataset& raster) {
  if (!is_photo(raster) || raster.GetRasterCount() == 3) return {};
  std::vector<std::string> arguments{"-b", "1", "-b", "2", "-b", "3"};
  for (int b = 4; b <= raster.GetRasterCount(); ++b)
    if (raster.GetRasterBand(b)->GetColorInterpretation() == GCI_AlphaBand) {
      arguments.insert(arguments.end(), {"-b", std::to_string(b)});
      break;
    }
  return arguments;
}

/// What GDAL does with servers, for this thread. Files of this machine may have others beside them (.tfw, .prj).
struct HttpManners {
  HttpManners(const CutRasterOptions& o, bool of_server)
      : attempts(std::to_string(o.attempts)),
        stall(fmt::format("{:.0f}", std::max(1.0, o.stall_s))),
        retry("GDAL_HTTP_MAX_RETRY", attempts.c_str()),
        low_speed("GDAL_HTTP_LOW_SPEED_TIME", stall.c_str()),
        listing("GDAL_DISABLE_READDIR_ON_OPEN", of_server ? "EMPTY_DIR" : "FALSE") {}
  std::string attempts, stall;
  ScopedGdalOption retry, low_speed, listing;
  ScopedGdalOption delay{"GDAL_HTTP_RETRY_DELAY", "0.5"}, least{"GDAL_HTTP_LOW_SPEED_LIMIT", "1"},
      connect{"GDAL_HTTP_CONNECTTIMEOUT", "15"};
  ScopedGdalOption agent{"GDAL_HTTP_USERAGENT", "orthodrive (map data for an area, asked once and kept)"};
  ScopedGdalOption merge{"GDAL_HTTP_MERGE_CONSECUTIVE_RANGES", "YES"};
  ScopedGdalOption one_by_one{"GDAL_HTTP_MULTIRANGE", "SERIAL"};  // GDAL 3.6 asks several ranges at once only once
};
}  // namespace

CutRaster cut_raster(const std::vector<std::string>& names, const SiteFrame& site, const fs::path& to,
                     const CutRasterOptions& options) {
  start_gdal();
  const HttpManners manners(options, std::any_of(names.begin(), names.end(), is_on_server));
  JoinedRasters all = join_rasters(names, site, to, options);
  const Georeference g = georeference_of(names.front(), all.raster());
  const PixelBox window = window_of(g, all.raster(), site, options.margin_m, names.front());
  all.mark_holes(names, window);
  GDALDataset& raster = all.raster();
  const double gsd_m = pixel_size(g, raster.GetRasterXSize(), raster.GetRasterYSize()).gsd_m();
  std::vector<std::string> arguments{"-srcwin", std::to_string(window.col), std::to_string(window.row),
                                     std::to_string(window.width), std::to_string(window.height)};
  const std::vector<std::string> bands = band_arguments(raster);
  arguments.insert(arguments.end(), bands.begin(), bands.end());
  const double coarser = options.gsd_m > 1.05 * gsd_m ? options.gsd_m / gsd_m : 1.0;
  if (coarser > 1.0)
    arguments.insert(arguments.end(), {"-r", "average", "-outsize",
                                       fmt::format("{:.0f}", std::max(1.0, std::round(window.width / coarser))),
                                       fmt::format("{:.0f}", std::max(1.0, std::round(window.height / coarser)))});
  require_possible_pixels(names.front(), static_cast<double>(window.width) * window.height / (coarser * coarser),
                          gsd_m * coarser);
  DatasetPtr part = translate_to_vrt(raster, arguments);
  if (!options.vertical_unit.empty())
    for (int b = 1; b <= part->GetRasterCount(); ++b)
      part->GetRasterBand(b)->SetUnitType(options.vertical_unit.c_str());
  const std::string& datum = options.vertical_datum.empty() ? all.vertical_datum : options.vertical_datum;
  if (!datum.empty()) part->SetMetadataItem(vertical_datum_item, datum.c_str());
  int has_nodata = 0;
  (void)part->GetRasterBand(1)->GetNoDataValue(&has_nodata);
  try {
    create_copy(to, "COG", *part,
                is_photo(*part) && !has_nodata ? photo_cog_options({.jpeg_quality = 95}) : dtm_cog_options());
  } catch (const Error& error) {
    const std::string what = error.what();
    const bool of_server = what.find("response_code") != std::string::npos || what.find("HTTP") != std::string::npos ||
                           what.find("CURL") != std::string::npos || what.find("Curl") != std::string::npos;
    if (!of_server) throw;  // of the disk
    throw InputError(names.front(), fmt::format("cannot be read to its end: {}; run it again", printable(what)));
  }
  return {crs_of(g.reference), gsd_m * coarser, part->GetRasterXSize(), part->GetRasterYSize()};
}

}  // namespace orthodrive::io
