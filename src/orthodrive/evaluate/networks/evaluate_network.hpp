// SPDX-License-Identifier: Apache-2.0
#pragma once
// What a road network in OpenDRIVE's terms is worth: its size, and the faults that a car would feel.

#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include "roadquery/map/road_map.hpp"

namespace orthodrive {

/// A place where two reference lines cross on different layers.
struct Overpass {
  int upper_road = 0, lower_road = 0;      ///< by height, ids of the file
  std::string upper_osm_id, lower_osm_id;  ///< empty: a connecting road between two ways
  std::string upper_highway, lower_highway;
  int upper_layer = 0, lower_layer = 0;
  bool bridge = false;  ///< the upper road
  double x = 0.0, y = 0.0;
  double clearance_m = 0.0;  ///< between the reference lines, upper - lower
};

/// A lane that ends in nothing.
struct LaneEnd {
  int road = 0, lane = 0;
  double x = 0.0, y = 0.0;
};

struct NetworkScores {
  std::size_t roads = 0;  ///< all, with the connecting roads of junctions
  std::size_t connecting_roads = 0;
  std::size_t junctions = 0;
  double length_m = 0.0;                        ///< of all roads
  std::map<std::string, std::size_t> elements;  ///< of the reference lines: line, arc, spiral, paramPoly3
  double road_length_m = 0.0;                   ///< of the roads outside junctions
  std::size_t road_elements = 0;                ///< elements of their reference lines
  double mean_road_element_m = 0.0;             ///< road_length_m / road_elements; NaN without roads
  /// Largest jump of dz/ds between elements of the elevation and between linked roads, in driving direction.
  double max_gradient_kink = 0.0;
  /// Largest jump of the heading between elements of a reference line and between linked roads.
  double max_heading_jump_rad = 0.0;
  /// Largest jump of the curvature between elements of reference lines and between linked roads, 1/m; outside
  /// junctions.
  double max_curvature_jump = 0.0;
  double max_curvature_rate = 0.0;  ///< of clothoids and cubics of reference lines outside junctions, 1/m2
  double max_joint_gap_m = 0.0;  ///< largest distance between ends that should meet: elements of a road, linked roads
  std::size_t broken_links =
      0;  ///< links to roads or junctions that are not there, or that the other side does not answer
  /// Lanes that are linked to a lane that is not there, not of their type, or that leads the other way; lane links of
  /// junctions that the lanes of the connecting road do not repeat.
  std::size_t lane_link_errors = 0;
  std::size_t dead_lanes =
      0;  ///< driving lanes that end, wider than 1 cm, at a joint or junction where nothing is linked to them
  std::vector<LaneEnd> dead_lane_places;
  double min_lane_width_m = 0.0;  ///< of driving lanes where they are widest (start, middle or end); NaN without any
  double min_clearance_m = 0.0;  ///< smallest height between reference lines that cross on different layers, or a metre
                                 ///< and more apart; NaN without
  std::size_t crossings = 0;
  std::vector<Overpass> crossing_places;  ///< by clearance, smallest first
  double connected_share = 0.0;  ///< of the length, in the largest part that hangs together by links; NaN without roads
};

[[nodiscard]] NetworkScores evaluate_network(const roadquery::RoadMap& map);

}  // namespace orthodrive
