// SPDX-License-Identifier: Apache-2.0
// Tiles of a service into an MBTiles file, or a GeoTIFF where the service's grid is another one.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <set>

#include "orthodrive/core/error.hpp"
#include "orthodrive/core/printable.hpp"
#include "orthodrive/io/raster/tile_image.hpp"
#include "orthodrive/remote/fetch_kinds.hpp"
#include "orthodrive/remote/tiles/tile_plan.hpp"
#include "orthodrive/remote/tiles/tile_store.hpp"

namespace orthodrive::remote {
namespace {
namespace fs = std::filesystem;
using SteadyClock = std::chrono::steady_clock;

std::string wrong_picture(const HttpReply& reply, const TileMatrix& matrix) {
  if (io::image_format(reply.body).empty()) {
    const std::string type = reply.content_type.empty() ? "something" : reply.content_type;
    return fmt::format("the server answers {} that is no JPEG, PNG or WebP", type);
  }
  try {
    const Raster<std::uint8_t> image = io::decode_tile(reply.body);
    if (image.width != matrix.tile_width || image.height != matrix.tile_height)
      return fmt::format("the tile has {} x {} pixels instead of {} x {}", image.width, image.height, matrix.tile_width,
                         matrix.tile_height);
  } catch (const InputError& error) {
    return error.what();
  }
  return {};
}

/// One run over the tiles that are not in the store.
class TileRun {
 public:
  TileRun(const FetchJob& job, const TilePlan& plan, TileStore& store, std::set<TileAddress> stale)
      : job_(job), plan_(plan), store_(store), stale_(std::move(stale)) {
    for (std::size_t i = 0; i < plan_.tiles.size(); ++i)
      if (stale_.contains(plan_.tiles[i]) || !store_.has(plan_.tiles[i])) wanted_.push_back(i);
  }
  [[nodiscard]] std::size_t wanted() const { return wanted_.size(); }

  void run(FetchOutcome& outcome) {
    HttpWork work;
    work.next = [this] { return next(); };
    work.check = [this](const HttpReply& reply) { return wrong_picture(reply, plan_.matrix); };
    work.take = [this, &outcome](HttpReply&& reply) {
      if (reply.status == 304) ++outcome.unchanged;
      take(std::move(reply));
    };
    work.fail = [this](HttpFailure&& failure) {
      ++failed_, ++done_;
      if (first_failure_.empty()) first_failure_ = std::move(failure.what);
    };
    work.idle = [this] { idle(); };
    const HttpCounts counts = job_.client.run(work);
    store_.keep(true);
    outcome.requests = counts.requests, outcome.retries = counts.retries, outcome.bytes = counts.bytes;
    if (failed_ > 0)
      throw Error(fmt::format("{}: {} of {} tiles did not come ({}); those that came are kept: run it again to go on",
                              job_.source.to_text, failed_, plan_.tiles.size(), first_failure_));
  }

 private:
  std::optional<HttpRequest> next() {
    if (next_ == wanted_.size()) return std::nullopt;
    const std::size_t id = wanted_[next_++];
    const TileAddress tile = plan_.tiles[id];
    HttpRequest request{.id = id, .url = plan_.url_of(tile)};
    if (stale_.contains(tile))
      if (const auto old = store_.get(tile); old && !old->missing)
        request.etag = old->etag, request.last_modified = old->last_modified;
    return request;
  }
  void take(HttpReply&& reply) {
    ++done_;
    if (reply.status == 304) return;
    const bool missing = reply.status == 404;
    store_.put(plan_.tiles[reply.id],
               {missing, missing ? std::string() : std::move(reply.body), reply.etag, reply.last_modified});
  }
  void idle() {
    store_.keep();
    const auto now = SteadyClock::now();
    if (!job_.monitor || now - last_said_ < std::chrono::milliseconds(200)) return;
    last_said_ = now;
    const double seconds = std::chrono::duration<double>(now - begun_).count(),
                 rate = static_cast<double>(done_) / std::max(seconds, 1e-3);
    const double left_s = rate > 0.0 ? static_cast<double>(wanted_.size() - done_) / rate : 0.0;
    job_.monitor->progress(static_cast<double>(done_) / static_cast<double>(wanted_.size()),
                           fmt::format("{} {:.0f}/s {:.0f} s left", job_.source.to.filename().string(), rate, left_s));
  }

