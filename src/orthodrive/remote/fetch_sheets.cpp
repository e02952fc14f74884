// SPDX-License-Identifier: Apache-2.0
// Rasters in many files: an index says which show the area; these are downloaded and cut as one raster.
#include <fmt/format.h>

#include <numeric>

#include "orthodrive/core/error.hpp"
#include "orthodrive/io/raster/cut_raster.hpp"
#include "orthodrive/io/raster/sheet_files.hpp"
#include "orthodrive/remote/http/url_template.hpp"
#include "orthodrive/remote/sheet_indices.hpp"

namespace orthodrive::remote {
namespace {
namespace fs = std::filesystem;
constexpr std::int64_t most_sheet_bytes = std::int64_t{16} << 30;

fs::path sheet_store(const FetchSource& source) {
  fs::path folder = source.to;
  folder += ".fetching";
  return folder;
}

/// FILE.fetching while the sheets come. Empty, it goes.
class SheetStore {
 public:
  explicit SheetStore(const FetchSource& source) : folder_(sheet_store(source)) {
    std::error_code failed;
    if (!fs::is_directory(folder_)) fs::remove(folder_, failed);  // tiles, where the table had another kind
    fs::create_directories(folder_, failed);
    if (failed) throw Error(fmt::format("{}: cannot be created ({})", folder_.string(), failed.message()));
  }
  ~SheetStore() {
    std::error_code ignored;
    if (fs::is_empty(folder_, ignored)) fs::remove(folder_, ignored);
  }
  SheetStore(const SheetStore&) = delete;
  SheetStore& operator=(const SheetStore&) = delete;
  [[nodiscard]] const fs::path& folder() const { return folder_; }

