// SPDX-License-Identifier: Apache-2.0
#pragma once
// The scene for the eye: textured terrain with the roads cut in, tile by tile. What is seen is what is driven: road
// vertices lie on the surface of roadquery/road_surface.hpp. How it is made: docs/scene.md.

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "orthodrive/core/finding.hpp"
#include "orthodrive/core/monitor.hpp"
#include "orthodrive/core/shared_loop.hpp"
#include "orthodrive/model/scene.hpp"
#include "orthodrive/scene/plan/scene_input.hpp"
#include "orthodrive/scene/plan/tile_address.hpp"

namespace orthodrive {

/// What the tiles of a block share: the roads' union by level, its heights, the splits at tile borders.
class SceneLayout;

/// Convex hull of the photo's valid pixels: the area where no other is given. Empty for a photo without any.
[[nodiscard]] Polygon photo_outline(const PhotoSource& photo);

/// One block for all of the area. Throws OptionError without an area and InputError when the terrain has no height at
/// all.
[[nodiscard]] std::shared_ptr<const SceneLayout> lay_out_scene(const SceneInput& input,
                                                               const SceneOptions& options = {});
/// The tiles that share ground with the area, by column, then row.
[[nodiscard]] const std::vector<TileAddress>& scene_tiles(const SceneLayout& layout);
[[nodiscard]] Findings scene_findings(const SceneLayout& layout);
/// Meshes of terrain and road share the vertices where they meet; decks of bridges are road, their sides and undersides
/// road_body. Vertices on the tile's border equal those of the neighbour bit by bit, once the origins
/// are added. No meshes where there is no ground. Safe from any thread.
[[nodiscard]] SceneTile build_scene_tile(const SceneLayout& layout, TileAddress address);

struct SceneResult {
  Vec3 origin;     ///< middle of the area at a height of the terrain, whole metres
  int levels = 1;  ///< of detail
  std::size_t tiles = 0, terrain_triangles = 0, road_triangles = 0;  ///< of level 0
  double road_surface_m2 = 0.0;  ///< in plan; bridges and what they cross both count
  std::size_t buildings = 0, trees = 0;
  Findings findings;

  /// Adds all but origin and levels.
  SceneResult& operator+=(const SceneResult& other);
};

/// Takes tiles from worker threads.
using TileSink = std::function<void(const SceneTile& tile)>;
/// Bytes that build_scene_cells() left of a cell, perhaps on another machine; nothing: the cell is made now.
using MadeCells = std::function<std::optional<std::string>(std::size_t cell)>;

/// All tiles of all levels (scene/tiles/coarse_tile.hpp), in parallel, each handed to `write` from a worker thread as
/// soon as it is done, and forgotten when the one above it is. Laid out block by block: of rasters, meshes and what is
/// drawn only that of a few blocks is held at a time. Tiles of cells made before are not handed over again.
SceneResult build_scene(const SceneSource& source, const TileSink& write, const SceneOptions& options = {},
                        Monitor* monitor = nullptr, const MadeCells& made = {});

/// What becomes of the cells that a process makes, one after the other.
struct CellSink {
  std::function<void(std::size_t cell)> begin;
  TileSink write;
  std::function<void(const std::string& bytes)> finish;  ///< after its last tile
};
/// Makes those cells of build_scene() that `next` gives, with the same source and options, one after the other. A cell
/// is a block of SceneOptions::block_tiles with all levels that lie in it.
void build_scene_cells(const SceneSource& source, const NextItem& next, const CellSink& sink,
                       const SceneOptions& options = {});

}  // namespace orthodrive
