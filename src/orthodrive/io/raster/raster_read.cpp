// SPDX-License-Identifier: Apache-2.0
// Reading of rasters that are no photos: terrain models and labels.

#include <fmt/format.h>
#include <gdal_utils.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <mutex>
#include <string_view>
#include <utility>

#include "orthodrive/core/error.hpp"
#include "orthodrive/core/parallel.hpp"
#include "orthodrive/geo/area_places.hpp"
#include "orthodrive/io/raster/raster_io.hpp"
#include "orthodrive/io/raster/raster_support.hpp"
#include "orthodrive/io/raster/terrain_datums.hpp"
#include "orthodrive/model/rasters/class_table_json.hpp"
#include "orthodrive/model/rasters/sample_height.hpp"

namespace orthodrive::io {
namespace fs = std::filesystem;

namespace {
constexpr float no_height = std::numeric_limits<float>::quiet_NaN();

/// Runs `arguments` of gdalwarp from `source` into the memory behind `target`.
void warp(const fs::path& path, GDALDataset& source, GDALDataset& target, std::vector<std::string> arguments,
          int threads) {
  // The memory limit decides how GDAL cuts the work, the thread count does not: same bytes for any thread count.
  // No overviews: they are a second, blurred photo. Heights stay as they are, whatever datum a CRS names beside.
  for (const char* argument : {"-novshift", "-wm", "64", "-ovr", "NONE", "-wo"}) arguments.emplace_back(argument);
  arguments.push_back(fmt::format("NUM_THREADS={}", worker_count(threads)));
  GdalOptions list(arguments);
  GdalErrors errors;
  GDALWarpAppOptions* options = GDALWarpAppOptionsNew(list.get(), nullptr);
  GDALDatasetH sources[1] = {GDALDataset::ToHandle(&source)};
  int usage_error = 0;
  const bool done = GDALWarp(nullptr, GDALDataset::ToHandle(&target), 1, sources, options, &usage_error) != nullptr;
  GDALWarpAppOptionsFree(options);
  if (!done || errors.any())
    throw InputError(path.string(),
                     fmt::format("cannot be read to its end ({}); is it truncated? Get the file again", errors.text()));
}

}  // namespace

std::vector<fs::path> raster_files(const fs::path& path) {
  GdalErrors errors;
  const DatasetPtr dataset(GDALDataset::Open(path.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY));
  std::vector<fs::path> files;
  if (dataset) {
    const std::unique_ptr<char*, decltype(&CSLDestroy)> list(dataset->GetFileList(), CSLDestroy);
    for (char** file = list.get(); file && *file; ++file)
      if (fs::path(*file) != path) files.emplace_back(*file);
  }
  std::sort(files.begin(), files.end());
  files.insert(files.begin(), path);
  return files;
}

RasterInfo raster_info(const fs::path& path) {
  const DatasetPtr dataset = open_dataset(path, GDAL_OF_RASTER);
  const Georeference g = georeference_of(path, *dataset);
  require_complete(path, *dataset);
  RasterInfo info{.crs = crs_of(g.reference),
                  .width = dataset->GetRasterXSize(),
                  .height = dataset->GetRasterYSize(),
                  .bands = dataset->GetRasterCount()};
  info.gsd_m = pixel_size(g, info.width, info.height).gsd_m();
  info.outline_lonlat = outline_lonlat(g, info.width, info.height);
  return info;
}

namespace {
/// A DTM of integers with a scale (decimetres, say) read as metres.
DatasetPtr unscaled(GDALDataset& dtm) {
  int has_scale = 0, has_offset = 0;
  GDALRasterBand& band = *dtm.GetRasterBand(1);
  const double scale = band.GetScale(&has_scale), offset = band.GetOffset(&has_offset);
  if (scale == 1.0 && offset == 0.0) return nullptr;
  return translate_to_vrt(dtm, {"-unscale", "-ot", "Float32"});
}

bool lies_on_own_grid(const Georeference& g, const Crs& site_crs) {
  const OGRSpatialReference site = spatial_reference(site_crs);
  const char* const options[] = {"IGNORE_DATA_AXIS_TO_SRS_AXIS_MAPPING=YES", nullptr};
  return g.reference.IsSame(&site, options) && g.c[2] == 0.0 && g.c[4] == 0.0 && g.c[1] > 0.0 &&
         std::abs(g.c[1] + g.c[5]) <= 1e-6 * g.c[1];
}

/// The pixels of the frame that the box needs, without resampling.
HeightGrid read_window(const fs::path& path, GDALDataset& dtm, const Georeference& g, const Box2& box) {
  const int width = dtm.GetRasterXSize(), height = dtm.GetRasterYSize();
  const GridFrame whole{g.c[0], g.c[3], g.c[1], width, height};
  const Vec2 nw = whole.pixel_from_world({box.min_x, box.max_y}), se = whole.pixel_from_world({box.max_x, box.min_y});
  const auto clamped = [](double value, int limit) {
    return static_cast<int>(std::clamp(value, 0.0, static_cast<double>(limit)));
  };
  const int col0 = clamped(std::floor(nw.x), width), row0 = clamped(std::floor(nw.y), height);
  const int col1 = clamped(std::ceil(se.x), width), row1 = clamped(std::ceil(se.y), height);
  HeightGrid grid;
  const Vec2 corner = whole.world_from_pixel(col0, row0);
  grid.frame = {corner.x, corner.y, whole.gsd_m, std::max(0, col1 - col0), std::max(0, row1 - row0)};
  grid.height_m = Raster<float>(grid.frame.width, grid.frame.height);
  if (grid.height_m.empty()) return grid;
  GdalErrors errors;
  GDALRasterBand& band = *dtm.GetRasterBand(1);
  if (band.RasterIO(GF_Read, col0, row0, grid.frame.width, grid.frame.height, grid.height_m.data.data(),
                    grid.frame.width, grid.frame.height, GDT_Float32, 0, 0, nullptr) != CE_None)
    throw InputError(path.string(), fmt::format("cannot be read to its end ({}); get the file again", errors.text()));
  int has_nodata = 0;
  const auto nodata = static_cast<float>(band.GetNoDataValue(&has_nodata));
  if (has_nodata) std::replace(grid.height_m.data.begin(), grid.height_m.data.end(), nodata, no_height);
  return grid;
}

HeightGrid warp_window(const fs::path& path, GDALDataset& dtm, const Crs& crs, const Box2& box,
                       const PixelSize& pixel) {
  HeightGrid grid{.frame = covering_grid(box, rounded_gsd_m(pixel.gsd_m()))};
  grid.height_m = Raster<float>(grid.frame.width, grid.frame.height, 1, no_height);
  const DatasetPtr target = memory_dataset(grid.frame.width, grid.frame.height);
  place(*target, grid.frame, crs);
  wrap_channels(*target, grid.height_m);
  target->GetRasterBand(1)->SetNoDataValue(no_height);
  std::vector<std::string> arguments = cubic_resampling(pixel, grid.frame.gsd_m);
  arguments.insert(arguments.end(), {"-et", "0", "-wo", "INIT_DEST=NO_DATA", "-dstnodata", "nan"});
  warp(path, dtm, *target, arguments, 0);
  target->FlushCache(false);
  return grid;
}

/// What one unit of the file's heights is in metres: the band says it (UNITTYPE), else the vertical CRS, else it is
/// metres.
double height_unit_m(GDALRasterBand& band, const OGRSpatialReference& reference) {
  constexpr double foot_m = 0.3048, us_survey_foot_m = 1200.0 / 3937.0;
  const std::string unit = CPLString(band.GetUnitType()).tolower();
  if (unit.find("survey") != std::string::npos || unit == "us-ft" || unit == "ftus") return us_survey_foot_m;
  if (unit == "ft" || unit == "foot" || unit == "feet") return foot_m;
  constexpr std::pair<std::string_view, double> metric[] = {{"mm", 0.001},    {"cm", 0.01},        {"dm", 0.1},
                                                            {"km", 1000.0},   {"millimet", 0.001}, {"centimet", 0.01},
                                                            {"decimet", 0.1}, {"kilomet", 1000.0}};
  for (const auto& [name, metres] : metric)
    if (name.size() > 2 ? unit.starts_with(name) : unit == name) return metres;
  if (!unit.empty() || !reference.IsVertical()) return 1.0;
  const double unit_m = reference.GetTargetLinearUnits("VERT_CS");
  return unit_m > 0.0 ? unit_m : 1.0;
}

/// In metres. Heights that no land of the earth has, not even in feet, are nodata that the file does not declare
/// (-9999, -32768, 65535, 3.4e38): a road must not lie there. Where nothing else is there and they differ, they are
/// heights in a unit that the file does not tell.
void to_plausible_metres(const fs::path& path, double unit_m, Raster<float>& heights) {
  constexpr double lowest = -1500.0, highest = 30000.0;  // Dead Sea and Mount Everest in feet
  constexpr float beyond_all_units = 1e7F;               // Mount Everest in millimetres
  const double looked_at = std::min(unit_m, 1.0);
  std::size_t plausible = 0;
  float low = std::numeric_limits<float>::infinity(), high = -low;
  for (float& z : heights.data) {
    if (std::abs(z) < beyond_all_units) low = std::min(low, z), high = std::max(high, z);
    const double as_looked_at = looked_at * static_cast<double>(z);
    const bool is_plausible = as_looked_at > lowest && as_looked_at < highest;
    plausible += is_plausible ? 1 : 0;
    z = is_plausible ? static_cast<float>(unit_m * static_cast<double>(z)) : no_height;
  }
  if (plausible > 0 || !(high > low)) return;
  throw InputError(
      path.string(),
      fmt::format("its heights go from {:.0f} to {:.0f} here, no land lies there in metres or feet; say the "
                  "unit, of centimetres: gdal_translate -a_scale 0.01 IN OUT.tif",
                  low, high));
}

/// Colours are no heights: a shaded relief, a drawn map, heights packed into red, green and blue.
void require_heights(const fs::path& path, GDALDataset& dtm) {
  const GDALColorInterp first = dtm.GetRasterBand(1)->GetColorInterpretation();
  const bool is_rgb = dtm.GetRasterCount() >= 3 && first == GCI_RedBand;
  if (!is_rgb && first != GCI_PaletteIndex) return;
  throw InputError(path.string(),
                   "is a picture (red, green, blue or a palette), not a terrain model: need one band of "
                   "heights; the server may hand out another file, or it has to be decoded first");
}

/// Of the CRS; else as cut_raster() was told.
std::string vertical_datum_of(const OGRSpatialReference& reference, GDALDataset& dtm) {
  const char* name = reference.GetAttrValue("VERT_DATUM");
  if (!name) name = dtm.GetMetadataItem(vertical_datum_item);
  return name ? name : "";
}
}  // namespace

HeightGrid read_heights(const fs::path& path, const Crs& crs, const Box2& box) {
  const DatasetPtr source = open_dataset(path, GDAL_OF_RASTER);
  const Georeference g = georeference_of(path, *source);
  require_complete(path, *source);
  require_heights(path, *source);
  const DatasetPtr metres = unscaled(*source);
  GDALDataset& dtm = metres ? *metres : *source;
  HeightGrid grid = lies_on_own_grid(g, crs)
                        ? read_window(path, dtm, g, box)
                        : warp_window(path, dtm, crs, box, pixel_size(g, dtm.GetRasterXSize(), dtm.GetRasterYSize()));
  to_plausible_metres(path, height_unit_m(*source->GetRasterBand(1), g.reference), grid.height_m);
  grid.crs = crs;
  grid.vertical_datum = vertical_datum_of(g.reference, *source);
  return grid;
}

HeightGrid read_dtm(const fs::path& path, const SiteFrame& site, double margin_m) {
  return std::move(read_dtms({path}, site, {.margin_m = margin_m}).front());
}

std::vector<HeightGrid> read_dtms(const std::vector<fs::path>& paths, const SiteFrame& site,
                                  const ReadDtmsOptions& options, Findings* findings) {
  std::vector<HeightGrid> grids;
  grids.reserve(paths.size());
  for (const fs::path& path : paths)
    grids.push_back(read_heights(path, site.crs, bounds_of(site.area.outer).grown(options.margin_m)));
  to_one_datum(paths, bounds_of(site.area.outer), grids, findings);
  const double covered = coverage(grids, site);
  if (covered >= options.least_coverage) return grids;
  std::string names, extents;
  for (const fs::path& path : paths) {
    names += (names.empty() ? "" : ", ") + path.string();
    extents += (extents.empty() ? "" : " and ") + describe_lonlat(bounds_of(raster_info(path).outline_lonlat.outer));
  }
  throw InputError(
      names,
      fmt::format("heights for {:.1f} % of the area only: the terrain covers {}, the area is {}; add a terrain model "
                  "or choose a smaller area",
                  100.0 * covered, extents, describe_lonlat(lonlat_bounds(site.area.outer, site.crs))));
}

double coverage(std::span<const HeightGrid> grids, const SiteFrame& site) {
  double gsd_m = std::numeric_limits<double>::infinity();
  for (const HeightGrid& grid : grids) gsd_m = std::min(gsd_m, grid.frame.gsd_m);
  if (grids.empty()) return 0.0;
  std::size_t inside = 0, known = 0;
  visit_area(site.area, gsd_m, [&](Vec2 p) {
    const auto has_height = [p](const HeightGrid& grid) {
      return !grid.height_m.empty() && !std::isnan(sample_bilinear(grid, p));
    };
    ++inside;
    known += std::any_of(grids.begin(), grids.end(), has_height) ? 1 : 0;
  });
  return inside == 0 ? 0.0 : static_cast<double>(known) / static_cast<double>(inside);
}

namespace {
/// The one band of 8 bit that label maps and confidence rasters have.
GDALRasterBand& byte_band(const fs::path& path, GDALDataset& dataset, const char* what) {
  GDALRasterBand& band = *dataset.GetRasterBand(1);
  if (dataset.GetRasterCount() != 1 || band.GetRasterDataType() != GDT_Byte)
    throw InputError(path.string(), fmt::format("is not a {}: need one band of 8 bit", what));
  return band;
}

Raster<std::uint8_t> read_bytes(const fs::path& path, GDALRasterBand& band, const PixelBox& box) {
  Raster<std::uint8_t> raster(box.width, box.height);
  GdalErrors errors;
  if (band.RasterIO(GF_Read, static_cast<int>(box.col), static_cast<int>(box.row), raster.width, raster.height,
                    raster.data.data(), raster.width, raster.height, GDT_Byte, 0, 0, nullptr) != CE_None)
    throw InputError(path.string(), fmt::format("cannot be read to its end ({}); get the file again", errors.text()));
  return raster;
}
}  // namespace

ConfidenceMap read_confidence(const fs::path& path) {
  const DatasetPtr source = open_dataset(path, GDAL_OF_RASTER);
  ConfidenceMap map{.frame = north_up_frame(path, *source)};
  require_complete(path, *source);
  map.crs = crs_of(*source->GetSpatialRef());
  map.confidence = read_bytes(path, byte_band(path, *source, "confidence raster"), pixels_of(map.frame));
  return map;
}

LabelSource open_labels(const fs::path& path, const std::optional<ClassTable>& fallback) {
  struct File {
    DatasetPtr dataset;
    std::mutex mutex;  // a dataset is for one thread at a time
  };
  const auto file = std::make_shared<File>();
  file->dataset = open_dataset(path, GDAL_OF_RASTER);
  GDALDataset& dataset = *file->dataset;
  LabelSource source{.frame = north_up_frame(path, dataset)};
  require_complete(path, dataset);
  source.crs = crs_of(*dataset.GetSpatialRef());
  GDALRasterBand& band = byte_band(path, dataset, "label map");
  const char* stored = dataset.GetMetadataItem("ORTHODRIVE_CLASSES");
  if (stored) {
    source.classes = class_table_from_json(stored);
  } else if (fallback) {
    source.classes = *fallback;
  } else {
    throw InputError(path.string(),
                     "has no class table (metadata item ORTHODRIVE_CLASSES); is it a label map of orthodrive?");
  }
  source.read = [path, file, &band, classes = source.classes](const PixelBox& box) {
    const std::lock_guard lock(file->mutex);
    Raster<std::uint8_t> labels = read_bytes(path, band, box);
    for (const std::uint8_t label : labels.data)
      if (label != label_nodata && label >= classes.classes.size())
        throw InputError(
            path.string(),
            fmt::format("has label {}, but the class table '{}' has only {} classes; give the table of the "
                        "model that made it",
                        label, classes.name, classes.classes.size()));
    return labels;
  };
  return source;
}

LabelMap read_labels(const fs::path& path, const std::optional<ClassTable>& fallback) {
  LabelSource source = open_labels(path, fallback);
  return {source.crs, source.frame, source.read(pixels_of(source.frame)), std::move(source.classes)};
}

}  // namespace orthodrive::io