 private:
  fs::path folder_;
};

/// Those that the table lists itself: nothing is known of their places.
std::vector<Sheet> listed_sheets(const FetchJob& job) {
  std::vector<Sheet> sheets;
  for (const std::string& url : job.source.urls) {
    const std::string address = job.secrets.resolve(url);
    if (!is_http(address))
      throw InputError(url, "is no address of http or https; files of this machine are kind raster");
    add_sheet(sheets, {.url = address}, job.source.to_text);
  }
  return sheets;
}

std::vector<Sheet> sheets_of(const FetchJob& job, const SheetArea& area, const SheetStore& store) {
  if (!job.source.urls.empty()) return listed_sheets(job);
  switch (job.source.kind) {
    case FetchKind::stac:
      return stac_sheets(job, area);
    case FetchKind::atom:
      return atom_sheets(job, area);
    default:
      return indexed_sheets(job, area, store.folder());
  }
}

SheetChoice choice_of(const FetchJob& job, const SheetStore& store) {
  const SheetArea area(job.site, job.source.to_text);
  SheetChoice choice = choose_sheets(sheets_of(job, area, store), area, job.site.crs, job.source.to_text);
  if (choice.sheets.empty()) {
    const Box2& b = area.box();
    throw InputError(job.secrets.hide(job.source.url),
                     fmt::format("has no sheet of the area, longitude {:.5f}..{:.5f}, latitude {:.5f}..{:.5f}; check "
                                 "url, layer and time, or take another source",
                                 b.min_x, b.max_x, b.min_y, b.max_y));
  }
  return choice;
}

std::string described(const SheetChoice& choice) {
  const std::int64_t bytes = std::accumulate(choice.sheets.begin(), choice.sheets.end(), std::int64_t{0},
                                             [](std::int64_t sum, const Sheet& s) { return sum + s.bytes; });
  std::string text = fmt::format("{} sheet{}", choice.sheets.size(), choice.sheets.size() == 1 ? "" : "s");
  if (bytes > 0) text += ", about " + size_text(static_cast<double>(bytes));
  if (choice.same_place > 0) text += fmt::format("; {} of the same places are left out", choice.same_place);
  if (choice.other_offers > 0) text += fmt::format("; {} in another CRS or format are left out", choice.other_offers);
  return text;
}

/// Downloads a sheet that is not there yet, and looks whether it is one. What is none is asked again the next time.
std::vector<std::string> rasters_of_sheet(const FetchJob& job, const Sheet& sheet, const SheetStore& store,
                                          FetchOutcome& outcome) {
  const std::string shown = job.secrets.hide(sheet.url);
  const fs::path file = store.folder() / store_name(shown, "sheet");
  const HttpFile got = job.client.download(sheet.url, file, job.options.refresh, most_sheet_bytes);
  if (!got.unchanged) ++outcome.requests;
  try {
    return io::rasters_in(file, shown);
  } catch (const InputError&) {
    std::error_code ignored;
    fs::path version = file;
    version += ".json";
    fs::remove(file, ignored), fs::remove(version, ignored);
    throw;
  }
}

/// GDAL's names of all rasters, those of the newest sheet first, and the CRS of each if it names none.
struct FetchedRasters {
  std::vector<std::string> names, crs;
  std::size_t missing = 0;  ///< sheets that the server does not have
};

/// What the table lists itself may be squares of a grid, of which a server lacks those beyond its border. An index says
/// what there is.
FetchedRasters fetched_rasters(const FetchJob& job, const SheetChoice& choice, const SheetStore& store,
                               FetchOutcome& outcome) {
  FetchedRasters all;
  std::string first_missing;
  const std::size_t count = choice.sheets.size();
  for (std::size_t i = 0; i < count; ++i) {
    if (job.monitor)
      job.monitor->progress(static_cast<double>(i) / static_cast<double>(count),
                            fmt::format("sheet {} of {}", i + 1, count));
    try {
      const Sheet& sheet = choice.sheets[i];
      const std::vector<std::string> rasters = rasters_of_sheet(job, sheet, store, outcome);
      all.names.insert(all.names.end(), rasters.begin(), rasters.end());
      all.crs.insert(all.crs.end(), rasters.size(), job.source.crs.empty() ? sheet.crs : job.source.crs);
    } catch (const NotThere& error) {
      if (job.source.urls.empty() || count == 1)
        throw Error(fmt::format("{}: sheet {} of {}: {}", job.source.to_text, i + 1, count, error.what()));
      if (all.missing++ == 0) first_missing = error.what();
    } catch (const Error& error) {
      throw Error(fmt::format("{}: sheet {} of {}: {}", job.source.to_text, i + 1, count, error.what()));
    }
    if (all.names.size() > 2 * most_sheets)
      throw InputError(job.source.to_text,
                       fmt::format("the sheets hold more than {} rasters; take a smaller area", 2 * most_sheets));
  }
  if (all.names.empty())
    throw Error(fmt::format("{}: none of its sheets is there: {}", job.source.to_text, first_missing));
  return all;
}
}  // namespace

void remove_sheet_store(const FetchSource& source) {
  std::error_code ignored;
  fs::remove_all(sheet_store(source), ignored);
}

FetchOutcome fetch_sheets(const FetchJob& job, SourceRecord& record) {
  check_raster_suffix(job.source);
  FetchOutcome outcome;
  const SheetStore store(job.source);
  const SheetChoice choice = choice_of(job, store);
  if (job.options.dry_run) {
    outcome.summary = described(choice);
    return outcome;
  }
  job.info(fmt::format("{}: {}", job.source.to_text, described(choice)));
  const FetchedRasters rasters = fetched_rasters(job, choice, store, outcome);
  job.about_to_place();
  const io::CutRaster cut = io::cut_raster(rasters.names, job.site, job.source.to,
                                           {.gsd_m = job.source.resolution_m,
                                            .vertical_unit = job.source.vertical_unit,
                                            .vertical_datum = job.source.vertical_datum,
                                            .crs_by_default = rasters.crs,
                                            .of_strangers = true,
                                            .attempts = job.options.http.attempts,
                                            .stall_s = job.options.http.stall_s});
  record_raster(job, cut.crs, cut.gsd_m, record, outcome);
  record.sheets = static_cast<std::int64_t>(choice.sheets.size() - rasters.missing);
  outcome.summary = fmt::format("{}{}; {} x {} pixels of {:.2f} m, {}", described(choice),
                                rasters.missing > 0 ? fmt::format(", {} are not on the server", rasters.missing) : "",
                                cut.width, cut.height, cut.gsd_m, size_text(static_cast<double>(record.bytes)));
  return outcome;
}

}  // namespace orthodrive::remote
