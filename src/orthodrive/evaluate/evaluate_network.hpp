#pragma once
// What a road network in OpenDRIVE's terms is worth: its size, and the faults that a car would feel.

#include <cstddef>
#include <map>
#include <string>

#include "roadquery/road_map.hpp"

namespace orthodrive {

struct NetworkScores {
  std::size_t roads = 0;  ///< all, with the connecting roads of junctions
  std::size_t connecting_roads = 0;
  std::size_t junctions = 0;
  double length_m = 0.0;                        ///< of all roads
  std::map<std::string, std::size_t> elements;  ///< of the reference lines: line, arc, spiral, paramPoly3
  double max_gradient_kink =
      0.0;  ///< largest jump of dz/ds between the end of one elevation element and the start of the next
  double max_joint_gap_m = 0.0;  ///< largest distance between ends that should meet: elements of a road, linked roads
  std::size_t broken_links = 0;  ///< links to roads that are not there
  double min_clearance_m =
      0.0;  ///< smallest height between reference lines that cross on different layers; NaN without crossings
  std::size_t crossings = 0;
  double connected_share = 0.0;  ///< of the length, in the largest part that hangs together by links; NaN without roads
};

[[nodiscard]] NetworkScores evaluate_network(const roadquery::RoadMap& map);

}  // namespace orthodrive
