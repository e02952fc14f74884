// SPDX-License-Identifier: Apache-2.0
#pragma once
// Roads that cross without meeting: which of them passes over the other.

#include <vector>

#include "orthodrive/core/finding.hpp"
#include "orthodrive/elevate/terrain/terrain_samples.hpp"
#include "orthodrive/roads/path_crossings.hpp"

namespace orthodrive::elevate {

struct GradeSeparation {
  PathCrossing crossing;
  bool a_is_above = false;
  bool raise = true;  ///< the upper road gives way (a bridge), else the lower one (a tunnel)
  bool has_room =
      true;  ///< the roads do not meet within 50 m along the network: no ramp gains the clearance on so little
  bool is_measured = false;  ///< a control point says how high: nothing is moved for the clearance
  bool untagged = false;     ///< the one that gives way is neither tagged as bridge nor as tunnel
  bool is_along = false;     ///< a place where the roads lie above each other along their length

  [[nodiscard]] std::size_t upper() const { return a_is_above ? crossing.path_a : crossing.path_b; }
  [[nodiscard]] std::size_t lower() const { return a_is_above ? crossing.path_b : crossing.path_a; }
};

/// By layer, then by the tags bridge and tunnel, then by the terrain: it dips below the road that passes over, as decks
/// are not in it. Where it says nothing either, motorways and trunk roads are passed over by the others, as they are
/// never crossed at grade. What was not tagged is reported: "elevate.assumed_bridge". Left out are crossings that the
/// map merely lacks a node at: roads that meet within 50 m along the network (their lines overlap there); ends that
/// reach over a road by no more than its half width and 5 m, and crossings of which neither tags nor terrain nor class
/// show two levels (both "elevate.missing_junction").
/// After them places every 10 m where carriageways of two layers lie above each other along their length (is_along),
/// but for those of roads that part there (parting at 2 degrees or more, from a common node).
[[nodiscard]] std::vector<GradeSeparation> find_grade_separations(const RoadNetwork& roads,
                                                                  const TerrainSamples& terrain, Findings& findings);

/// The part of the upper (or lower) road that is bridge (tunnel) without being tagged so.
[[nodiscard]] std::vector<Span> untagged_spans(const RoadNetwork& roads, const std::vector<GradeSeparation>& levels);

}  // namespace orthodrive::elevate
