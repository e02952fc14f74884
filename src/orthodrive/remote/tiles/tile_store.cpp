// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/remote/tiles/tile_store.hpp"

#include <fmt/format.h>

#include <chrono>

#include "orthodrive/core/atomic_file.hpp"
#include "orthodrive/core/error.hpp"
#include "orthodrive/remote/tiles/sqlite.hpp"

namespace orthodrive::remote {
namespace {
namespace fs = std::filesystem;
using StoreClock = std::chrono::steady_clock;

StoredTile tile_of(const Statement& row, int first) {
  return {row.integer(first) != 0, row.text(first + 1), row.text(first + 2), row.text(first + 3)};
}

std::string plan_of(const Database& db) {
  Statement ask = db.prepare("SELECT value FROM metadata WHERE name = 'plan'");
  return ask.step() ? ask.text(0) : std::string();
}
/// With its tables; emptied where it holds another plan.
Database open_store(const fs::path& file, const std::string& plan) {
  Database db(file, Database::Mode::write);
  // A write-ahead log: a killed process leaves whole batches, and one that is forced to the disk now and then.
  db.run(
      "PRAGMA locking_mode = EXCLUSIVE; PRAGMA journal_mode = WAL; PRAGMA synchronous = NORMAL; PRAGMA cache_size = "
      "-20000;"
      "CREATE TABLE IF NOT EXISTS metadata (name TEXT PRIMARY KEY, value TEXT);"
      "CREATE TABLE IF NOT EXISTS fetched (row INTEGER, col INTEGER, missing INTEGER, data BLOB, etag TEXT, modified "
      "TEXT,"
      "  PRIMARY KEY (row, col));");
  if (plan_of(db) != plan) {
    db.run("DELETE FROM fetched; DELETE FROM metadata;");
    db.prepare("INSERT INTO metadata VALUES ('plan', ?)").bind_text(1, plan).run();
  }
  return db;
}

}  // namespace

struct TileStore::State {
  State(const fs::path& file, const std::string& plan)
      : db(open_store(file, plan)),
        has(db.prepare("SELECT 1 FROM fetched WHERE row = ? AND col = ?")),
        get(db.prepare("SELECT missing, data, etag, modified FROM fetched WHERE row = ? AND col = ?")),
        put(db.prepare("INSERT OR REPLACE INTO fetched VALUES (?, ?, ?, ?, ?, ?)")) {}
  Database db;
  Statement has, get, put;
  bool in_batch = false;
  StoreClock::time_point begun;
};

TileStore::TileStore(const fs::path& file, const std::string& plan) {
  if (file.has_parent_path()) {
    std::error_code failed;
    fs::create_directories(file.parent_path(), failed);
    if (failed) throw Error(fmt::format("{}: cannot be created ({})", file.parent_path().string(), failed.message()));
  }
  state_ = std::make_unique<State>(file, plan);
}

TileStore::~TileStore() {
  try {
    keep(true);
  } catch (const std::exception&) {  // NOLINT(bugprone-empty-catch): the tiles of the last second are asked again
  }
}

bool TileStore::has(TileAddress tile) const {
  Statement& ask = state_->has;
  const bool found = ask.bind(1, tile.row).bind(2, tile.column).step();
  ask.reset();
  return found;
}

std::optional<StoredTile> TileStore::get(TileAddress tile) const {
  Statement& ask = state_->get;
  std::optional<StoredTile> found;
  if (ask.bind(1, tile.row).bind(2, tile.column).step()) found = tile_of(ask, 0);
  ask.reset();
  return found;
}

void TileStore::put(TileAddress tile, const StoredTile& stored) {
  if (!state_->in_batch) {
    state_->db.run("BEGIN");
    state_->in_batch = true, state_->begun = StoreClock::now();
  }
  state_->put.bind(1, tile.row).bind(2, tile.column).bind(3, stored.missing ? 1 : 0);
  state_->put.bind_blob(4, stored.bytes).bind_text(5, stored.etag).bind_text(6, stored.last_modified).run();
}

void TileStore::keep(bool now) {
  if (!state_->in_batch || (!now && StoreClock::now() - state_->begun < std::chrono::seconds(1))) return;
  state_->in_batch = false;
  state_->db.run("COMMIT");
}

void write_mbtiles(const fs::path& target, const TileStore& store, int zoom, const std::vector<TileAddress>& tiles,
                   const std::map<std::string, std::string>& metadata) {
  AtomicFile out(target);
  {
    const Database db(out.path(), Database::Mode::write);
    db.run(
        "PRAGMA application_id = 0x4d504258; PRAGMA journal_mode = OFF; PRAGMA synchronous = OFF;"
        "CREATE TABLE metadata (name TEXT, value TEXT);"
        "CREATE TABLE tiles (zoom_level INTEGER, tile_column INTEGER, tile_row INTEGER, tile_data BLOB);"
        "CREATE TABLE validators (tile_column INTEGER, tile_row INTEGER, etag TEXT, last_modified TEXT);"
        "BEGIN;");
    Statement add_metadata = db.prepare("INSERT INTO metadata VALUES (?, ?)");
    for (const auto& [name, value] : metadata) add_metadata.bind_text(1, name).bind_text(2, value).run();
    Statement add_tile = db.prepare("INSERT INTO tiles VALUES (?, ?, ?, ?)");
    Statement add_validator = db.prepare("INSERT INTO validators VALUES (?, ?, ?, ?)");
    const std::int64_t last_row = (std::int64_t{1} << zoom) - 1;  // MBTiles counts rows from the south
    for (const TileAddress tile : tiles) {
      const std::optional<StoredTile> stored = store.get(tile);
      if (!stored || stored->missing) continue;
      add_tile.bind(1, zoom).bind(2, tile.column).bind(3, last_row - tile.row).bind_blob(4, stored->bytes).run();
      if (stored->etag.empty() && stored->last_modified.empty()) continue;
      add_validator.bind(1, tile.column).bind(2, last_row - tile.row);
      add_validator.bind_text(3, stored->etag).bind_text(4, stored->last_modified).run();
    }
    db.run(
        "CREATE UNIQUE INDEX tile_index ON tiles (zoom_level, tile_column, tile_row);"
        "CREATE UNIQUE INDEX validator_index ON validators (tile_column, tile_row); COMMIT;");
  }
  out.commit();
}

bool visit_mbtiles(const fs::path& file, const std::string& plan, int zoom,
                   const std::function<void(TileAddress, const StoredTile&)>& visit) {
  if (!fs::exists(file)) return false;
  const Database db(file, Database::Mode::read);
  if (plan_of(db) != plan) return false;
  const std::int64_t last_row = (std::int64_t{1} << zoom) - 1;
  Statement all = db.prepare(
      "SELECT tile_column, tile_row, 0, tile_data, etag, last_modified FROM tiles LEFT JOIN validators USING "
      "(tile_column, "
      "tile_row) WHERE zoom_level = ?");
  all.bind(1, zoom);
  while (all.step()) visit({all.integer(0), last_row - all.integer(1)}, tile_of(all, 2));
  return true;
}

}  // namespace orthodrive::remote
