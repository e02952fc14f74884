// SPDX-License-Identifier: Apache-2.0
#pragma once
// The surface of a junction in the words of OpenDRIVE 1.8: <boundary> (12.10) and <elevationGrid> (12.11).

#include <vector>

#include "roadquery/map/road_map.hpp"

namespace orthodrive::io {

/// One <segment> of a boundary: across the end of a road that leads into the junction, or along a whole kerb.
struct BoundarySegment {
  bool joint = false;
  int road = 0;                                                      ///< the arm, or the kerb's own road
  roadquery::ContactPoint contact = roadquery::ContactPoint::start;  ///< of a joint: which end of the arm
};

/// The ring of a surface, cut where it runs along the arms. What lies between them becomes roads without lanes: no
/// lane's edge runs along a kerb with corners and islands, and 12.10 closes gaps with new roads.
struct JunctionBoundary {
  std::vector<BoundarySegment> segments;  ///< counter-clockwise
  std::vector<roadquery::Road> kerbs;     ///< reference line on the ring, lines only; heights of the surface
};

/// One for each junction; without segments for those without a surface. Roads, junctions and their arms (join_arms) as
/// written. Kerbs get ids after those of roads and junctions. An arm that the ring does not run along has no joint. Of
/// several pieces along one arm the longest is its joint.
[[nodiscard]] std::vector<JunctionBoundary> junction_boundaries(const roadquery::RoadMap& map);

}  // namespace orthodrive::io
