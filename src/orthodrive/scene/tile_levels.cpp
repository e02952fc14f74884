#include "orthodrive/scene/tile_levels.hpp"

#include <algorithm>
#include <limits>

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

TileLevels::TileLevels(const std::vector<TileAddress>& addresses, const Buildings& buildings, Write write)
    : order_(addresses), buildings_(&buildings), write_(std::move(write)) {
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

void TileLevels::finish(SceneTile tile) {
  const TileAddress address{tile.column, tile.row};
  if (!tile.meshes.empty()) write_(tile);
  if (levels_.empty()) return;
  hand_up(0, address,
          tile.meshes.empty() ? nullptr : std::make_unique<const SceneTile>(ready_to_coarsen(std::move(tile))));
}

std::vector<const PlacedBuilding*> TileLevels::buildings_in(int level, TileAddress address) const {
  std::vector<const PlacedBuilding*> result;
  const int first = address.column << level, end = (address.column + 1) << level;
  for (auto at = buildings_->lower_bound({first, std::numeric_limits<int>::min()});
       at != buildings_->end() && at->first.column < end; ++at)
    if (at->first.row >> level == address.row) result.insert(result.end(), at->second.begin(), at->second.end());
  return result;
}

void TileLevels::hand_up(int level, TileAddress address, std::unique_ptr<const SceneTile> tile) {
  const TileAddress parent = parent_of(address);
  Parts parts;
  {
    const std::lock_guard lock(mutex_);
    Parts& found = levels_[static_cast<std::size_t>(level)].at(parent);
    if (tile) found.tiles.push_back(std::move(tile));
    if (--found.missing > 0) return;
    parts = std::move(found);
  }
  std::unique_ptr<const SceneTile> coarse;
  if (!parts.tiles.empty()) {
    std::ranges::sort(parts.tiles, {}, [](const auto& part) { return TileAddress{part->column, part->row}; });
    std::vector<const SceneTile*> tiles;
    for (const auto& part : parts.tiles) tiles.push_back(part.get());
    coarse = std::make_unique<const SceneTile>(coarse_tile(tiles, buildings_in(level + 1, parent)));
    parts.tiles.clear();
    write_(*coarse);
  }
  if (level + 1 < coarse_levels()) hand_up(level + 1, parent, std::move(coarse));
}

}  // namespace orthodrive::scene
