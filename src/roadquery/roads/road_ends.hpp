// SPDX-License-Identifier: Apache-2.0
#pragma once
// Roads by id, their ends and the lanes there.

#include <cstddef>
#include <optional>
#include <unordered_map>

#include "roadquery/map/road_map.hpp"

namespace roadquery {

struct RoadEnd {
  const Road* road = nullptr;
  ContactPoint contact = ContactPoint::start;
  [[nodiscard]] double s() const { return contact == ContactPoint::start ? 0.0 : road->length; }
  [[nodiscard]] const LaneSection& section() const {
    return contact == ContactPoint::start ? road->sections.front() : road->sections.back();
  }
  /// Of the road, at this end.
  [[nodiscard]] const RoadLink& link() const {
    return contact == ContactPoint::start ? road->predecessor : road->successor;
  }
};

/// Null where the section has no such lane beside its centre.
[[nodiscard]] inline const Lane* find_lane(const LaneSection& section, int id) {
  for (const auto* side : {&section.left, &section.right})
    for (const Lane& lane : *side)
      if (lane.id == id) return &lane;
  return nullptr;
}

/// Indices of a map's roads. Of two with one id it is the first.
class RoadsById {
 public:
  explicit RoadsById(const RoadMap& map) {
    index_.reserve(map.roads.size());
    for (std::size_t i = 0; i < map.roads.size(); ++i) index_.emplace(map.roads[i].id, i);
  }
  [[nodiscard]] std::optional<std::size_t> find(int id) const {
    const auto at = index_.find(id);
    return at == index_.end() ? std::nullopt : std::optional(at->second);
  }

 private:
  std::unordered_map<int, std::size_t> index_;
};

}  // namespace roadquery
