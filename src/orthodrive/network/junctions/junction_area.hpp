// SPDX-License-Identifier: Apache-2.0
#pragma once
// The paved area of a junction in plan: where the height field of the junction is the surface.

#include <span>
#include <string>
#include <vector>

#include "orthodrive/network/junctions/road_cover.hpp"

namespace orthodrive::network {

/// Of the arms, outwards from the junction, beside which an area can lie: more than the largest kerb radius.
constexpr double arm_reach_m = 25.0;

/// A road as its junction sees it.
struct JunctionRoads {
  std::vector<const roadquery::Road*> connecting;
  /// Ends of roads at the junction: the end (else the start) of arm_roads[i] touches it.
  std::vector<const roadquery::Road*> arms;
  std::vector<bool> at_end;
  /// Others that the area must not cover: nearby on the same level, their connecting roads too.
  std::vector<const roadquery::Road*> others;
  std::vector<Polygon> paved = {};  ///< what is paved besides, where no arm and no other road lies; relative to origin
};

/// Radius of the kerb at the corners: by the class of the third arm from the top, the side road of a T or a crossing.
/// Primary and higher 12 m, down to tertiary 8 m (RASt 06, FGSV 2006, p. 123: main arc of 12 m for turning out of main
/// streets, 8 m for turning into them); residential streets 5 m and accesses 3 m, where RASt asks only that cars get
/// round.
[[nodiscard]] double kerb_radius_m(std::vector<std::string> highways);

/// Union of the carriageways of the connecting roads, closed by a disc of the kerb radius together with the arms
/// (dilated by it, then eroded by it): corners get an arc of that radius, gores and gaps narrower than its diameter are
/// filled; with what is paved besides. Less the arms and the other roads, and at least the connecting roads. Overlaps
/// the arms' ends by 1 cm. Counter-clockwise outer rings, relative to `origin`; empty without connecting roads.
[[nodiscard]] MultiPolygon junction_area(const JunctionRoads& roads, double kerb_radius_m, Vec2 origin);

/// One ring for a whole set: runs from ring to ring and back along the same line, so that a place lies inside by the
/// even-odd rule exactly if it does so for the set. The outer ring of a single polygon without holes stays as it is.
[[nodiscard]] Ring woven_ring(const MultiPolygon& polygons);

}  // namespace orthodrive::network
