#pragma once
// What the tiles of a scene share.

#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "orthodrive/geo/overlay.hpp"
#include "orthodrive/scene/build_scene.hpp"
#include "orthodrive/scene/buildings.hpp"
#include "orthodrive/scene/ground.hpp"
#include "orthodrive/scene/kerbs.hpp"
#include "orthodrive/scene/line_objects.hpp"
#include "orthodrive/scene/map_objects.hpp"
#include "orthodrive/scene/plan_grid.hpp"
#include "orthodrive/scene/road_joints.hpp"
#include "orthodrive/scene/road_level.hpp"
#include "orthodrive/scene/road_markings.hpp"
#include "orthodrive/scene/road_tint.hpp"
#include "orthodrive/scene/structures.hpp"
#include "orthodrive/scene/trees.hpp"
#include "orthodrive/scene/tunnels.hpp"
#include "orthodrive/scene/water.hpp"

namespace orthodrive {
namespace scene {

[[nodiscard]] Box2 tile_box(TileAddress address);
[[nodiscard]] TileAddress tile_at(Vec2 p);

/// What one level puts into the tiles.
struct LevelLines {
  /// Borders of the roads (on the ground also of the area), split at each other and at tile borders. Those along a tile
  /// border are left out, their ends are in on_west and on_south.
  std::map<TileAddress, std::vector<LineSegment>> inside;
  /// Where lines meet a tile border: northings on the west side of a column, eastings on the south side of a row.
  std::map<int, std::vector<double>> on_west, on_south;
  std::map<TileAddress, std::vector<Vec2>> axis_points;  ///< on the reference lines of the roads
  /// Paint on the roads; pieces over a tile border stand in both tiles.
  std::map<TileAddress, std::vector<MarkingPiece>> markings;
  std::map<TileAddress, std::vector<KerbPiece>> kerbs;  ///< likewise
};

}  // namespace scene

class SceneLayout {
 public:
  SceneLayout(const SceneInput& input, const SceneOptions& options);
  SceneLayout(const SceneLayout&) = delete;  // ground points into it

  SceneOptions options;
  const Photo* photo = nullptr;
  const LabelMap* labels = nullptr;
  Vec3 origin;
  Findings findings;
  std::vector<TileAddress> tiles;
  scene::Outline area;
  scene::RoadLevel roads;  ///< on the ground
  scene::LevelLines ground_lines;
  std::vector<scene::RoadLevel> decks;  ///< of bridges, by OSM layer; those that cross apart
  std::vector<scene::LevelLines> deck_lines;
  std::vector<scene::RoadLevel> tunnels;  ///< likewise
  std::vector<scene::LevelLines> tunnel_lines;
  scene::RoadJoints joints;  ///< of levels; the ground is 0, then come decks and tunnels
  scene::Outline openings;   ///< no ground lies in them
  std::optional<scene::Ground> ground;
  std::shared_ptr<const roadquery::RoadQuery> query;  ///< of all roads, without the heights of lanes: kerbs lie on it
  scene::RoadTint tint;
  std::vector<scene::PlacedBuilding> buildings;
  std::map<TileAddress, std::vector<const scene::PlacedBuilding*>> buildings_in;  ///< by their middles
  std::vector<scene::PlacedTree> trees;
  std::map<TileAddress, std::vector<const scene::PlacedTree*>> trees_in;
  std::map<TileAddress, std::vector<scene::StructureFace>> structures, tubes, barriers, tracks,
      objects;  ///< by their middles
  scene::Waters waters;
  std::vector<scene::PlacedLamp> lamps;
  std::map<TileAddress, std::vector<const scene::PlacedLamp*>> lamps_in;
  /// Terrain vertices besides the raster: beside roads and below bridges.
  std::map<TileAddress, std::vector<Vec2>> terrain_points;

  /// By its number in `joints`.
  [[nodiscard]] const scene::RoadLevel& level(int number) const;

 private:
  void lay_roads(const SceneInput& input);
  void lay_levels(const SceneInput& input, const Polygon& site_area);
  void lay_tunnels(const MultiPolygon& area_polygons, std::vector<Polyline>& lines);
  void add_surroundings(const MapSurroundings& surroundings, const scene::FreeSpace& space);
  void choose_tiles(const Box2& bounds);
  void add_terrain_points();
};

}  // namespace orthodrive
