// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/io/raster/raster_support.hpp"

#include <fmt/format.h>
#include <gdal_utils.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <type_traits>

#include "orthodrive/core/error.hpp"
#include "orthodrive/geo/ground_scale.hpp"
#include "orthodrive/model/site_area.hpp"

namespace orthodrive::io {
namespace fs = std::filesystem;

namespace {
/// Whether pixels have an area and all corners lie where a CRS, of metres, feet or degrees, can have them.
bool places_pixels(const double (&c)[6], int width, int height) {
  constexpr double smallest = 1e-12, farthest = 1e10;
  const auto can_be = [](double value) { return std::abs(value) < farthest; };  // false for nan
  for (const int col : {0, width})
    for (const int row : {0, height})
      if (!can_be(c[0] + col * c[1] + row * c[2]) || !can_be(c[3] + col * c[4] + row * c[5])) return false;
  return std::min(std::hypot(c[1], c[4]), std::hypot(c[2], c[5])) > smallest &&
         std::abs(c[1] * c[5] - c[2] * c[4]) > smallest * smallest;
}
}  // namespace

Georeference georeference_of(const fs::path& path, GDALDataset& dataset) {
  Georeference result;
  if (dataset.GetGeoTransform(result.c) != CE_None)
    throw InputError(
        path.string(),
        "has no georeferencing; put a world file beside it (.jgw, .tfw) or give its corners: gdal_translate "
        "-a_srs EPSG:n -a_ullr WEST NORTH EAST SOUTH IN OUT.tif");
  if (!places_pixels(result.c, dataset.GetRasterXSize(), dataset.GetRasterYSize()))
    throw InputError(path.string(),
                     "its georeferencing places it nowhere (pixels without a size, or corners without end); give its "
                     "corners: gdal_translate -a_ullr WEST NORTH EAST SOUTH IN OUT.tif");
  const OGRSpatialReference* reference = dataset.GetSpatialRef();
  if (!reference || reference->IsEmpty() || reference->IsLocal())
    throw InputError(path.string(),
                     "has no coordinate reference system; say which: gdal_translate -a_srs EPSG:n IN OUT.tif");
  result.reference = *reference;
  result.reference.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
  return result;
}

namespace {
/// Metres of web mercator are none on the ground: lengths would be those of another scale.
void require_ground_metres(const fs::path& path, const Georeference& g, int width, int height) {
  GroundScale scale;
  try {
    const Vec2 middle{g.c[0] + 0.5 * width * g.c[1] + 0.5 * height * g.c[2],
                      g.c[3] + 0.5 * width * g.c[4] + 0.5 * height * g.c[5]};
    const Crs crs = crs_of(g.reference);
    scale = ground_scale(crs, CoordinateTransform(crs, {"EPSG:4326"}).target_from_source(middle));
  } catch (const Error&) {
    return;  // where the CRS does not reach: the area says so
  }
  if (scale.error() > largest_scale_error)
    throw InputError(path.string(),
                     fmt::format("a metre of its CRS is {:.3g} m on the ground; warp it first: gdalwarp -t_srs "
                                 "EPSG:326xx IN OUT.tif",
                                 scale.least_m));
}
}  // namespace

GridFrame north_up_frame(const fs::path& path, GDALDataset& dataset) {
  const Georeference g = georeference_of(path, dataset);
  if (!g.reference.IsProjected() || std::abs(g.reference.GetLinearUnits() - 1.0) > 1e-9)
    throw InputError(path.string(), "its CRS is not in metres; warp it first: gdalwarp -t_srs EPSG:326xx IN OUT.tif");
  require_ground_metres(path, g, dataset.GetRasterXSize(), dataset.GetRasterYSize());
  constexpr double tolerance = 1e-6;  // of a pixel: world files carry some ten digits
  if (g.c[2] != 0.0 || g.c[4] != 0.0 || g.c[1] <= 0.0 || std::abs(g.c[1] + g.c[5]) > tolerance * g.c[1])
    throw InputError(path.string(),
                     "its pixels are not square or not north-up; warp it first: gdalwarp -tr M M IN OUT.tif");
  return {g.c[0], g.c[3], g.c[1], dataset.GetRasterXSize(), dataset.GetRasterYSize()};
}

PixelSize pixel_size(const Georeference& g, int width, int height) {
  OGRSpatialReference lonlat = spatial_reference({"EPSG:4326"});
  const auto world = [&](double col, double row) {
    return Vec2{g.c[0] + col * g.c[1] + row * g.c[2], g.c[3] + col * g.c[4] + row * g.c[5]};
  };
  const auto transform_to = [&](const OGRSpatialReference& target, Vec2 p) {
    GdalErrors errors;
    const std::unique_ptr<OGRCoordinateTransformation> t(OGRCreateCoordinateTransformation(&g.reference, &target));
    if (!t || !t->Transform(1, &p.x, &p.y)) throw Error("its place on the globe cannot be computed: " + errors.text());
    return p;
  };
  const double col = 0.5 * width, row = 0.5 * height;
  const Vec2 center = transform_to(lonlat, world(col, row));
  const OGRSpatialReference metric = spatial_reference(utm_crs(center.x, center.y));
  const Vec2 origin = transform_to(metric, world(col, row));
  return {distance(origin, transform_to(metric, world(col + 1.0, row))),
          distance(origin, transform_to(metric, world(col, row + 1.0)))};
}

Polygon outline_lonlat(const Georeference& g, int width, int height) {
  constexpr int steps = 16;  // a side: its edges bend in other CRSs
  const OGRSpatialReference lonlat = spatial_reference({"EPSG:4326"});
  GdalErrors errors;
  const std::unique_ptr<OGRCoordinateTransformation> t(OGRCreateCoordinateTransformation(&g.reference, &lonlat));
  const double corners[5][2] = {{0, 0}, {0, 1}, {1, 1}, {1, 0}, {0, 0}};  // counter-clockwise: down the west side first
  Polygon result;
  for (int side = 0; side < 4; ++side)
    for (int i = 0; i < steps; ++i) {
      const double f = static_cast<double>(i) / steps;
      const double col = width * (corners[side][0] + f * (corners[side + 1][0] - corners[side][0]));
      const double row = height * (corners[side][1] + f * (corners[side + 1][1] - corners[side][1]));
      Vec2 p{g.c[0] + col * g.c[1] + row * g.c[2], g.c[3] + col * g.c[4] + row * g.c[5]};
      if (!t || !t->Transform(1, &p.x, &p.y))
        throw Error("its place on the globe cannot be computed: " + errors.text());
      result.outer.push_back(p);
    }
  return result;
}

double rounded_gsd_m(double gsd_m) { return std::max(0.01, std::round(gsd_m * 100.0) / 100.0); }

std::vector<std::string> cubic_resampling(const PixelSize& source, double gsd_m) {
  return {"-r",  "cubic",
          "-wo", fmt::format("XSCALE={}", std::min(1.0, source.along_row_m / gsd_m)),
          "-wo", fmt::format("YSCALE={}", std::min(1.0, source.along_column_m / gsd_m))};
}

DatasetPtr translate_to_vrt(GDALDataset& source, std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), {"-of", "VRT"});
  GdalOptions list(arguments);
  GDALTranslateOptions* options = GDALTranslateOptionsNew(list.get(), nullptr);
  DatasetPtr result(GDALDataset::FromHandle(GDALTranslate("", GDALDataset::ToHandle(&source), options, nullptr)));
  GDALTranslateOptionsFree(options);
  if (!result) throw Error("GDAL cannot make a virtual raster");
  return result;
}

