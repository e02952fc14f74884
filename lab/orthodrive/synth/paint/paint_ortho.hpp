// SPDX-License-Identifier: Apache-2.0
#pragma once
// Light and colour: an aerial photo of the scene raster.

#include "orthodrive/geo/pixel_box.hpp"
#include "orthodrive/synth/paint/scene_raster.hpp"

namespace orthodrive::synth {

/// Sun, shadows, textures, lane markings, wear, the optics' blur and the sensor's noise. Colours and light vary with
/// the seed. 3 channels. Every pixel is a pure function of place and seed, so the result does not depend on threads.
/// `box`: the pixels of the site to paint. Where the scene is a window, it must reach shadow_reach_m beyond the box,
/// but for two pixels in the north: the sun stands in the south.
[[nodiscard]] Raster<std::uint8_t> paint_ortho(const SceneSource& source, const SceneRaster& scene, const PixelBox& box,
                                               int threads);

/// No shadow is longer: objects and decks stand less than 26 m over the ground, whose slopes against the sun stay below
/// 0.4, and the sun is 36 degrees high at least: 26 m / (0.72 - 0.4).
constexpr double shadow_reach_m = 82.0;

}  // namespace orthodrive::synth
