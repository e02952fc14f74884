// SPDX-License-Identifier: Apache-2.0
#pragma once
// How far one terrain model lies above another: a constant over two vertical datums, a factor in feet.

#include <optional>

#include "orthodrive/geo/vec.hpp"
#include "orthodrive/model/rasters/rasters.hpp"

namespace orthodrive {

struct HeightOffset {
  double median_m = 0.0;             ///< of the first less the second
  double low_m = 0.0, high_m = 0.0;  ///< quartiles
  bool first_in_feet = false;        ///< 3.28 times as high as the second, relief as well
  bool second_in_feet = false;       ///< likewise
  Vec2 middle;                       ///< of the places that were compared
  bool along_border = false;         ///< the models share too little: compared where one ends and the other goes on
  /// Standard deviation of a normal distribution with these quartiles.
  [[nodiscard]] double sigma_m() const;
};

/// Inside the box, at up to 3600 places that both have, else at the border of each, where it is extended along its own
/// slope by a pixel of the coarser one. Nothing where fewer than 50 places can be compared. Both in one CRS.
[[nodiscard]] std::optional<HeightOffset> height_offset(const HeightGrid& a, const HeightGrid& b, const Box2& box);

}  // namespace orthodrive
