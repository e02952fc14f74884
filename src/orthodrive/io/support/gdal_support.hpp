// SPDX-License-Identifier: Apache-2.0
#pragma once
// What every file of io that touches GDAL shares. Internal to io: not for other folders.

#include <gdal_priv.h>
#include <ogr_spatialref.h>

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "orthodrive/geo/crs.hpp"
#include "orthodrive/geo/polygon.hpp"

namespace orthodrive::io {

/// Registers the drivers once and keeps GDAL quiet and its block cache small. Call before anything else of GDAL.
void start_gdal();

/// To so many bytes, at most 512 MB, unless it is larger already or the user set GDAL_CACHEMAX.
void enlarge_block_cache(std::int64_t bytes);

/// Collects GDAL's failures of this thread while it lives, instead of letting them reach stderr.
class GdalErrors {
 public:
  GdalErrors();
  ~GdalErrors();
  GdalErrors(const GdalErrors&) = delete;
  GdalErrors& operator=(const GdalErrors&) = delete;
  [[nodiscard]] bool any() const { return !first_.empty(); }
  /// The first failure: later ones are consequences of it.
  [[nodiscard]] const std::string& text() const { return first_; }
  void add(const char* message);

 private:
  std::string first_;
};

/// A configuration option of GDAL for this thread while it lives.
class ScopedGdalOption {
 public:
  ScopedGdalOption(const char* key, const char* value);
  ~ScopedGdalOption();
  ScopedGdalOption(const ScopedGdalOption&) = delete;
  ScopedGdalOption& operator=(const ScopedGdalOption&) = delete;

 private:
  const char* key_;
  std::string before_;
  bool had_before_;
};

struct CloseDataset {
  void operator()(GDALDataset* dataset) const { GDALClose(dataset); }
};
using DatasetPtr = std::unique_ptr<GDALDataset, CloseDataset>;

/// A null-terminated list of options for GDAL's C functions.
class GdalOptions {
 public:
  explicit GdalOptions(const std::vector<std::string>& options);
  [[nodiscard]] char** get() { return pointers_.data(); }

 private:
  std::vector<std::string> texts_;
  std::vector<char*> pointers_;
};

/// Throws InputError when the file is missing or no driver of that kind (GDAL_OF_RASTER or GDAL_OF_VECTOR) reads it.
[[nodiscard]] DatasetPtr open_dataset(const std::filesystem::path& path, unsigned kind);

/// Throws InputError when the blocks of a raster are larger than its file can hold; the path is GDAL's.
void require_plausible_blocks(const std::filesystem::path& path, GDALDataset& raster);
/// The drivers of rasters but those whose files name other files or servers.
[[nodiscard]] const std::vector<std::string>& raster_drivers_for_strangers();

/// With x = longitude or easting whatever the authority says.
[[nodiscard]] OGRSpatialReference spatial_reference(const Crs& crs);
/// "EPSG:n" where GDAL knows the code, else WKT2.
[[nodiscard]] Crs crs_of(const OGRSpatialReference& reference);

/// Deletes what GDAL may leave beside an unfinished file: NAME.ovr.tmp, NAME.msk.tmp, NAME-journal, NAME.aux.xml.
void remove_leftovers(const std::filesystem::path& unfinished);

/// "longitude 12.00800..12.04400, latitude 57.64950..57.66250" for messages.
[[nodiscard]] std::string describe_lonlat(const Box2& box);
[[nodiscard]] Box2 lonlat_bounds(const Ring& ring, const Crs& crs);

}  // namespace orthodrive::io
