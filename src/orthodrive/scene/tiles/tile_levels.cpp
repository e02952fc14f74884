// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/scene/tiles/tile_levels.hpp"

#include <algorithm>

namespace orthodrive::scene {
namespace {

constexpr std::size_t most_levels = 6;  // tiles of 31 km: offsets from their middles are still exact as floats

/// Interleaves the bits of column and row (Morton 1966).
std::uint64_t morton_code(TileAddress a) {
  std::uint64_t code = 0;
  const auto bits = [](int v) { return static_cast<std::uint32_t>(v) ^ 0x80000000U; };  // negative ones come first
  for (unsigned k = 0; k < 32; ++k) {
    code |= static_cast<std::uint64_t>(bits(a.column) >> k & 1U) << (2 * k + 1);
    code |= static_cast<std::uint64_t>(bits(a.row) >> k & 1U) << (2 * k);
  }
  return code;
}

}  // namespace

TileLevels::TileLevels(const std::vector<TileAddress>& addresses, Write write)
    : order_(addresses), write_(std::move(write)) {
  std::ranges::sort(order_, {}, morton_code);
  std::vector<TileAddress> below = addresses;
  while (below.size() > 1 && levels_.size() < most_levels) {
    std::map<TileAddress, Parts> level;
    for (const TileAddress a : below) ++level[parent_of(a)].missing;
    if (level.size() == below.size()) break;
    below.clear();
    for (const auto& [address, parts] : level) below.push_back(address);
    levels_.push_back(std::move(level));
  }
}

void TileLevels::finish(SceneTile tile, std::span<const PlacedBuilding* const> buildings) {
  const TileAddress address{tile.column, tile.row};
  FinishedTile finished{.address = address};
  if (!tile.meshes.empty()) write_(tile);
  if (levels_.empty()) return;
  for (const PlacedBuilding* building : buildings) finished.buildings.push_back(*building);
  if (!tile.meshes.empty()) finished.tile = std::make_unique<const SceneTile>(ready_to_coarsen(std::move(tile)));
  hand_up(0, address, std::move(finished));
}

void TileLevels::stop_at(int level, std::function<void(FinishedTile)> keep) {
  last_level_ = level;
  keep_ = std::move(keep);
}

void TileLevels::adopt(int level, FinishedTile tile) {
  const TileAddress address = tile.address;
  if (level < coarse_levels()) hand_up(level, address, std::move(tile));
}

void TileLevels::hand_up(int level, TileAddress address, FinishedTile tile) {
  if (level == last_level_) {
    keep_(std::move(tile));
    return;
  }
  const TileAddress parent = parent_of(address);
  Parts parts;
  {
    const std::lock_guard lock(mutex_);
    Parts& found = levels_[static_cast<std::size_t>(level)].at(parent);
    if (tile.tile) found.tiles.push_back(std::move(tile));
    if (--found.missing > 0) return;
    parts = std::move(found);
  }
  FinishedTile coarse{.address = parent};
  if (!parts.tiles.empty()) {
    std::ranges::sort(parts.tiles, {}, &FinishedTile::address);
    std::vector<const SceneTile*> tiles;
    std::vector<const PlacedBuilding*> buildings;
    tiles.reserve(parts.tiles.size());
    for (const FinishedTile& part : parts.tiles) {
      tiles.push_back(part.tile.get());
      for (const PlacedBuilding& building : part.buildings) buildings.push_back(&building);
    }
    coarse.tile = std::make_unique<const SceneTile>(coarse_tile(tiles, buildings));
    for (const FinishedTile& part : parts.tiles)
      for (const PlacedBuilding& building : part.buildings)
        if (is_seen_on(building, level + 2)) coarse.buildings.push_back(building);
    parts.tiles.clear();
    write_(*coarse.tile);
  }
  if (level + 1 < coarse_levels()) hand_up(level + 1, parent, std::move(coarse));
}

}  // namespace orthodrive::scene
