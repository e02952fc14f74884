// SPDX-License-Identifier: Apache-2.0
#pragma once
// The reference line of a connecting road that turns.

#include <vector>

#include "orthodrive/network/line/chain_geometry.hpp"

namespace orthodrive::network {

/// A part of a chain as it is driven: from s0 to s1, against the chain where s1 < s0.
struct Leg {
  ChainIndex chain;
  double s0 = 0.0, s1 = 0.0;
};

/// The line along the legs, each of which begins where the one before ends. It leaves a leg and enters the next one
/// within `turn_reach_m` of where they meet, further off where the turn would be sharper than 12 m or, up to 35
/// degrees, has to be driven at `speed_mps` with no more than 1.5 m/s2 sideways: each turn is turn(). The first and
/// last 4 m lie on the legs where a turn of 6 m to each side keeps room. Short legs between two others are part of one
/// turn. Where roads are cut back far, the line so keeps to the carriageways instead of crossing what lies between
/// them.
[[nodiscard]] std::vector<roadquery::PlanElement> connecting_line(const ChainGeometries& geometry,
                                                                  std::vector<Leg> legs, double speed_mps);

/// turn(), with the digits that differences of UTM coordinates lose.
[[nodiscard]] std::vector<roadquery::PlanElement> turn_from(const Pose& from, const Pose& to);

}  // namespace orthodrive::network
