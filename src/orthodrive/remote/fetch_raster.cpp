// SPDX-License-Identifier: Apache-2.0
// A raster, or several, cut by the area: GDAL reads what is needed of it.
#include <fmt/format.h>

#include "orthodrive/core/error.hpp"
#include "orthodrive/io/raster/cut_raster.hpp"
#include "orthodrive/remote/fetch_kinds.hpp"
#include "orthodrive/remote/http/url_template.hpp"

namespace orthodrive::remote {
namespace {
namespace fs = std::filesystem;

/// Paths are relative to the site file; what has a colon or begins with / is GDAL's.
std::string located(const FetchJob& job, const std::string& name) {
  std::string resolved = job.secrets.resolve(name);
  if (is_http(resolved) || resolved.find(':') != std::string::npos || resolved.starts_with('/')) return resolved;
  return (job.source.folder / resolved).lexically_normal().string();
}
}  // namespace

void check_raster_suffix(const FetchSource& source) {
  const std::string suffix = source.to.extension().string();
  if (suffix != ".tif" && suffix != ".tiff")
    throw OptionError(fmt::format("{}: a raster becomes a GeoTIFF, name it .tif", source.to_text));
}

void record_raster(const FetchJob& job, const Crs& crs, double gsd_m, SourceRecord& record, FetchOutcome& outcome) {
  record.crs = crs.definition.size() < 100 ? crs.definition : "", record.resolution_m = gsd_m;
  record.bytes = outcome.bytes = static_cast<std::int64_t>(fs::file_size(job.source.to));
}

FetchOutcome fetch_raster(const FetchJob& job, SourceRecord& record) {
  check_raster_suffix(job.source);
  std::vector<std::string> names;
  for (const std::string& name : job.source.urls.empty() ? std::vector<std::string>{job.source.url} : job.source.urls)
    names.push_back(located(job, name));
  FetchOutcome outcome;
  if (job.options.dry_run) {
    outcome.summary = fmt::format("the part of {} raster{} around the area", names.size(), names.size() > 1 ? "s" : "");
    return outcome;
  }
  job.info(fmt::format("{}: reads the part of the area of {} raster{}", job.source.to_text, names.size(),
                       names.size() > 1 ? "s" : ""));
  job.about_to_place();
  const io::CutRaster cut = io::cut_raster(names, job.site, job.source.to,
                                           {.gsd_m = job.source.resolution_m,
                                            .vertical_unit = job.source.vertical_unit,
                                            .vertical_datum = job.source.vertical_datum,
                                            .crs_by_default = std::vector(names.size(), job.source.crs),
                                            .attempts = job.options.http.attempts,
                                            .stall_s = job.options.http.stall_s});
  record_raster(job, cut.crs, cut.gsd_m, record, outcome);
  outcome.summary = fmt::format("{} x {} pixels of {:.2f} m, {}", cut.width, cut.height, cut.gsd_m,
                                size_text(static_cast<double>(record.bytes)));
  return outcome;
}

}  // namespace orthodrive::remote
