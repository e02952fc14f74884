// SPDX-License-Identifier: Apache-2.0
#pragma once
// The order in which tiles of all levels are made, so that few of them are held at a time.

#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "orthodrive/scene/plan/tile_address.hpp"
#include "orthodrive/scene/tiles/coarse_tile.hpp"

namespace orthodrive::scene {

/// Takes finished tiles of level 0 from any thread and makes the levels above. A coarse tile is made by the thread that
/// finishes the last of its parts and depends on these alone, so neither threads nor their order change it.
class TileLevels {
 public:
  /// What the level above needs of a tile.
  struct FinishedTile {
    TileAddress address;
    std::unique_ptr<const SceneTile> tile;  ///< null without a mesh
    std::vector<PlacedBuilding> buildings;  ///< that may show on the levels above
  };
  /// Called with every tile that has a mesh, from any thread.
  using Write = std::function<void(const SceneTile&)>;
  TileLevels(const std::vector<TileAddress>& addresses, Write write);

  /// Tiles of level 0, those of one parent beside each other, and so on up.
  [[nodiscard]] const std::vector<TileAddress>& order() const { return order_; }
  /// Levels above 0: until one tile is left, or until the next level would have as many; 6 at most.
  [[nodiscard]] int coarse_levels() const { return static_cast<int>(levels_.size()); }
  /// Each tile once, with the buildings in it; those without a mesh too.
  void finish(SceneTile tile, std::span<const PlacedBuilding* const> buildings);

  /// Where several processes share a scene: finished tiles of this level go to `keep`, from any thread, and no level
  /// above is made.
  void stop_at(int level, std::function<void(FinishedTile)> keep);
  /// A tile that another process kept, in place of all tiles below it.
  void adopt(int level, FinishedTile tile);

 private:
  struct Parts {
    std::size_t missing = 0;
    std::vector<FinishedTile> tiles;
  };
  void hand_up(int level, TileAddress address, FinishedTile tile);

  std::vector<TileAddress> order_;
  std::vector<std::map<TileAddress, Parts>> levels_;  ///< level 1 first
  Write write_;
  int last_level_ = -1;  ///< that is made here; -1: all are
  std::function<void(FinishedTile)> keep_;
  std::mutex mutex_;
};

}  // namespace orthodrive::scene
