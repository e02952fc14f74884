// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/io/support/gdal_support.hpp"

#include <cpl_conv.h>
#include <cpl_error.h>
#include <cpl_vsi.h>
#include <fmt/format.h>

#include <algorithm>
#include <mutex>
#include <set>
#include <string_view>
#include <vector>

#include "orthodrive/core/error.hpp"
#include "orthodrive/core/printable.hpp"

namespace orthodrive::io {
namespace fs = std::filesystem;

namespace {
/// Takes all drivers away but those of formats that photos, terrain and maps come in. GDAL asks every driver about
/// every file, and the rare ones believe what a header says: that of PROJ's grids allocates 900 MB for a file of 200
/// bytes, that of netCDF 3 GB for one of 14. Others turn a small local file into requests to a server.
void keep_formats_of_geodata() {
  static const std::set<std::string_view> kept{
      // photos and pictures
      "GTiff", "COG", "JPEG", "PNG", "PNM", "WEBP", "BMP", "GIF", "JP2OpenJPEG", "JP2KAK", "JP2ECW", "JP2MrSID", "ECW",
      "MrSID", "HFA", "ENVI", "EHdr", "ERS", "MBTiles", "GPKG", "VRT", "MEM",
      // terrain
      "AAIGrid", "AIG", "GRASSASCIIGrid", "SRTMHGT", "DTED", "USGSDEM", "XYZ", "GSAG", "GSBG", "GS7BG", "SAGA",
      // maps
      "ESRI Shapefile", "GeoJSON", "GeoJSONSeq", "FlatGeobuf", "GML", "KML", "LIBKML", "GPX", "OSM", "CSV", "SQLite",
      "MapInfo File", "OpenFileGDB", "OGR_VRT", "Memory"};
  GDALDriverManager& manager = *GetGDALDriverManager();
  std::vector<GDALDriver*> others;
  for (int i = 0; i < manager.GetDriverCount(); ++i)
    if (GDALDriver* driver = manager.GetDriver(i); !kept.contains(driver->GetDescription())) others.push_back(driver);
  for (GDALDriver* driver : others) {
    manager.DeregisterDriver(driver);
    delete driver;  // as GDAL does for GDAL_SKIP
  }
}
}  // namespace

void start_gdal() {
  static std::once_flag once;
  std::call_once(once, [] {
    CPLSetErrorHandler(CPLQuietErrorHandler);  // GDAL's own threads; ours collect with GdalErrors
    GDALAllRegister();
    keep_formats_of_geodata();
    // GDAL 3.6 puts the list of these drivers' options together at the first look at it, without a lock: two threads
    // that write their first images at once would read half a list.
    for (const char* driver : {"JPEG", "COG"})
      if (GDALDriver* found = GetGDALDriverManager()->GetDriverByName(driver))
        found->GetMetadataItem(GDAL_DMD_CREATIONOPTIONLIST);
    // The default is 5 % of the machine's memory, on top of what the stages hold.
    if (!CPLGetConfigOption("GDAL_CACHEMAX", nullptr)) GDALSetCacheMax64(GIntBig{128} << 20);
    // A truncated JPEG is a warning to libjpeg and grey pixels to its reader.
    CPLSetConfigOption("GDAL_ERROR_ON_LIBJPEG_WARNING", "TRUE");
    // GeoPackage stores the time of the last change: same input, same bytes.
    if (!CPLGetConfigOption("OGR_CURRENT_DATE", nullptr))
      CPLSetConfigOption("OGR_CURRENT_DATE", "2000-01-01T00:00:00.000Z");
  });
}

void enlarge_block_cache(std::int64_t bytes) {
  constexpr std::int64_t most = std::int64_t{512} << 20;
  start_gdal();
  if (CPLGetConfigOption("GDAL_CACHEMAX", nullptr)) return;
  if (GDALGetCacheMax64() < std::min(bytes, most)) GDALSetCacheMax64(std::min(bytes, most));
}

namespace {
void CPL_STDCALL collect(CPLErr severity, CPLErrorNum, const char* message) {
  if (severity >= CE_Failure) static_cast<GdalErrors*>(CPLGetErrorHandlerUserData())->add(message);
}
}  // namespace

GdalErrors::GdalErrors() {
  start_gdal();
  CPLErrorReset();
  CPLPushErrorHandlerEx(collect, this);
}
GdalErrors::~GdalErrors() { CPLPopErrorHandler(); }
void GdalErrors::add(const char* message) {
  if (first_.empty()) first_ = printable(message);  // GDAL quotes the file
}

ScopedGdalOption::ScopedGdalOption(const char* key, const char* value) : key_(key) {
  const char* before = CPLGetThreadLocalConfigOption(key, nullptr);
  had_before_ = before != nullptr;
  if (before) before_ = before;
  CPLSetThreadLocalConfigOption(key, value);
}
ScopedGdalOption::~ScopedGdalOption() { CPLSetThreadLocalConfigOption(key_, had_before_ ? before_.c_str() : nullptr); }

GdalOptions::GdalOptions(const std::vector<std::string>& options) : texts_(options) {
  for (std::string& text : texts_) pointers_.push_back(text.data());
  pointers_.push_back(nullptr);
}

/// A file may say that it is one block of a thousand bands: reading a pixel of it would take gigabytes.
void require_plausible_blocks(const fs::path& path, GDALDataset& raster) {
  constexpr double always = double{1 << 28}, most_per_byte = 1000.0;
  const char* interleave = raster.GetMetadataItem("INTERLEAVE", "IMAGE_STRUCTURE");
  const bool together = interleave && std::string_view(interleave) == "PIXEL";
  double bytes = 0.0;
  for (int b = 1; b <= raster.GetRasterCount(); ++b) {
    GDALRasterBand& band = *raster.GetRasterBand(b);
    int width = 0, height = 0;
    band.GetBlockSize(&width, &height);
    const double of_band = static_cast<double>(width) * height * GDALGetDataTypeSizeBytes(band.GetRasterDataType());
    bytes = together ? bytes + of_band : std::max(bytes, of_band);
  }
  VSIStatBufL about{};  // some formats are folders; in an archive it is the size of what is unpacked
  const bool is_file = VSIStatL(path.c_str(), &about) == 0 && VSI_ISREG(about.st_mode);
  if (bytes > std::max(always, is_file ? most_per_byte * static_cast<double>(about.st_size) : 0.0))
    throw InputError(path.string(),
                     fmt::format("says that {} bands lie in blocks of {:.0f} MB, more than its bytes can hold; get the "
                                 "file again, or make smaller ones: gdal_translate -co TILED=YES IN OUT.tif",
                                 raster.GetRasterCount(), bytes / 1e6));
}

const std::vector<std::string>& raster_drivers_for_strangers() {
  static const std::vector<std::string> names = [] {
    start_gdal();
    static const std::set<std::string_view> leading_on{"VRT", "MRF"};
    std::vector<std::string> found;
    GDALDriverManager& drivers = *GetGDALDriverManager();
    for (int i = 0; i < drivers.GetDriverCount(); ++i) {
      GDALDriver& driver = *drivers.GetDriver(i);
      if (driver.GetMetadataItem(GDAL_DCAP_RASTER) && !leading_on.contains(driver.GetDescription()))
        found.emplace_back(driver.GetDescription());
    }
    return found;
  }();
  return names;
}

DatasetPtr open_dataset(const fs::path& path, unsigned kind) {
  if (!fs::exists(path)) throw InputError(path.string(), "no such file");
  GdalErrors errors;
  DatasetPtr dataset(GDALDataset::Open(path.c_str(), kind | GDAL_OF_READONLY));
  if (!dataset)
    throw InputError(
        path.string(),
        fmt::format("not a {} of a format that is read here, or truncated{}; get the file again or convert it with {}",
                    kind & GDAL_OF_RASTER ? "raster" : "vector file", errors.any() ? " (" + errors.text() + ")" : "",
                    kind & GDAL_OF_RASTER ? "gdal_translate" : "ogr2ogr"));
  require_plausible_blocks(path, *dataset);
  return dataset;
}

OGRSpatialReference spatial_reference(const Crs& crs) {
  GdalErrors errors;
  OGRSpatialReference reference;
  if (reference.SetFromUserInput(crs.definition.c_str()) != OGRERR_NONE)
    throw Error(fmt::format("CRS '{}' is unknown{}", crs.definition, errors.any() ? " (" + errors.text() + ")" : ""));
  reference.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
  return reference;
}

Crs crs_of(const OGRSpatialReference& reference) {
  const char* authority = reference.GetAuthorityName(nullptr);
  const char* code = reference.GetAuthorityCode(nullptr);
  if (authority && code && std::string_view(authority) == "EPSG") return {fmt::format("EPSG:{}", code)};
  const char* const options[] = {"FORMAT=WKT2_2019", nullptr};
  char* wkt = nullptr;
  reference.exportToWkt(&wkt, options);
  Crs crs{wkt ? wkt : ""};
  CPLFree(wkt);
  return crs;
}

void remove_leftovers(const fs::path& unfinished) {
  for (const char* suffix :
       {".ovr.tmp", ".msk.tmp", ".msk.ovr.tmp", ".ovr", ".msk", "-journal", "-wal", "-shm", ".aux.xml"}) {
    fs::path leftover = unfinished;
    leftover += suffix;
    std::error_code ignored;
    fs::remove(leftover, ignored);
  }
}

std::string describe_lonlat(const Box2& box) {
  return fmt::format("longitude {:.5f}..{:.5f}, latitude {:.5f}..{:.5f}", box.min_x, box.max_x, box.min_y, box.max_y);
}

Box2 lonlat_bounds(const Ring& ring, const Crs& crs) {
  const CoordinateTransform lonlat_from_site(crs, Crs{"EPSG:4326"});
  Ring lonlat;
  for (const Vec2 p : ring) lonlat.push_back(lonlat_from_site.target_from_source(p));
  return bounds_of(lonlat);
}

}  // namespace orthodrive::io
