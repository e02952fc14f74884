// SPDX-License-Identifier: Apache-2.0
// A scene block by block: all of it, or the cells that a process of several makes.

#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <mutex>

#include "orthodrive/core/byte_archive.hpp"
#include "orthodrive/core/memory.hpp"
#include "orthodrive/core/parallel.hpp"
#include "orthodrive/scene/build_scene.hpp"
#include "orthodrive/scene/buildings/archived_tiles.hpp"
#include "orthodrive/scene/tiles/scene_layout.hpp"
#include "orthodrive/scene/tiles/tile_levels.hpp"

namespace orthodrive {

using namespace scene;

namespace {

double plan_area_m2(const TriMesh& mesh) {
  double twice = 0.0;
  for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
    const auto at = [&](std::size_t k) {
      const auto& p = mesh.positions[mesh.indices[i + k]];
      return Vec2{p[0], p[1]};
    };
    twice += cross(at(1) - at(0), at(2) - at(0));
  }
  return 0.5 * twice;
}

/// Blocks in the order of the tiles, of which each holds a row.
struct Block {
  TileAddress address;
  std::span<const TileAddress> tiles;
};

std::vector<Block> blocks_of(const std::vector<TileAddress>& tiles, int block_tiles) {
  const auto block_of = [&](TileAddress a) {
    const auto down = [&](int v) { return static_cast<int>(std::floor(static_cast<double>(v) / block_tiles)); };
    return TileAddress{down(a.column), down(a.row)};
  };
  std::vector<Block> blocks;
  for (std::size_t first = 0, end = 0; first < tiles.size(); first = end) {
    const TileAddress address = block_of(tiles[first]);
    while (end < tiles.size() && block_of(tiles[end]) == address) ++end;
    blocks.push_back({address, std::span(tiles).subspan(first, end - first)});
  }
  return blocks;
}

void add_tile(const SceneTile& tile, SceneResult& result) {
  result.tiles += tile.meshes.empty() ? 0 : 1;
  for (const InstancedMesh& copied : tile.instanced)
    if (copied.mesh.kind == MeshKind::tree) result.trees += copied.instances.size();
  for (const TriMesh& mesh : tile.meshes) {
    if (mesh.kind == MeshKind::terrain) result.terrain_triangles += mesh.indices.size() / 3;
    if (mesh.kind != MeshKind::road) continue;
    result.road_triangles += mesh.indices.size() / 3;
    result.road_surface_m2 += plan_area_m2(mesh);
  }
}

std::span<const PlacedBuilding* const> buildings_in(const SceneLayout& layout, TileAddress address) {
  const auto found = layout.buildings_in.find(address);
  return found == layout.buildings_in.end() ? std::span<const PlacedBuilding* const>{} : found->second;
}

SceneResult build_block(const SceneLayout& layout, std::span<const TileAddress> tiles, TileLevels& levels,
                        const std::function<void()>& after_each) {
  std::vector<SceneResult> of_tile(tiles.size());
  parallel_for(tiles.size(), layout.options.threads, [&](std::size_t i) {
    SceneTile tile = build_scene_tile(layout, tiles[i]);
    add_tile(tile, of_tile[i]);
    const auto buildings = buildings_in(layout, tiles[i]);
    of_tile[i].buildings = buildings.size();
    levels.finish(std::move(tile), buildings);
    after_each();
  });
  SceneResult sum;
  for (const SceneResult& part : of_tile) sum += part;
  sum.findings = layout.findings;
  return sum;
}

}  // namespace

SceneResult& SceneResult::operator+=(const SceneResult& other) {
  tiles += other.tiles, terrain_triangles += other.terrain_triangles, road_triangles += other.road_triangles;
  road_surface_m2 += other.road_surface_m2;
  buildings += other.buildings, trees += other.trees;
  findings.insert(findings.end(), other.findings.begin(), other.findings.end());
  return *this;
}

