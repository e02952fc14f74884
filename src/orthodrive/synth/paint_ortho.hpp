#pragma once
// Light and colour: an aerial photo of the scene raster.

#include "orthodrive/synth/scene_raster.hpp"

namespace orthodrive::synth {

/// Sun, shadows, textures, lane markings, wear, the optics' blur and the sensor's noise. Colours and light vary with
/// the seed. 3 channels. Every pixel is a pure function of place and seed, so the result does not depend on threads.
[[nodiscard]] Raster<std::uint8_t> paint_ortho(const SceneSource& source, const SceneRaster& scene, int threads);

}  // namespace orthodrive::synth
