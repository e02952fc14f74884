// SPDX-License-Identifier: Apache-2.0
#pragma once
// Roads by id and their ends, for the .cpp files of this folder.

#include <cstddef>
#include <optional>
#include <unordered_map>

#include "roadquery/map/road_map.hpp"
#include "roadquery/surface/road_surface.hpp"

namespace orthodrive::evaluate {

struct RoadEnd {
  const roadquery::Road* road = nullptr;
  roadquery::ContactPoint contact = roadquery::ContactPoint::start;
  [[nodiscard]] double s() const { return contact == roadquery::ContactPoint::start ? 0.0 : road->length; }
  [[nodiscard]] const roadquery::LaneSection& section() const {
    return contact == roadquery::ContactPoint::start ? road->sections.front() : road->sections.back();
  }
  /// Of the road, at this end.
  [[nodiscard]] const roadquery::RoadLink& link() const {
    return contact == roadquery::ContactPoint::start ? road->predecessor : road->successor;
  }
};

/// Null where the section has no such lane beside its centre.
[[nodiscard]] const roadquery::Lane* find_lane(const roadquery::LaneSection& section, int id);

/// Inner border of a lane at the end of its road.
[[nodiscard]] roadquery::SurfacePoint inner_border(const RoadEnd& end, int lane_id);

class RoadsById {
 public:
  explicit RoadsById(const roadquery::RoadMap& map) {
    for (std::size_t i = 0; i < map.roads.size(); ++i) index_.emplace(map.roads[i].id, i);
  }
  [[nodiscard]] std::optional<std::size_t> find(int id) const {
    const auto at = index_.find(id);
    return at == index_.end() ? std::nullopt : std::optional(at->second);
  }

 private:
  std::unordered_map<int, std::size_t> index_;
};

}  // namespace orthodrive::evaluate
