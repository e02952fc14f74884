// SPDX-License-Identifier: Apache-2.0
#pragma once
// Which road of a map a place of the network lies on.

#include <functional>
#include <optional>
#include <vector>

#include "orthodrive/geo/spatial_index.hpp"
#include "orthodrive/model/roads/road_network.hpp"
#include "roadquery/map/road_map.hpp"

namespace orthodrive::network {

/// A place beside a road's reference line.
struct RoadFoot {
  std::size_t road = 0;
  double s = 0.0, t = 0.0;
};

/// Which reference lines run near a place. The map must outlive it, and keep its roads.
class LineFinder {
 public:
  explicit LineFinder(const roadquery::RoadMap& map);

  /// The nearest line within 4 m that runs along `direction` or against it, within 30 degrees; of two as near the
  /// first.
  [[nodiscard]] std::optional<RoadFoot> find(Vec2 p, Vec2 direction,
                                             const std::function<bool(const roadquery::Road&)>& accept) const;

 private:
  struct Part {
    std::size_t road;
    double s;
  };
  const roadquery::RoadMap& map_;
  std::vector<Part> parts_;
  SpatialIndex index_;
};

/// Of a path, at a node.
[[nodiscard]] Vec2 direction_at(const RoadPath& path, std::size_t node);

}  // namespace orthodrive::network
