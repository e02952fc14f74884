// SPDX-License-Identifier: Apache-2.0
// Several photos of a site as one.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "orthodrive/core/error.hpp"
#include "orthodrive/geo/area_places.hpp"
#include "orthodrive/io/raster/raster_io.hpp"
#include "orthodrive/io/support/gdal_support.hpp"
#include "orthodrive/model/rasters/photo_mosaic.hpp"

namespace orthodrive::io {
namespace fs = std::filesystem;

namespace {
/// Means of the photo's pixels on a coarse grid. GDAL warps a block from all pixels below it, so the photo is read at
/// most so many times coarser than it is, and the rest is done here.
Photo read_overview(const fs::path& path, const Crs& crs, const GridFrame& cells, int threads) {
  constexpr double most_times_coarser = 16.0;
  constexpr int rows = 512;
  const double parts = std::ceil(cells.gsd_m / (most_times_coarser * raster_info(path).gsd_m));
  const PhotoSource photo = open_photo(path, {crs, polygon_of(cells.bounds())},
                                       {.gsd_m = cells.gsd_m / parts, .threads = threads, .overviews = true});
  Raster<std::uint32_t> sums(cells.width, cells.height, 4);  // of the channels, and the number of pixels with data
  const auto cell_of = [&](int col, int row) {
    const Vec2 cell = cells.pixel_from_world(photo.frame.center_of(col, row));
    return std::pair(static_cast<int>(std::floor(cell.x)), static_cast<int>(std::floor(cell.y)));
  };
  for (int top = 0; top < photo.frame.height; top += rows) {
    const PhotoWindow strip = photo.read({0, top, photo.frame.width, std::min(rows, photo.frame.height - top)});
    for (int row = 0; row < strip.valid.height; ++row)
      for (int col = 0; col < strip.valid.width; ++col) {
        const auto [to_col, to_row] = cell_of(col, top + row);
        if (!strip.valid.at(col, row) || !sums.inside(to_col, to_row)) continue;
        for (int c = 0; c < 3; ++c) sums.at(to_col, to_row, c) += strip.rgb.at(col, row, c);
        ++sums.at(to_col, to_row, 3);
      }
  }
  Photo overview{crs, cells, Raster<std::uint8_t>(cells.width, cells.height, 3),
                 Raster<std::uint8_t>(cells.width, cells.height)};
  for (std::size_t cell = 0; cell < overview.valid.data.size(); ++cell) {
    const std::uint32_t* sum = &sums.data[4 * cell];
    if (2.0 * sum[3] < parts * parts) continue;
    overview.valid.data[cell] = 1;
    for (std::size_t c = 0; c < 3; ++c)
      overview.rgb.data[3 * cell + c] = static_cast<std::uint8_t>((sum[c] + sum[3] / 2) / sum[3]);
  }
  return overview;
}

bool shows_area(const Photo& overview, const Polygon& area) {
  bool shows = false;
  visit_area(area, overview.frame.gsd_m, [&](Vec2 p) {
    const Vec2 cell = overview.frame.pixel_from_world(p);
    const int col = static_cast<int>(std::floor(cell.x)), row = static_cast<int>(std::floor(cell.y));
    shows = shows || (overview.valid.inside(col, row) && overview.valid.at(col, row) != 0);
  });
  return shows;
}

/// The photos whose extent reaches the area; the others become findings.
std::vector<fs::path> photos_here(const std::vector<fs::path>& paths, const SiteFrame& site,
                                  std::vector<fs::path>& elsewhere) {
  std::vector<fs::path> here;
  const Box2 area = lonlat_bounds(site.area.outer, site.crs);
  for (const fs::path& path : paths)
    (bounds_of(raster_info(path).outline_lonlat.outer).overlaps(area) ? here : elsewhere).push_back(path);
  return here;
}

Finding elsewhere_finding(const fs::path& path, const SiteFrame& site) {
  const Box2 box = bounds_of(site.area.outer);
  return {Severity::warning, "photo.elsewhere",
          fmt::format("{} shows nothing of the area and is left out", path.filename().string()),
          0.5 * (box.min_x + box.max_x), 0.5 * (box.min_y + box.max_y)};
}
}  // namespace

PhotoSource open_photo(const std::vector<fs::path>& paths, const SiteFrame& site, const ReadPhotoOptions& options,
                       Findings* findings) {
  if (paths.empty()) throw OptionError("no photo is given; name at least one");
  if (paths.size() == 1) return open_photo(paths.front(), site, options, findings);
  std::vector<fs::path> elsewhere;
  const std::vector<fs::path> here = photos_here(paths, site, elsewhere);
  // The first alone says where it lies, as one photo does.
  if (here.empty())
    throw InputError(paths.front().string(),
                     fmt::format("shows nothing of the area, and neither do the {} photos after it; the area is {}; "
                                 "take other photos or another area",
                                 paths.size() - 1, describe_lonlat(lonlat_bounds(site.area.outer, site.crs))));
  ReadPhotoOptions of_all = options;
  std::vector<MosaicPhoto> photos;
  PhotoSource blank;
  std::vector<double> gsds_m;
  gsds_m.reserve(here.size());
  for (const fs::path& path : here) gsds_m.push_back(raster_info(path).gsd_m);
  for (const fs::path& path : here) {
    PhotoSource photo = open_photo(path, site, of_all, findings);
    of_all.gsd_m = photo.frame.gsd_m;
    const GridFrame cells = mosaic_overview_frame(photo.frame, gsds_m);
    Photo overview = read_overview(path, site.crs, cells, options.threads);
    if (shows_area(overview, site.area))
      photos.push_back({std::move(photo), std::move(overview)});
    else
      elsewhere.push_back(path), blank = std::move(photo);
  }
  if (findings)
    for (const fs::path& path : elsewhere) findings->push_back(elsewhere_finding(path, site));
  if (photos.empty()) return blank;  // as one photo that has no data in the area
  if (photos.size() == 1) return std::move(photos.front().photo);
  return mosaic_of(std::move(photos));
}

Photo read_photo(const std::vector<fs::path>& paths, const SiteFrame& site, const ReadPhotoOptions& options) {
  if (paths.size() == 1) return read_photo(paths.front(), site, options);
  const PhotoSource source = open_photo(paths, site, options);
  PhotoWindow whole = source.read(pixels_of(source.frame));
  return {source.crs, source.frame, std::move(whole.rgb), std::move(whole.valid)};
}

}  // namespace orthodrive::io
