// SPDX-License-Identifier: Apache-2.0
#pragma once
// The picture that trees are drawn with: a quarter each of bark and dense leaves, of two clusters of leaves with holes
// between them, and of a twig with needles.

#include <cstdint>

#include "orthodrive/geo/raster.hpp"

namespace orthodrive::scene {

/// A part of the picture, in its sides; v runs down. A little smaller than what is painted: nothing of its neighbours
/// shows from afar.
struct PictureBox {
  double u0 = 0.0, v0 = 0.0, u1 = 0.0, v1 = 0.0;
};
constexpr PictureBox dense_leaves_box{0.02, 0.02, 0.23, 0.48}, bark_box{0.27, 0.02, 0.48, 0.48};
/// Round, transparent towards the corners.
constexpr PictureBox broad_leaves_box{0.5, 0.0, 1.0, 0.5}, small_leaves_box{0.0, 0.5, 0.5, 1.0};
/// A twig from the middle of the left side to that of the right one.
constexpr PictureBox needles_box{0.5, 0.5, 1.0, 1.0};

/// sRGB and opacity (0 or 255), size_px a side, the same each time. Grey with a slight change of hue from leaf to leaf;
/// the mean of each linear channel of what is opaque is surface_texture_mean within 0.02.
[[nodiscard]] Raster<std::uint8_t> leaf_picture(int size_px);

}  // namespace orthodrive::scene
