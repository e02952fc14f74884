// SPDX-License-Identifier: Apache-2.0
#pragma once
// What the tiles of a block share.

#include <array>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "orthodrive/geo/overlay.hpp"
#include "orthodrive/scene/buildings/buildings.hpp"
#include "orthodrive/scene/ground/ground_surface.hpp"
#include "orthodrive/scene/ground/water.hpp"
#include "orthodrive/scene/plan/plan_grid.hpp"
#include "orthodrive/scene/plan/scene_input.hpp"
#include "orthodrive/scene/plan/tile_address.hpp"
#include "orthodrive/scene/plants/ground_cover.hpp"
#include "orthodrive/scene/roads/kerbs.hpp"
#include "orthodrive/scene/roads/road_joints.hpp"
#include "orthodrive/scene/roads/road_level.hpp"
#include "orthodrive/scene/roads/road_markings.hpp"
#include "orthodrive/scene/roads/road_tint.hpp"
#include "orthodrive/scene/structures/tunnels.hpp"
#include "orthodrive/scene/tiles/families.hpp"
#include "orthodrive/scene/tiles/scene_frame.hpp"
#include "orthodrive/scene/tiles/scene_windows.hpp"

namespace orthodrive {
class SceneLayout;

namespace scene {

/// What one level puts into the tiles.
struct LevelLines {
  /// Borders of the roads (on the ground also of the area), split at each other and at tile borders, in an order of
  /// their own. Those along a tile border are left out, their ends are in on_west and on_south.
  std::map<TileAddress, std::vector<LineSegment>> inside;
  /// Where lines meet a tile border: northings on the west side of a column, eastings on the south side of a row.
  std::map<int, std::vector<double>> on_west, on_south;
  /// Paint on the roads; pieces over a tile border stand in both tiles.
  std::map<TileAddress, std::vector<MarkingPiece>> markings;
  std::map<TileAddress, std::vector<KerbPiece>> kerbs;  ///< likewise
};

/// The ground of a block of tiles, addressed as if blocks were tiles.
[[nodiscard]] Box2 block_box(TileAddress block, int block_tiles);
/// That of the smallest rectangle of tiles that holds all of these.
[[nodiscard]] Box2 block_around(const std::vector<TileAddress>& tiles);

/// Lays out the tiles of a block, with findings at places in it only: those beyond the rim of the area count for the
/// block next to them.
[[nodiscard]] std::shared_ptr<const SceneLayout> lay_out_block(const std::shared_ptr<const SceneFrame>& frame,
                                                               const SceneWindows& windows, const Box2& block);

}  // namespace scene

class SceneLayout {
 public:
  /// Of the tiles of the frame in `block`, which lies inside the window.
  SceneLayout(std::shared_ptr<const scene::SceneFrame> frame, scene::SceneWindow window, const Box2& block);
  SceneLayout(const SceneLayout&) = delete;  // ground points into it

  std::shared_ptr<const scene::SceneFrame> frame;
  scene::SceneWindow window;
  const SceneOptions& options;
  const scene::Outline& area;
  Vec3 origin;
  const Photo* photo;
  const LabelMap* labels;  ///< null: none
  Findings findings;       ///< at places of the window
  std::vector<TileAddress> tiles;
  scene::RoadLevel roads;  ///< on the ground
  scene::LevelLines ground_lines;
  std::vector<scene::RoadLevel> decks;  ///< of bridges, by OSM layer; those that cross apart
  std::vector<scene::LevelLines> deck_lines;
  std::vector<scene::RoadLevel> tunnels;  ///< likewise
  std::vector<scene::LevelLines> tunnel_lines;
  scene::RoadJoints joints;                           ///< of levels; the ground is 0, then come decks and tunnels
  scene::Outline openings;                            ///< no ground lies in them
  std::unique_ptr<const scene::Ground> ground;        ///< never null once the layout is made
  std::shared_ptr<const roadquery::RoadQuery> query;  ///< of all roads, without the heights of lanes: kerbs lie on it
  scene::RoadTint tint;
  std::vector<scene::PlacedBuilding> buildings;  ///< free space lies between them; coarser tiles make them anew
  scene::BuildingsByTile buildings_in;           ///< by their middles
  scene::Families families;                      ///< all that stands on the ground and the roads
  scene::Waters waters;
  std::vector<scene::PlacedCover> covers;
  std::map<TileAddress, std::vector<const scene::PlacedCover*>> covers_in;
  /// Terrain vertices besides the raster, by rows: beside roads at three distances, below bridges, over tunnels.
  std::map<TileAddress, std::array<std::vector<Vec2>, 5>> terrain_points;

  /// By its number in `joints`.
  [[nodiscard]] const scene::RoadLevel& level(int number) const;
  [[nodiscard]] bool is_deck(int number) const { return number > 0 && number <= static_cast<int>(decks.size()); }

 private:
  void lay_roads();
  void lay_levels();
  void lay_tunnels(std::vector<Polyline>& lines);
  void add_surroundings(const MapSurroundings& surroundings, const scene::FreeSpace& space, const Box2& block);
  void add_terrain_points();
};

}  // namespace orthodrive
