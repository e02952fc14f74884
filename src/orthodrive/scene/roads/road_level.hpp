// SPDX-License-Identifier: Apache-2.0
#pragma once
// All roads of one level (the ground, or the bridge decks of one OSM layer) as a single surface without overlaps.

#include <memory>
#include <optional>
#include <vector>

#include "orthodrive/geo/spatial_index.hpp"
#include "orthodrive/scene/plan/outline.hpp"
#include "orthodrive/scene/roads/road_joints.hpp"
#include "orthodrive/scene/roads/road_strip.hpp"
#include "roadquery/query/road_query.hpp"

namespace orthodrive::scene {

struct SurfaceSample {
  double z_m = 0.0;
  Vec3 normal{0.0, 0.0, 1.0};
  /// Distance to the border of the road that p lies deepest in; negative: outside of all. Between the roads of a
  /// junction with a surface of its own: a little.
  double inside_m = 0.0;
};

struct RoadLevelOptions {
  StripOptions strip;
  double reach_m = 5.0;  ///< of Outline::nearest
  int threads = 0;
  /// Of the whole map, which the roads are of; null: the roads are all there is.
  std::shared_ptr<const roadquery::RoadQuery> query;
  const RoadJoints* joints = nullptr;  ///< with roads of other levels, of the query's map; null: none
};

class RoadLevel {
 public:
  RoadLevel() = default;
  /// The roads must outlive the level, the area lies on the plan grid. Roads that cross_sections() cannot draw must not
  /// be among them.
  RoadLevel(std::vector<const roadquery::Road*> roads, const Polygon& area, const RoadLevelOptions& options);

  /// The highest surface of the level at p as the road query has it: where roads overlap (junctions) it is the mean of
  /// those within 1.5 m of height, of whatever level, see roadquery/blend.hpp.
  /// Nothing when p is further than `sample_reach_m` from every road and junction of the level.
  [[nodiscard]] std::optional<SurfaceSample> sample(Vec2 p) const { return sample(p, sample_reach_m); }
  /// Nothing when p is further than reach_m (at most sample_reach_m) from every road and junction; 0: on none.
  [[nodiscard]] std::optional<SurfaceSample> sample(Vec2 p, double reach_m) const;
  [[nodiscard]] const std::vector<const roadquery::Road*>& roads() const { return roads_; }
  [[nodiscard]] const MultiPolygon& polygons() const { return polygons_; }  ///< union of the carriageways, in the area
  /// The pieces of carriageways and junctions whose boxes touch the given one, also outside the area; relative to
  /// `from`. They may overlap.
  [[nodiscard]] MultiPolygon paved_near(const Box2& box, Vec2 from) const;
  /// With what the road query adds beyond the ends of roads: what stands keeps clear of it.
  [[nodiscard]] MultiPolygon driven_near(const Box2& box, Vec2 from) const;
  [[nodiscard]] const Outline& outline() const { return outline_; }  ///< of polygons(), heights of the surface
  [[nodiscard]] const std::vector<std::vector<CrossSection>>& strips() const { return strips_; }  ///< one per road

  static constexpr double sample_reach_m = 1.0;

 private:
  [[nodiscard]] MultiPolygon junction_areas(const RoadJoints* joints);
  [[nodiscard]] std::optional<SurfaceSample> beside_junction(Vec2 p, double reach_m) const;

  std::vector<const roadquery::Road*> roads_;
  std::shared_ptr<const roadquery::RoadQuery> query_;
  std::vector<bool> is_on_level_;  // of the query's roads
  std::vector<std::vector<CrossSection>> strips_;
  std::vector<const roadquery::JunctionSurface*> junctions_;  // on this level
  SpatialIndex junction_index_;
  std::vector<Polygon> pieces_;   // between two sections of a road, junctions; then those beyond ends
  std::size_t paved_pieces_ = 0;  // of them: before those beyond ends
  SpatialIndex piece_index_;
  MultiPolygon polygons_;
  Outline outline_;
};

}  // namespace orthodrive::scene
