// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/model/roads/road_barriers.hpp"

#include <algorithm>
#include <array>

namespace orthodrive {
namespace {

constexpr bool closing = true;

// Which ones keep cars out: the wiki's column of what each barrier implies for access. Sizes are usual ones.
constexpr std::array barriers{RoadBarrier{"bollard", "obstacle", 0.15, 0.15, 0.9, closing},
                              RoadBarrier{"block", "obstacle", 0.6, 1.5, 0.6, closing},
                              RoadBarrier{"jersey_barrier", "obstacle", 0.6, 0.0, 0.8, closing},
                              RoadBarrier{"planter", "obstacle", 1.0, 1.5, 0.8, closing},
                              RoadBarrier{"log", "obstacle", 0.5, 0.0, 0.5, closing},
                              RoadBarrier{"debris", "obstacle", 2.0, 0.0, 1.0, closing},
                              RoadBarrier{"wedge", "obstacle", 1.0, 0.0, 0.5, closing},
                              RoadBarrier{"cycle_barrier", "obstacle", 1.5, 0.0, 1.0, closing},
                              RoadBarrier{"motorcycle_barrier", "obstacle", 0.5, 0.0, 1.0, closing},
                              RoadBarrier{"horse_stile", "obstacle", 0.5, 0.0, 0.5, closing},
                              RoadBarrier{"stile", "obstacle", 0.5, 0.0, 1.0, closing},
                              RoadBarrier{"kissing_gate", "obstacle", 1.0, 0.0, 1.2, closing},
                              RoadBarrier{"turnstile", "obstacle", 1.0, 0.0, 1.0, closing},
                              RoadBarrier{"full-height_turnstile", "obstacle", 1.0, 0.0, 2.2, closing},
                              RoadBarrier{"chain", "obstacle", 0.05, 0.0, 0.7, closing},
                              RoadBarrier{"rope", "obstacle", 0.05, 0.0, 0.7, closing},
                              RoadBarrier{"wall", "obstacle", 0.3, 0.0, 1.5, closing},
                              RoadBarrier{"fence", "obstacle", 0.1, 0.0, 1.2, closing},
                              RoadBarrier{"hedge", "obstacle", 0.6, 0.0, 1.2, closing},
                              RoadBarrier{"guard_rail", "obstacle", 0.3, 0.0, 0.75, closing},
                              RoadBarrier{"gate", "barrier", 0.1, 0.0, 1.2},
                              RoadBarrier{"swing_gate", "barrier", 0.1, 0.0, 1.0},
                              RoadBarrier{"sliding_gate", "barrier", 0.1, 0.0, 1.8},
                              RoadBarrier{"lift_gate", "barrier", 0.1, 0.0, 1.0},
                              RoadBarrier{"hampshire_gate", "barrier", 0.1, 0.0, 1.2},
                              RoadBarrier{"bump_gate", "barrier", 0.1, 0.0, 1.2},
                              RoadBarrier{"bus_trap", "obstacle", 2.0, 0.0, 0.0, closing},
                              RoadBarrier{"sump_buster", "obstacle", 1.0, 0.0, 0.2, closing},
                              RoadBarrier{"height_restrictor", "gantry", 0.2, 0.0, 2.5},
                              RoadBarrier{"toll_booth", "gantry", 4.0, 0.0, 5.0},
                              RoadBarrier{"border_control", "gantry", 4.0, 0.0, 5.0},
                              RoadBarrier{"cattle_grid", "barrier", 2.5, 0.0, 0.0},
                              RoadBarrier{"coupure", "barrier", 0.5, 0.0, 0.0},
                              RoadBarrier{"spikes", "barrier", 0.3, 0.0, 0.1}};
constexpr RoadBarrier other_barrier{};

}  // namespace

const RoadBarrier& road_barrier(std::string_view value) {
  const auto found = std::ranges::find(barriers, value, &RoadBarrier::value);
  return found == barriers.end() ? other_barrier : *found;
}

}  // namespace orthodrive
