// SPDX-License-Identifier: Apache-2.0
#pragma once
// What asphalt, concrete, setts, gravel and dirt look like from above: pure functions of place and seed.

#include "orthodrive/synth/paint/mood.hpp"

namespace orthodrive::synth {

struct PavedPlace {
  Vec2 p;
  double s_m = 0.0, t_m = 0.0;  ///< along and across the road, from its middle
  double width_m = 0.0;
  double lane_m = 0.0;  ///< from the middle of the road to the middle of a lane
  float edge_m = 0.0f;  ///< from the edge of the carriageway, negative inside
  int road = 0;
  double pixel_m = 0.5;
};
[[nodiscard]] Rgb pavement_color(Pavement pavement, const PavedPlace& at, const Mood& mood, std::uint32_t seed);

}  // namespace orthodrive::synth
