#pragma once
// The unknown heights of a network: one for every place, shared by the paths that meet there.

#include <cstddef>
#include <vector>

#include "orthodrive/elevate/estimate_profiles.hpp"

namespace orthodrive {

struct HeightUnknowns {
  std::vector<std::vector<std::size_t>> of_node;  ///< [path][node] -> unknown
  std::vector<Vec2> p;                            ///< [unknown]
  std::vector<double> terrain_m;                  ///< [unknown] sampled terrain, NaN where there is none
  std::vector<bool> measured;                     ///< [unknown] the terrain is the road: has a height and no bridge or tunnel
  std::vector<double> start_m;                    ///< [unknown] terrain; interpolated along the path where not measured
  std::vector<std::vector<std::size_t>> components;  ///< paths that hang together, ascending; ordered by their first path
  double coarsest_gsd_m = 0.0;                    ///< of the terrain models in use

  [[nodiscard]] std::size_t size() const { return p.size(); }
};

/// Throws OptionError when no node at all has a terrain height.
[[nodiscard]] HeightUnknowns gather_height_unknowns(const RoadNetwork& roads, const std::vector<HeightGrid>& dtms, HeightSampling sampling);

}  // namespace orthodrive
