// SPDX-License-Identifier: Apache-2.0
#pragma once
// What a connecting road has from the roads that it connects where its file does not say it.

#include <optional>
#include <string>

#include "roadquery/map/road_map.hpp"

namespace roadquery {

struct Inherited {
  std::string osm_id;            ///< of both roads, where it is the same
  std::string highway;           ///< of the road before
  double speed_limit_mps = 0.0;  ///< the lower one of both where they meet it; 0: one has none; infinity: "no limit"
  /// Of all driving lanes of the road before, where its friction is 1: what other readers assume without.
  std::optional<LaneMaterial> material;
};

/// Nothing for a road outside junctions, or that is linked to no such road. The roads are sorted by id.
[[nodiscard]] Inherited inherited(const RoadMap& map, const Road& road);

/// Whether a lane of a connecting road has what it would inherit.
[[nodiscard]] bool has_inherited_material(const Lane& lane, const Inherited& from);

}  // namespace roadquery
