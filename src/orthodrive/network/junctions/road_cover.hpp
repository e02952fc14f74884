// SPDX-License-Identifier: Apache-2.0
#pragma once
// What a road, or a part of it, covers in plan, and where on it a place lies.

#include <optional>
#include <vector>

#include "orthodrive/geo/polygon.hpp"
#include "roadquery/surface/road_surface.hpp"

namespace orthodrive::network {

/// Coordinates are relative to `origin` (those of UTM cost digits). The road must outlive the cover.
class RoadCover {
 public:
  RoadCover(const roadquery::Road& road, Vec2 origin, double s0, double s1);

  struct Place {
    double s = 0.0, t = 0.0;
  };
  /// Where p lies on the road: nothing beside it or beyond the part's ends. With sidewalks only if asked for.
  [[nodiscard]] std::optional<Place> find(Vec2 p, bool with_sidewalks) const;
  /// Height of the surface at a place found.
  [[nodiscard]] double height(const Place& place) const;
  /// Pieces that together are what the road covers inside the box: cross sections a metre apart, joined to one ring as
  /// long as they do not fold over each other in a bend and turn by less than a right angle.
  [[nodiscard]] std::vector<Polygon> pieces(bool with_sidewalks, const Box2& box) const;
  [[nodiscard]] const Box2& bounds() const { return bounds_; }  ///< of the whole width
  [[nodiscard]] const roadquery::Road& road() const { return *road_; }

 private:
  [[nodiscard]] roadquery::Edges edges(double s, bool with_sidewalks) const;
  const roadquery::Road* road_;
  Vec2 origin_;
  std::vector<double> s_;
  std::vector<roadquery::PlanPoint> reference_;  ///< of the road at s_
  std::vector<Vec2> line_;                       ///< of the reference line at s_
  Box2 bounds_;
  double reach_m_ = 0.0;  ///< no place of the road is further from the sample nearest to it
};

}  // namespace orthodrive::network