void require_complete(const fs::path& path, GDALDataset& dataset) {
  if (std::string_view(dataset.GetDriverName()) != "GTiff" && std::string_view(dataset.GetDriverName()) != "COG")
    return;
  const std::uintmax_t file_size = fs::file_size(path);
  for (int b = 1; b <= dataset.GetRasterCount(); ++b) {
    GDALRasterBand& band = *dataset.GetRasterBand(b);
    int block_width = 0, block_height = 0;
    band.GetBlockSize(&block_width, &block_height);
    const int columns = (band.GetXSize() + block_width - 1) / block_width,
              rows = (band.GetYSize() + block_height - 1) / block_height;
    for (int row = 0; row < rows; ++row)
      for (int column = 0; column < columns; ++column) {
        const auto item = [&](const char* what) {  // null for blocks that were left out because they are empty
          const char* text = band.GetMetadataItem(fmt::format("BLOCK_{}_{}_{}", what, column, row).c_str(), "TIFF");
          return text ? std::strtoull(text, nullptr, 10) : 0ULL;
        };
        if (item("OFFSET") + item("SIZE") > file_size)
          throw InputError(path.string(),
                           fmt::format("is truncated: it has {} bytes and pixels are said to lie beyond; get the "
                                       "file again",
                                       file_size));
      }
  }
}

DatasetPtr memory_dataset(int width, int height) {
  start_gdal();
  GDALDriver* driver = GetGDALDriverManager()->GetDriverByName("MEM");
  return DatasetPtr(driver->Create("", width, height, 0, GDT_Byte, nullptr));
}

void place(GDALDataset& dataset, const GridFrame& frame, const Crs& crs) {
  const OGRSpatialReference reference = spatial_reference(crs);
  dataset.SetSpatialRef(&reference);
  const Vec2 corner = frame.world_from_pixel(0, 0);
  double c[6] = {corner.x, frame.gsd_m, 0.0, corner.y, 0.0, -frame.gsd_m};
  dataset.SetGeoTransform(c);
}

template <typename T>
void wrap_channels(GDALDataset& dataset, Raster<T>& raster) {
  constexpr GDALDataType type = std::is_same_v<T, float> ? GDT_Float32 : GDT_Byte;
  for (int channel = 0; channel < raster.channels; ++channel) {
    char address[64] = {};
    address[CPLPrintPointer(address, raster.data.data() + channel, sizeof address - 1)] = '\0';
    const std::size_t pixel_bytes = sizeof(T) * static_cast<std::size_t>(raster.channels);
    GdalOptions options({fmt::format("DATAPOINTER={}", address), fmt::format("PIXELOFFSET={}", pixel_bytes),
                         fmt::format("LINEOFFSET={}", pixel_bytes * static_cast<std::size_t>(raster.width))});
    if (dataset.AddBand(type, options.get()) != CE_None) throw Error("a raster cannot be handed to GDAL");
  }
}
template void wrap_channels(GDALDataset&, Raster<std::uint8_t>&);
template void wrap_channels(GDALDataset&, Raster<float>&);

}  // namespace orthodrive::io
