// SPDX-License-Identifier: Apache-2.0
#pragma once
// Measured roughness of ways as a height to add to the roads of a network: what CrgFilesOptions::relief_of takes.

#include <functional>
#include <memory>
#include <vector>

#include "orthodrive/model/roads/road_network.hpp"
#include "orthodrive/model/roads/road_roughness.hpp"
#include "roadquery/map/road_map.hpp"

namespace orthodrive {

/// A realisation of the measured spectra, the same for the same roads: logs tell how rough a road is, not where each
/// bump lies. Roads of one way lie in one surface, so that nothing steps where the way is cut; a connecting road from
/// way to way goes over from the one's to the other's. Roads whose way nobody drove get an empty function.
class RoadRelief {
 public:
  using Height = std::function<double(double s, double t)>;

  /// Waves shorter than `shortest_wave_m` are left out: those that a grid with steps of half of it cannot hold.
  RoadRelief(const RoadNetwork& roads, const std::vector<RoughnessStretch>& roughness, double shortest_wave_m);

  /// At (s, t) of the road. `map` is what was built of the roads.
  [[nodiscard]] Height of(const roadquery::RoadMap& map, const roadquery::Road& road) const;

 private:
  struct Way {
    std::int64_t osm_id = 0;
    Polyline line;
    std::vector<double> s_m;
    RoughnessField field;
  };
  [[nodiscard]] std::shared_ptr<const Way> way_of(const roadquery::Road& road) const;
  [[nodiscard]] static Height along(const std::shared_ptr<const Way>& way, const roadquery::Road& road);
  std::vector<std::shared_ptr<const Way>> ways_;  ///< by osm_id, then part
};

}  // namespace orthodrive
