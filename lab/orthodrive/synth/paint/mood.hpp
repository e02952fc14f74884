// SPDX-License-Identifier: Apache-2.0
#pragma once
// Light and colours of one photo: what differs from one site to the next.

#include <cstdint>

#include "orthodrive/synth/paint/world.hpp"

namespace orthodrive::synth {

struct Mood {
  double sun_azimuth_rad = 0.0, sun_elevation_rad = 0.0;
  Rgb ambient{}, direct{};
  Rgb grass{}, dry{}, foliage{}, conifer{}, forest_floor{}, soil{}, water{};
  float dryness = 0.12f;
  float asphalt = 0.0f, asphalt_spread = 0.0f;
  float haze = 0.0f, contrast = 1.0f, gain = 1.0f, noise_sigma = 0.0f;
  float blur = 0.25f;  ///< weight of each neighbour in a row or column
  Rgb haze_color{1.0f, 1.0f, 1.0f}, tint{1.0f, 1.0f, 1.0f};
  float new_asphalt = 0.0f, old_asphalt = 0.0f, concrete = 0.0f;  ///< tones
  Rgb gravel{}, dirt{};
  bool yellow_center = false;
  float paint = 1.0f;  ///< how much of road markings is left
};

/// Without a world: the Central European summer of the plain sites.
[[nodiscard]] Mood make_mood(std::uint64_t seed, const World* world);

}  // namespace orthodrive::synth
