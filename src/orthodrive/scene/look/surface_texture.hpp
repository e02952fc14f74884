// SPDX-License-Identifier: Apache-2.0
#pragma once
// Tileable textures of road surfaces, made of seeded noise. Near the eye they show what a photo of decimetres cannot.

#include "orthodrive/model/scene.hpp"

namespace orthodrive::scene {

/// Edge of a texture on the ground. Tiles of the scene are whole multiples of it, so that textures go on across them.
constexpr double surface_texture_m = 4.0;
/// Length of the texture along a lane (SurfaceMaterial::lane), which is as wide as the lane; its up is the road's s.
constexpr double lane_texture_m = 14.0;
/// Mean of the textures' linear values: colours of a mesh are divided by it.
constexpr double surface_texture_mean = 0.6;

/// A picture of size_px (a power of two, at least 64) a side, the same for the same material and size. Grey but for a
/// slight change of hue between stones; the mean of each linear channel is surface_texture_mean within 0.01. That of
/// leaves (leaf_picture) has half as many pixels a side. Not for SurfaceMaterial::photo.
[[nodiscard]] SurfaceTexture make_surface_texture(SurfaceMaterial material, int size_px = 1024);

}  // namespace orthodrive::scene
