// SPDX-License-Identifier: Apache-2.0
#pragma once
// How fast this machine is at the kind of work that a build is made of, so that costs measured on one machine can be
// told for another.

namespace orthodrive {

/// Seconds of one piece of work, the least of a few tries: sums of products on a picture that fits the cache, samples
/// at random places of one that does not, and sorting.
struct MachineSpeed {
  double seconds_of_one = 0.0;  ///< one thread alone does one piece
  double seconds_of_all = 0.0;  ///< `threads` do one piece each, all at once
  int threads = 0;
};

/// Takes about half a second. `threads`: 0 = all cores. What else runs meanwhile counts: its time is lost to a build,
/// too.
[[nodiscard]] MachineSpeed measure_machine_speed(int threads = 0);

}  // namespace orthodrive