  const FetchJob& job_;
  const TilePlan& plan_;
  TileStore& store_;
  std::set<TileAddress> stale_;      ///< are in the store, and may be old
  std::vector<std::size_t> wanted_;  ///< indices of the plan's tiles
  std::size_t next_ = 0, done_ = 0, failed_ = 0;
  std::string first_failure_;
  SteadyClock::time_point begun_ = SteadyClock::now(), last_said_ = begun_;
};

fs::path store_file(const FetchSource& source) {
  fs::path file = source.to;
  file += ".fetching";
  return file;
}

/// Takes over what an earlier fetch of the same service and level has; returns what may be old.
std::set<TileAddress> take_over(const FetchJob& job, const TilePlan& plan, TileStore& store) {
  std::set<TileAddress> stale;
  if (!plan.zoom || job.source.to.extension() != ".mbtiles") return stale;
  const auto wanted = [&](TileAddress t) {  // by row, then column
    return std::binary_search(plan.tiles.begin(), plan.tiles.end(), t, [](TileAddress a, TileAddress b) {
      return std::pair(a.row, a.column) < std::pair(b.row, b.column);
    });
  };
  try {
    visit_mbtiles(job.source.to, plan.identity, *plan.zoom, [&](TileAddress tile, const StoredTile& stored) {
      if (!wanted(tile)) return;
      if (!store.has(tile)) store.put(tile, stored);
      if (job.options.refresh) stale.insert(tile);
    });
  } catch (const InputError&) {  // NOLINT(bugprone-empty-catch): it is damaged, so all is asked again
  }
  store.keep(true);
  return stale;
}

struct TileRange {
  TileAddress first, last;
};
TileRange range_of(const std::vector<TileAddress>& tiles) {
  TileRange range{tiles.front(), tiles.front()};
  for (const TileAddress& t : tiles) {
    range.first = {std::min(range.first.column, t.column), std::min(range.first.row, t.row)};
    range.last = {std::max(range.last.column, t.column), std::max(range.last.row, t.row)};
  }
  return range;
}

Box2 extent_of(const TilePlan& plan) {
  const TileRange range = range_of(plan.tiles);
  const Box2 first = bounds_of_tile(plan.matrix, range.first), last = bounds_of_tile(plan.matrix, range.last);
  return {first.min_x, last.min_y, last.max_x, first.max_y};
}

std::map<std::string, std::string> mbtiles_metadata(const FetchJob& job, const TilePlan& plan, int level,
                                                    const std::string& format) {
  // Of whole tiles: GDAL cuts the picture at these bounds, and resampling looks beyond the area.
  const Box2 extent = extent_of(plan);
  const CoordinateTransform lonlat_from_mercator(plan.crs, Crs{"EPSG:4326"});
  const Vec2 south_west = lonlat_from_mercator.target_from_source({extent.min_x, extent.min_y});
  const Vec2 north_east = lonlat_from_mercator.target_from_source({extent.max_x, extent.max_y});
  const std::string zoom = std::to_string(level);
  std::map<std::string, std::string> metadata{
      {"name", job.source.to.stem().string()},
      {"type", "baselayer"},
      {"version", "1"},
      {"format", format},
      {"minzoom", zoom},
      {"maxzoom", zoom},
      {"bounds", fmt::format("{:.7f},{:.7f},{:.7f},{:.7f}", south_west.x, south_west.y, north_east.x, north_east.y)},
      {"plan", plan.identity}};
  if (!job.source.attribution.empty()) metadata["attribution"] = job.source.attribution;
  if (!job.source.licence.empty()) metadata["description"] = "Licence: " + job.source.licence;
  return metadata;
}

void write_mosaic(const FetchJob& job, const TilePlan& plan, const TileStore& store) {
  const auto [first, last] = range_of(plan.tiles);
  const TileAddress corner_tile = first;
  const Box2 corner = bounds_of_tile(plan.matrix, first);
  const io::TileMosaic mosaic{plan.crs,
                              corner.min_x,
                              corner.max_y,
                              plan.matrix.resolution,
                              plan.matrix.tile_width,
                              plan.matrix.tile_height,
                              static_cast<int>(last.column - first.column + 1),
                              static_cast<int>(last.row - first.row + 1)};
  io::write_tile_mosaic(
      job.source.to, mosaic,
      [&](int column, int row) -> std::optional<Raster<std::uint8_t>> {
        const auto stored = store.get({corner_tile.column + column, corner_tile.row + row});
        if (!stored || stored->missing) return std::nullopt;
        return io::decode_tile(stored->bytes);
      },
      [&](double share) {
        if (job.monitor) job.monitor->progress(share, "mosaic");
      });
}

void check_tile_suffix(const FetchSource& source, const TilePlan& plan) {
  const std::string suffix = source.to.extension().string();
  if (suffix == ".mbtiles" && !plan.zoom)
    throw OptionError(
        fmt::format("{}: the tiles are in {} (matrix set {}), MBTiles holds web mercator only; name it .tif",
                    source.to_text, plan.crs.definition, plan.matrix_set));
  if (suffix != ".mbtiles" && suffix != ".tif" && suffix != ".tiff")
    throw OptionError(fmt::format("{}: tiles become .mbtiles or .tif, name it so", source.to_text));
}

/// Counts the missing; the format of the first picture.
std::string look_through(const TilePlan& plan, const TileStore& store, FetchOutcome& outcome, SourceRecord& record) {
  std::string format;
  for (const TileAddress& tile : plan.tiles) {
    const auto stored = store.get(tile);
    if (!stored || stored->missing) {
      ++outcome.missing;
      continue;
    }
    record.bytes += static_cast<std::int64_t>(stored->bytes.size());
    if (format.empty()) format = io::image_format(stored->bytes);
  }
  return format;
}
}  // namespace

void remove_tile_store(const FetchSource& source) {
  for (const char* suffix : {"", "-wal", "-shm", "-journal"}) {
    fs::path file = store_file(source);
    file += suffix;
    std::error_code ignored;
    fs::remove(file, ignored);
  }
}

FetchOutcome fetch_tiles(const FetchJob& job, SourceRecord& record) {
  const TilePlan plan = plan_tiles(job.source, job.site, job.client, job.secrets);
  check_tile_suffix(job.source, plan);
  FetchOutcome outcome{.tiles = static_cast<std::int64_t>(plan.tiles.size())};
  const std::string level = plan.zoom ? fmt::format("zoom {}", *plan.zoom)
                                      : fmt::format("level {} of {}", plan.matrix.identifier, plan.matrix_set);
  const std::string size = fmt::format("{} tiles at {} ({:.2f} m), about {}", outcome.tiles, level, plan.gsd_m,
                                       size_text(plan.estimated_mb * 1e6));
  if (job.options.dry_run) {
    outcome.summary = size;
    return outcome;
  }
  job.info(fmt::format("{}: {}", job.source.to_text, size));
  std::string format;
  {
    TileStore store(store_file(job.source), plan.identity);
    TileRun run(job, plan, store, take_over(job, plan, store));
    const auto begun = SteadyClock::now();
    if (run.wanted() > 0) run.run(outcome);
    const double seconds = std::chrono::duration<double>(SteadyClock::now() - begun).count();
    format = look_through(plan, store, outcome, record);
    if (!format.empty()) {
      job.about_to_place();
      if (plan.zoom && job.source.to.extension() == ".mbtiles")
        write_mbtiles(job.source.to, store, *plan.zoom, plan.tiles, mbtiles_metadata(job, plan, *plan.zoom, format));
      else
        write_mosaic(job, plan, store);
    }
    outcome.summary = fmt::format("{} tiles, {} asked in {:.1f} s ({:.0f}/s), {}", outcome.tiles, run.wanted(), seconds,
                                  static_cast<double>(run.wanted()) / std::max(seconds, 1e-3),
                                  size_text(static_cast<double>(record.bytes)));
  }
  if (format.empty()) {
    remove_tile_store(job.source);
    throw InputError(
        job.source.to_text,
        fmt::format("the server has none of the {} tiles at {}; check url, layer and zoom", outcome.tiles, level));
  }
  if (outcome.retries > 0) outcome.summary += fmt::format(", {} asked again", outcome.retries);
  if (outcome.unchanged > 0) outcome.summary += fmt::format(", {} unchanged", outcome.unchanged);
  if (outcome.missing > 0)
    outcome.summary += fmt::format("; {} are not on the server, there the photo has a hole", outcome.missing);
  record.crs = plan.crs.definition, record.resolution_m = plan.gsd_m, record.tiles = outcome.tiles,
  record.missing = outcome.missing;
  record.zoom = plan.zoom ? std::to_string(*plan.zoom) : plan.matrix.identifier;
  return outcome;
}

}  // namespace orthodrive::remote
