// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/io/raster/join_rasters.hpp"

#include <algorithm>

#include "orthodrive/geo/overlay.hpp"
#include "orthodrive/io/raster/raster_layers.hpp"

namespace orthodrive::io {

namespace {
Polygon rectangle(double left, double top, double right, double bottom) {
  return {{{left, top}, {right, top}, {right, bottom}, {left, bottom}}, {}};
}
}  // namespace

JoinedRasters join_rasters(const std::vector<std::string>& names, const SiteFrame& site,
                           const std::filesystem::path& to, const CutRasterOptions& options) {
  JoinedRasters all;
  std::vector<OpenedRaster> rasters = open_all(names, options);
  const OpenedRaster& first = rasters.front();
  const bool fit = rasters.size() == 1 || std::all_of(rasters.begin(), rasters.end(),
                                                      [&](const auto& r) { return fit_on_one_grid(first, r); });
  // With and without heights, with and without a name: on the map it is the same CRS.
  const bool differ = std::any_of(rasters.begin(), rasters.end(), [&](const OpenedRaster& r) {
    return r.compound != first.compound || (!r.names_crs && !r.horizontal.IsEmpty());
  });
  if (differ || !fit)
    for (const OpenedRaster& raster : rasters)
      if (all.vertical_datum.empty()) all.vertical_datum = raster.vertical_datum;
  if (!fit) {
    DrawnRaster drawn = draw_rasters(rasters, site, to, options);
    all.drawn = std::move(drawn.file), all.mosaic = std::move(drawn.raster);
    return all;
  }
  if (differ) all.vrt_options = {"-a_srs", wkt_of(first.horizontal), "-allow_projection_difference"};
  std::vector<const OpenedRaster*> members;
  members.reserve(rasters.size());
  for (const OpenedRaster& r : rasters) members.push_back(&r);
  const std::vector<std::string> nodata = nodata_for_all(members);
  all.vrt_options.insert(all.vrt_options.end(), nodata.begin(), nodata.end());
  for (OpenedRaster& r : rasters) {
    if (r.has_place)
      all.outlines.push_back(rectangle(r.c[0], r.c[3], r.c[0] + r.c[1] * r.width, r.c[3] + r.c[5] * r.height));
    if (r.dataset) all.sources.push_back(std::move(r.dataset));
  }
  if (names.size() > 1 || !all.vrt_options.empty()) all.mosaic = built_vrt(names, all.sources, all.vrt_options);
  return all;
}

void JoinedRasters::mark_holes(const std::vector<std::string>& names, const PixelBox& window) {
  int has_nodata = 0;
  if (!mosaic) return;
  GDALRasterBand& band = *mosaic->GetRasterBand(1);
  (void)band.GetNoDataValue(&has_nodata);
  const GDALDataType type = band.GetRasterDataType();
  const bool signed_integers = type == GDT_Int16 || type == GDT_Int32;
  double c[6];
  if (has_nodata || (band.GetMaskFlags() & GMF_ALPHA) || mosaic->GetGeoTransform(c) != CE_None) return;
  std::vector<Polygon> shown;
  for (const Polygon& outline : outlines) {
    const Box2 box = bounds_of(outline.outer);
    shown.push_back(rectangle((box.min_x - c[0]) / c[1] - window.col, (box.max_y - c[3]) / c[5] - window.row,
                              (box.max_x - c[0]) / c[1] - window.col, (box.min_y - c[3]) / c[5] - window.row));
  }
  double missing_px = 0.0;
  constexpr double grid_px = 0.01;
  for (const Polygon& hole :
       difference_of({rectangle(0, 0, window.width, window.height)}, union_of(shown, grid_px), grid_px))
    missing_px += area_m2(hole);
  if (missing_px < 0.5) return;
  if (is_photo(*mosaic))
    vrt_options.emplace_back("-addalpha");
  else if (GDALDataTypeIsFloating(type) || signed_integers)
    vrt_options.insert(vrt_options.end(), {"-vrtnodata", signed_integers ? "-32768" : "nan"});
  else
    return;
  mosaic = built_vrt(names, sources, vrt_options);
}

}  // namespace orthodrive::io
