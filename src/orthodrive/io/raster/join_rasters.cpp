// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/io/raster/join_rasters.hpp"

#include <fmt/format.h>
#include <gdal_utils.h>

#include <algorithm>

#include "orthodrive/core/error.hpp"
#include "orthodrive/core/printable.hpp"
#include "orthodrive/core/stop.hpp"
#include "orthodrive/geo/overlay.hpp"

namespace orthodrive::io {

bool is_on_server(const std::string& name) { return name.starts_with("http://") || name.starts_with("https://"); }

DatasetPtr open_raster(const std::string& name, bool of_strangers) {
  GdalErrors errors;
  GdalOptions drivers(is_on_server(name) || of_strangers ? raster_drivers_for_strangers() : std::vector<std::string>{});
  const std::string path = is_on_server(name) ? "/vsicurl/" + name : name;
  DatasetPtr dataset(GDALDataset::Open(path.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY,
                                       is_on_server(name) || of_strangers ? drivers.get() : nullptr));
  if (!dataset)
    throw InputError(name, fmt::format("cannot be read as a raster{}; check the url",
                                       errors.any() ? " (" + printable(errors.text()) + ")" : ""));
  if (of_strangers && !is_on_server(name)) require_plausible_blocks(name, *dataset);
  return dataset;
}

bool is_photo(GDALDataset& raster) {
  return raster.GetRasterBand(1)->GetRasterDataType() == GDT_Byte && raster.GetRasterCount() >= 3;
}

namespace {
/// As gdalbuildvrt makes it. Names are in the order of precedence.
DatasetPtr built_vrt(const std::vector<std::string>& names, const std::vector<DatasetPtr>& sources,
                     const std::vector<std::string>& extra) {
  std::vector<GDALDatasetH> handles;
  std::vector<const char*> paths;
  for (std::size_t i = names.size(); i-- > 0;)  // in a virtual raster the last lies on top
    if (sources.size() == names.size())
      handles.push_back(GDALDataset::ToHandle(sources[i].get()));
    else
      paths.push_back(names[i].c_str());
  GdalOptions arguments(extra);
  const std::unique_ptr<GDALBuildVRTOptions, void (*)(GDALBuildVRTOptions*)> options(
      GDALBuildVRTOptionsNew(arguments.get(), nullptr), GDALBuildVRTOptionsFree);
  GdalErrors errors;
  int failed = 0;
  DatasetPtr result(GDALDataset::FromHandle(
      GDALBuildVRT("", static_cast<int>(names.size()), handles.empty() ? nullptr : handles.data(),
                   handles.empty() ? paths.data() : nullptr, options.get(), &failed)));
  if (!result || errors.any())
    throw InputError(names.front(), fmt::format("cannot be joined with the others ({})", printable(errors.text())));
  return result;
}

Polygon rectangle(double left, double top, double right, double bottom) {
  return {{{left, top}, {right, top}, {right, bottom}, {left, bottom}}, {}};
}
}  // namespace

JoinedRasters join_rasters(const std::vector<std::string>& names, const CutRasterOptions& options) {
  JoinedRasters all;
  const bool keep_open = names.size() == 1 || std::any_of(names.begin(), names.end(), is_on_server);
  DatasetPtr first;
  for (const std::string& name : names) {
    throw_if_stopped();
    DatasetPtr source = open_raster(name, options.of_strangers);
    const OGRSpatialReference* reference = source->GetSpatialRef();
    const OGRSpatialReference* of_first = first                  ? first->GetSpatialRef()
                                          : !all.sources.empty() ? all.sources.front()->GetSpatialRef()
                                                                 : reference;
    const bool nameless = !reference && !of_first && !options.crs_by_default.empty();
    if (names.size() > 1 && !nameless && (!reference || !of_first || !of_first->IsSame(reference)))
      throw InputError(name, fmt::format("has another CRS than {}; give it a [[fetch]] of its own", names.front()));
    if (nameless) all.vrt_options = {"-a_srs", options.crs_by_default};
    double c[6];
    if (source->GetGeoTransform(c) == CE_None)
      all.outlines.push_back(
          rectangle(c[0], c[3], c[0] + c[1] * source->GetRasterXSize(), c[3] + c[5] * source->GetRasterYSize()));
    if (keep_open)
      all.sources.push_back(std::move(source));
    else if (!first)
      first = std::move(source);
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
