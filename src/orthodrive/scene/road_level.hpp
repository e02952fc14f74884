#pragma once
// All roads of one level (the ground, or the bridge decks of one OSM layer) as a single surface without overlaps.

#include <optional>
#include <vector>

#include "orthodrive/scene/cell_index.hpp"
#include "orthodrive/scene/outline.hpp"
#include "orthodrive/scene/road_strip.hpp"

namespace orthodrive::scene {

struct SurfaceSample {
  double z_m = 0.0;
  Vec3 normal{0.0, 0.0, 1.0};
  double inside_m = 0.0;  ///< distance to the border of the road that p lies deepest in; negative: outside of all
};

struct RoadLevelOptions {
  StripOptions strip;
  double reach_m = 5.0;  ///< of Outline::nearest
  int threads = 0;
};

class RoadLevel {
 public:
  RoadLevel() = default;
  /// The roads must outlive the level. Roads that cross_sections() cannot draw must not be among them.
  RoadLevel(std::vector<const roadquery::Road*> roads, const Polygon& area, const RoadLevelOptions& options);

  /// Where roads overlap (junctions), the mean of their surfaces weighted by the distance to each road's own border and
  /// ends: equal to the one road's surface where there is one, and without a step where another one begins.
  /// Nothing when p is further than `sample_reach_m` from every road.
  [[nodiscard]] std::optional<SurfaceSample> sample(Vec2 p) const;
  [[nodiscard]] const std::vector<const roadquery::Road*>& roads() const { return roads_; }
  [[nodiscard]] const MultiPolygon& polygons() const { return polygons_; }  ///< union of the carriageways, in the area
  [[nodiscard]] const Outline& outline() const { return outline_; }         ///< of polygons(), heights of the surface
  [[nodiscard]] const std::vector<std::vector<CrossSection>>& strips() const { return strips_; }  ///< one a road

  static constexpr double sample_reach_m = 1.0;

 private:
  struct Piece {
    std::uint32_t road = 0, section = 0;  ///< between sections_[road][section] and the next
  };
  std::vector<const roadquery::Road*> roads_;
  std::vector<std::vector<CrossSection>> strips_;
  std::vector<Piece> pieces_;
  CellIndex piece_index_;
  MultiPolygon polygons_;
  Outline outline_;
};

}  // namespace orthodrive::scene
