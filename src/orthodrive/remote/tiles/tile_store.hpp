// SPDX-License-Identifier: Apache-2.0
#pragma once
// Tiles in one SQLite file while they are fetched, and as MBTiles 1.3 when all are there.
// https://github.com/mapbox/mbtiles-spec/blob/master/1.3/spec.md

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>

#include "orthodrive/remote/tiles/tile_matrix.hpp"

namespace orthodrive::remote {

struct StoredTile {
  bool missing = false;  ///< the server has none there
  std::string bytes, etag, last_modified;
};

/// Rows count from the north here, whatever the file has. What is put is kept in batches: a kill loses the last second
/// at most. One process at a time. Throws Error for a full disk and a second process, InputError for a damaged file.
class TileStore {
 public:
  /// Opens or makes FILE. What another plan (address, layer, level) left in it is thrown away.
  TileStore(const std::filesystem::path& file, const std::string& plan);
  ~TileStore();
  TileStore(const TileStore&) = delete;
  TileStore& operator=(const TileStore&) = delete;

  [[nodiscard]] bool has(TileAddress tile) const;
  [[nodiscard]] std::optional<StoredTile> get(TileAddress tile) const;
  void put(TileAddress tile, const StoredTile& stored);
  /// Ends the batch when it is a second old, or at once.
  void keep(bool now = false);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Writes an MBTiles file of these tiles, in their order (by row from the north, then column): same tiles, same bytes.
/// Missing ones are left out. `metadata` as the specification has it. Beside the tables of MBTiles it has `validators`
/// (ETag and Last-Modified of each tile) and in `metadata` the key `plan`. Written aside, then renamed.
void write_mbtiles(const std::filesystem::path& target, const TileStore& store, int zoom,
                   const std::vector<TileAddress>& tiles, const std::map<std::string, std::string>& metadata);

/// Calls visit for the tiles of an MBTiles file that write_mbtiles made of the same plan; false when it is another.
bool visit_mbtiles(const std::filesystem::path& file, const std::string& plan, int zoom,
                   const std::function<void(TileAddress, const StoredTile&)>& visit);

}  // namespace orthodrive::remote
