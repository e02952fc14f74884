// SPDX-License-Identifier: Apache-2.0
#pragma once
// Where trees are, and how wide: crowns in the photo's vegetation.

#include <vector>

#include "orthodrive/model/rasters/rasters.hpp"

namespace orthodrive::scene {

struct TreeCrown {
  Vec2 at;  ///< site CRS
  double radius_m = 0.0;
};

/// Crowns of 1.6 to 5 m in the labels of the role vegetation, on a grid of 1 m: largest first, each at a local maximum
/// of cover and brightness over its size (the sunlit tops of a wood are bright, the gaps between them dark; a tree that
/// stands alone is found by its cover), where the disc is vegetation by 85 %. Crowns may overlap by a fifth of their
/// radii, so that woods close. By size, then row, then column. The same for the same pixels, whatever else is in the
/// map.
[[nodiscard]] std::vector<TreeCrown> find_crowns(const LabelMap& labels, const Photo& photo);

}  // namespace orthodrive::scene
