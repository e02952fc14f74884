#pragma once
// What a connecting road has from the roads that it connects where its file does not say it.

#include <string>

#include "roadquery/road_map.hpp"

namespace roadquery {

struct Inherited {
  std::string osm_id;            ///< of both roads, where it is the same
  std::string highway;           ///< of the road before
  double speed_limit_mps = 0.0;  ///< the lower one of both; 0: one of them has none
};

/// Nothing for a road outside junctions, or that is linked to no such road. The roads are sorted by id.
[[nodiscard]] Inherited inherited(const RoadMap& map, const Road& road);

}  // namespace roadquery
