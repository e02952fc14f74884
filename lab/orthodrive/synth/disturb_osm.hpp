// SPDX-License-Identifier: Apache-2.0
#pragma once
// The truth as a mapper would have drawn it, and the truth itself, way by way with the same ids.

#include <cstdint>

#include "orthodrive/model/roads/osm_data.hpp"
#include "orthodrive/model/roads/road_network.hpp"
#include "orthodrive/synth/ground/site_objects.hpp"
#include "orthodrive/synth/ground/terrain.hpp"

namespace orthodrive::synth {

/// A piece of a planned road that is one way in OSM: roads are cut at the ends of bridges.
struct PlannedWay {
  std::int64_t osm_id = 0;
  std::size_t road = 0;
  double s_begin_m = 0.0, s_end_m = 0.0;
  bool bridge = false;
  bool given = false;  ///< its OSM way is there
  struct Stop {
    double s_m = 0.0;
    std::int64_t osm_node = 0;
  };
  std::vector<Stop> stops;  ///< both ends and the junctions between, ascending; ids are shared with other ways
};
[[nodiscard]] std::vector<PlannedWay> plan_ways(const SitePlan& plan);

struct DisturbOptions {
  double offset_min_m = 0.0, offset_max_m = 0.0;
  std::uint64_t seed = 0;
};
/// OSM of the site in local metres, given ways as they are. Of the others nodes are moved by a smooth field (correlated
/// over about 100 m) and set 15 - 40 m apart (closer in bends), few width and lanes tags; junctions shared. Buildings
/// and areas are moved by a third of that. Ways come in the order of `ways`.
[[nodiscard]] OsmData disturb_osm(const SitePlan& plan, const std::vector<PlannedWay>& ways, const SiteObjects& objects,
                                  const DisturbOptions& options);

/// The exact roads inside [0, size]^2 with a node a metre, in local metres.
[[nodiscard]] RoadNetwork true_roads(const SitePlan& plan, const Terrain& terrain, const std::vector<PlannedWay>& ways,
                                     const OsmData& osm);

}  // namespace orthodrive::synth
