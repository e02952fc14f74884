// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/io/raster/opened_rasters.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "orthodrive/core/error.hpp"
#include "orthodrive/core/printable.hpp"
#include "orthodrive/core/stop.hpp"
#include "orthodrive/io/raster/raster_support.hpp"
#include "roadquery/text/text.hpp"

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

bool same_crs(const OGRSpatialReference& a, const OGRSpatialReference& b) {
  const char* const options[] = {"IGNORE_DATA_AXIS_TO_SRS_AXIS_MAPPING=YES", nullptr};
  return a.IsSame(&b, options) != 0;
}

std::string wkt_of(const OGRSpatialReference& reference) {
  const char* const options[] = {"FORMAT=WKT2_2018", nullptr};
  char* wkt = nullptr;
  (void)reference.exportToWkt(&wkt, options);
  std::string text = wkt ? wkt : "";
  CPLFree(wkt);
  return text;
}

bool is_north_up(const OpenedRaster& raster) {
  return raster.has_place && raster.c[2] == 0.0 && raster.c[4] == 0.0 && raster.c[1] > 0.0 && raster.c[5] < 0.0;
}

namespace {
bool same_nodata(const OpenedRaster& a, const OpenedRaster& b) {
  if (!a.nodata || !b.nodata) return !a.nodata && !b.nodata;
  return *a.nodata == *b.nodata || (std::isnan(*a.nodata) && std::isnan(*b.nodata));
}
}  // namespace

std::string no_height_of(GDALDataType type) {
  if (GDALDataTypeIsFloating(type)) return "nan";
  return type == GDT_Byte ? "255" : type == GDT_UInt16 ? "65535" : type == GDT_UInt32 ? "4294967295" : "-32768";
}

std::vector<std::string> nodata_for_all(const std::vector<const OpenedRaster*>& rasters) {
  const bool same = std::all_of(rasters.begin(), rasters.end(),
                                [&](const OpenedRaster* r) { return same_nodata(*rasters.front(), *r); });
  if (same) return {};
  return {"-vrtnodata", no_height_of(rasters.front()->type)};
}

bool fit_on_one_grid(const OpenedRaster& a, const OpenedRaster& b) {
  constexpr double most = 0.01;
  return is_north_up(a) && is_north_up(b) && a.colours == b.colours && a.type == b.type &&
         (a.type != GDT_Byte || same_nodata(a, b)) && std::abs(a.c[1] / b.c[1] - 1.0) < most &&
         std::abs(a.c[5] / b.c[5] - 1.0) < most && same_crs(a.horizontal, b.horizontal);
}

namespace {
std::string unit_of_heights(GDALRasterBand& band, const OGRSpatialReference* reference) {
  static const std::set<std::string> metres{"m", "metre", "meter", "metres", "meters"};
  std::string unit = band.GetUnitType();
  if (unit.empty() && reference && reference->IsVertical()) {
    const char* name = nullptr;
    (void)reference->GetTargetLinearUnits("VERT_CS", &name);
    if (name) unit = name;
  }
  return metres.contains(roadquery::lowered(unit)) ? "" : unit;
}

OpenedRaster described_raster(const std::string& name, DatasetPtr dataset) {
  OpenedRaster raster;
  raster.name = name;
  GDALRasterBand& band = *dataset->GetRasterBand(1);
  raster.width = dataset->GetRasterXSize(), raster.height = dataset->GetRasterYSize();
  raster.bands = dataset->GetRasterCount(), raster.type = band.GetRasterDataType();
  for (int b = 1; b <= raster.bands; ++b) raster.colours.push_back(dataset->GetRasterBand(b)->GetColorInterpretation());
  int declared = 0;
  const double nodata = band.GetNoDataValue(&declared);
  if (declared != 0) raster.nodata = nodata;
  raster.has_place = dataset->GetGeoTransform(raster.c) == CE_None;
  raster.palette = band.GetColorInterpretation() == GCI_PaletteIndex;
  raster.scaled = band.GetScale(nullptr) != 1.0 || band.GetOffset(nullptr) != 0.0;
  const OGRSpatialReference* reference = dataset->GetSpatialRef();
  if (reference && !reference->IsEmpty() && !reference->IsLocal()) {
    raster.horizontal = *reference, raster.names_crs = true;
    raster.compound = reference->IsCompound() != 0;
    if (raster.compound) raster.horizontal.StripVertical();
    raster.horizontal.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
    if (const char* datum = reference->GetAttrValue("VERT_DATUM")) raster.vertical_datum = datum;
  }
  raster.vertical_unit = unit_of_heights(band, reference);
  raster.dataset = std::move(dataset);
  return raster;
}

/// Of those that name one, if it is the same in all.
const OGRSpatialReference* common_crs(const std::vector<OpenedRaster>& rasters) {
  const OGRSpatialReference* common = nullptr;
  for (const OpenedRaster& raster : rasters) {
    if (!raster.names_crs) continue;
    if (common && !same_crs(*common, raster.horizontal)) return nullptr;
    common = &raster.horizontal;
  }
  return common;
}
}  // namespace

std::vector<OpenedRaster> open_all(const std::vector<std::string>& names, const CutRasterOptions& options) {
  const bool keep_open = names.size() == 1 || std::any_of(names.begin(), names.end(), is_on_server);
  std::vector<OpenedRaster> rasters;
  for (const std::string& name : names) {
    throw_if_stopped();
    rasters.push_back(described_raster(name, open_raster(name, options.of_strangers)));
    if (!keep_open) rasters.back().dataset.reset();
  }
  const OGRSpatialReference* common = common_crs(rasters);
  for (std::size_t i = 0; i < rasters.size(); ++i) {
    OpenedRaster& raster = rasters[i];
    if (raster.names_crs) continue;
    if (i < options.crs_by_default.size() && !options.crs_by_default[i].empty())
      raster.horizontal = spatial_reference({options.crs_by_default[i]});
    else if (common)
      raster.horizontal = *common;
    else if (rasters.size() > 1)
      throw InputError(raster.name,
                       "names no CRS, and neither does its index or all of the others; say it with crs = \"EPSG:n\"");
  }
  return rasters;
}

}  // namespace orthodrive::io
