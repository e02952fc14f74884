// SPDX-License-Identifier: Apache-2.0
#pragma once
// What of other roads and of junctions lies over a place of a road.

#include <vector>

#include "orthodrive/geo/polygon.hpp"
#include "orthodrive/geo/spatial_index.hpp"
#include "orthodrive/network/junctions/road_cover.hpp"

namespace orthodrive::network {

/// Only what lies on the place's level counts. The map must outlive the index and stay as it is.
class RoadsOver {
 public:
  explicit RoadsOver(const roadquery::RoadMap& map);

  /// The carriageway of a road outside junctions other than `own_road` (an index) and those that it goes on into.
  [[nodiscard]] bool is_carriageway(const roadquery::SurfacePoint& p, std::size_t own_road) const;
  /// A connecting road, or the area of a junction.
  [[nodiscard]] bool is_junction(const roadquery::SurfacePoint& p) const;

 private:
  [[nodiscard]] bool is_covered(const roadquery::SurfacePoint& p, std::size_t own_road, bool connecting) const;

  const roadquery::RoadMap& map_;
  Vec2 origin_;
  std::vector<RoadCover> covers_;
  std::vector<const roadquery::JunctionSurface*> surfaces_;
  SpatialIndex road_index_, surface_index_;
};

}  // namespace orthodrive::network
