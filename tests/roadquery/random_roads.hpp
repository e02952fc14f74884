// SPDX-License-Identifier: Apache-2.0
#pragma once
// Random roads as they should be read, with what some spellings need to know of them.

#include <optional>
#include <vector>

#include "roadquery/dice.hpp"
#include "roadquery/map/road_map.hpp"

namespace roadquery::test {

/// From s on a half of the cross section falls outwards by this slope.
struct CrossfallStep {
  double s = 0.0, left = 0.0, right = 0.0;
};

/// Strips of a <crossSectionSurface> whose edges are straight and whose heights are linear in s.
struct RandomStrips {
  double t_offset = 0.0;
  struct Strip {
    int id = 0;
    bool relative = false;
    double width = 0.0;    ///< of inner strips beside outer ones; 0: not given
    Cubic height[4] = {};  ///< a + b s of the constant, linear, quadratic and cubic part
  };
  std::vector<Strip> strips;
};

struct RandomRoad {
  Road road;
  std::vector<std::optional<Cubic>> poly3;  ///< of each plan element: v of u, where it may be a <poly3>
  std::vector<CrossfallStep> crossfall;     ///< where not empty, road.shape says the same
  std::optional<RandomStrips> strips;       ///< where given, road.shape says the same
  std::vector<int> kept_side;               ///< of each section: 1 left, -1 right goes on from the one before, 0 none
  bool has_level = false;                   ///< lanes with level="true", not yet in their heights
};

struct RandomMap {
  std::vector<RandomRoad> roads;  ///< the last ones are of junctions
  std::vector<Junction> junctions;
};

/// Roads far from each other, of all kinds of geometry, profiles, lanes, objects and links. Names are unique, ids
/// small.
[[nodiscard]] RandomMap random_map(unsigned seed, int roads);

/// The cubic that holds at s, begun there.
[[nodiscard]] Cubic begun_at(const std::vector<Cubic>& cubics, double s);

}  // namespace roadquery::test