namespace {

/// What a process leaves of a cell: the numbers, and what the level above needs.
struct SceneCell {
  SceneResult numbers;
  TileAddress address;  ///< of the block
  bool has_tile = false;
  SceneTile tile;
  std::vector<PlacedBuilding> buildings;
};
template <typename Archive>
void fields(Archive& archive, SceneCell& p) {
  SceneResult& n = p.numbers;
  archive(n.tiles, n.terrain_triangles, n.road_triangles, n.road_surface_m2, n.buildings, n.trees, n.findings,
          p.address.column, p.address.row, p.has_tile, p.buildings);
  if (p.has_tile) archive(p.tile);
}

SceneCell cell_of_bytes(const std::string& bytes, std::size_t cell, TileAddress block) {
  const std::string name = fmt::format("cell {} of the scene", cell);
  SceneCell read;
  ByteReader reader(bytes, name);
  reader(read);
  reader.finish();
  if (read.address != block) throw InputError(name, "is of another area; remove it and run again");
  return read;
}

/// A scene as it is cut into cells.
struct SceneCells {
  SceneCells(const SceneSource& source, const SceneOptions& options, TileLevels::Write write)
      : frame(std::make_shared<const SceneFrame>(source, options)),
        windows(source, *frame),
        levels(frame->tiles, std::move(write)),
        blocks(blocks_of(levels.order(), options.block_tiles)),
        level(std::countr_zero(static_cast<unsigned>(options.block_tiles))) {}

  [[nodiscard]] SceneResult build(std::size_t cell, const std::function<void()>& after_each) {
    const int block_tiles = frame->options.block_tiles;
    SceneResult result = build_block(*lay_out_block(frame, windows, block_box(blocks[cell].address, block_tiles)),
                                     blocks[cell].tiles, levels, after_each);
    release_free_memory();
    return result;
  }

  std::shared_ptr<const SceneFrame> frame;
  SceneWindows windows;
  TileLevels levels;
  std::vector<Block> blocks;  ///< one per cell
  int level;                  ///< of the tile that covers a cell
};

/// Counts tiles from any thread.
class TileProgress {
 public:
  TileProgress(std::size_t tiles, Monitor* monitor) : tiles_(tiles), monitor_(monitor) { tell(); }
  void add(std::size_t tiles) {
    const std::lock_guard lock(mutex_);
    done_ += tiles;
    tell();
  }

 private:
  void tell() const {
    if (monitor_ && tiles_ > 0) monitor_->progress(static_cast<double>(done_) / static_cast<double>(tiles_), "scene");
  }
  std::size_t tiles_, done_ = 0;
  Monitor* monitor_;
  std::mutex mutex_;
};

}  // namespace

SceneResult build_scene(const SceneSource& source, const TileSink& write, const SceneOptions& options, Monitor* monitor,
                        const MadeCells& made) {
  SceneCells scene(source, options, write);
  TileProgress progress(scene.frame->tiles.size(), monitor);
  std::vector<SceneResult> numbers(scene.blocks.size());
  // Two at a time: while one is laid out, which is one thread's work in places, the other has tiles to build.
  constexpr int blocks_at_a_time = 2;
  parallel_for(scene.blocks.size(), std::min(blocks_at_a_time, worker_count(options.threads)), [&](std::size_t i) {
    if (const std::optional<std::string> bytes = made ? made(i) : std::nullopt) {
      SceneCell cell = cell_of_bytes(*bytes, i, scene.blocks[i].address);
      numbers[i] = std::move(cell.numbers);
      TileLevels::FinishedTile tile{.address = cell.address, .buildings = std::move(cell.buildings)};
      if (cell.has_tile) tile.tile = std::make_unique<const SceneTile>(std::move(cell.tile));
      scene.levels.adopt(scene.level, std::move(tile));
      progress.add(scene.blocks[i].tiles.size());
    } else {
      numbers[i] = scene.build(i, [&] { progress.add(1); });
    }
  });
  SceneResult result;
  for (const SceneResult& cell : numbers) result += cell;
  result.findings.insert(result.findings.begin(), scene.frame->findings.begin(), scene.frame->findings.end());
  result.origin = scene.frame->origin;
  result.levels = 1 + scene.levels.coarse_levels();
  return result;
}

void build_scene_cells(const SceneSource& source, const NextItem& next, const CellSink& sink,
                       const SceneOptions& options) {
  SceneCell made;
  SceneCells scene(source, options, sink.write);
  scene.levels.stop_at(scene.level, [&](TileLevels::FinishedTile tile) {
    made.has_tile = tile.tile != nullptr;
    if (tile.tile) made.tile = *tile.tile;
    made.buildings = std::move(tile.buildings);
  });
  while (const std::optional<std::size_t> cell = next(scene.blocks.size())) {
    sink.begin(*cell);
    made = {.address = scene.blocks[*cell].address};
    made.numbers = scene.build(*cell, [] {});
    ByteWriter writer;
    writer(made);
    sink.finish(writer.take());
  }
}

}  // namespace orthodrive
