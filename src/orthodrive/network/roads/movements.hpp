// SPDX-License-Identifier: Apache-2.0
#pragma once
// From which end of a junction to which other one one drives, and on which lanes.

#include <cstddef>
#include <set>
#include <vector>

#include "orthodrive/core/finding.hpp"
#include "orthodrive/network/roads/gates.hpp"
#include "orthodrive/network/roads/inner_ways.hpp"

namespace orthodrive::network {

/// How one drives from one end to another, by lanes counted from the inside (0 = innermost).
struct Movement {
  int from = 0, to = 0;  ///< indices of ends
  double turn_rad = 0.0;
  std::size_t first_in = 0, count_in = 0, first_out = 0, count_out = 0;
  bool turned = false;    ///< only by turning round inside the junction
  std::vector<Leg> legs;  ///< inner ways between the vertices of both ends
};

/// All of a junction. `in`, `out`: gates of its ends, into and out of it; `inside`: its inner ways. `followed` collects
/// restrictions over ways that one has come over. Findings network.turn_left_out, network.no_room_to_turn.
[[nodiscard]] std::vector<Movement> movements_of(const NetworkPlan& plan, const TurnRules& rules,
                                                 const std::vector<InnerWay>& inside,
                                                 const std::vector<JunctionEnd>& ends, const std::vector<Gate>& in,
                                                 const std::vector<Gate>& out, std::set<std::size_t>& followed,
                                                 Findings& findings);

}  // namespace orthodrive::network
