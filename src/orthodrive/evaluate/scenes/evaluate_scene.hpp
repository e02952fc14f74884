// SPDX-License-Identifier: Apache-2.0
#pragma once
// What is wrong with the tiles of a scene: cracks, roads beside their surface, normals that differ at borders, things
// that stand on roads and in buildings. Of level 0; of the others what they cost.

#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "orthodrive/core/finding.hpp"
#include "orthodrive/geo/spatial_index.hpp"
#include "orthodrive/model/scene.hpp"
#include "roadquery/query/road_query.hpp"

namespace orthodrive {

struct SceneScores {
  int levels = 0;
  std::size_t tiles = 0, tiles_of_level_0 = 0;
  double ground_km2 = 0.0;                    ///< terrain, water and roads in plan, decks too
  std::size_t triangles = 0, draw_calls = 0;  ///< of level 0; a copied mesh is one call, its copies count as triangles
  std::uintmax_t bytes = 0;                   ///< of all levels
  /// Edges of the ground, decks and their bodies that no triangle continues, besides the scene's outer border; between
  /// tiles, too. And edges that more than two triangles share.
  std::size_t open_edges = 0, crowded_edges = 0;
  std::size_t road_samples = 0, road_samples_off = 0;  ///< middles of road triangles and of their edges; > 2 cm off
  double road_error_m = 0.0, road_error_p999_m = 0.0;  ///< from the road query's surface: largest, and of 1 in 1000
  std::size_t shared_vertices = 0;                     ///< of roads and terrain, on the borders of tiles
  double normal_error_deg = 0.0;                       ///< the largest between their normals
  std::size_t standing_vertices = 0, on_road = 0;      ///< of what stands beside roads; over a road by up to 4.5 m
  std::size_t in_building = 0;                         ///< vertices of trees, barriers, lamps, objects inside buildings
  Findings faults;  ///< with their places: the worst of roads, the first of each mesh and of cracks
};

/// Takes tiles one by one; memory goes with the tiles' borders.
class SceneScorer {
 public:
  /// `roads` without the heights of lanes: kerbs lie over the road's mesh. It must outlive the scorer.
  explicit SceneScorer(const roadquery::RoadQuery& roads) : roads_(&roads) {}
  void add(const SceneTile& tile, std::uintmax_t bytes);
  [[nodiscard]] SceneScores finish();

 private:
  using Place = std::array<double, 3>;
  using Edge = std::array<Place, 2>;
  void add_edges(const SceneTile& tile);
  void add_roads(const SceneTile& tile);
  void add_normals(const SceneTile& tile);
  void add_standing(const SceneTile& tile);
  void check_standing(MeshKind kind, const Place& p);
  void add_shells(const SceneTile& tile);
  void check_shells(MeshKind kind, const Place& p, const Box2& tile);
  void note_in_building(MeshKind kind, const Place& p);
  void fault(const char* code, std::string message, const Place& at);
  void note_road_error(double error_m, const Place& at);

  const roadquery::RoadQuery* roads_;
  SceneScores scores_;
  std::vector<Edge> open_;  ///< of single tiles
  std::map<Place, std::vector<std::array<float, 3>>> border_normals_;
  /// Triangles of buildings seen from above, with an index.
  struct Shells {
    std::vector<std::array<Place, 3>> triangles;
    SpatialIndex index;
    void make_index();
    [[nodiscard]] bool contain(const Place& p) const;
  };
  Shells shells_;        ///< of the tile
  Shells over_borders_;  ///< those that reach over the border of their tile
  /// What stands near a border of its tile, from `first_place_`.
  std::map<MeshKind, std::vector<std::array<float, 3>>> near_borders_;
  std::optional<Place> first_place_;
  std::vector<float> road_errors_m_;
  std::multimap<double, Place> worst_roads_;
  std::map<std::string, int> told_;  ///< by message
};

}  // namespace orthodrive
