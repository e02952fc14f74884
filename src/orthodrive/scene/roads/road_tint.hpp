// SPDX-License-Identifier: Apache-2.0
#pragma once
// What colour the photo gives a road, without the cars and shadows on it.

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "orthodrive/model/rasters/rasters.hpp"
#include "orthodrive/model/rasters/srgb.hpp"
#include "orthodrive/scene/roads/road_level.hpp"

namespace orthodrive::scene {

/// A smooth field of colours: the photo's pixels on roads are gathered in cells of 8 m; a cell's colour is that of the
/// pixel of median brightness in it and its eight neighbours, places between cells are bilinear. A car or a tree's
/// shadow that covers less than half of the road within 24 m does not show.
class RoadTint {
 public:
  RoadTint() = default;
  /// Samples every 2 m along the roads and 1 m across them.
  RoadTint(std::span<const RoadLevel* const> levels, const Photo& photo);
  /// A dark grey where no road with a photo is near.
  [[nodiscard]] LinearColor at(Vec2 p) const;

 private:
  std::map<std::array<int, 2>, LinearColor> cells_;
};

/// The colour of asphalt in a photo that shows something else there, for instance ground beside a road that the map has
/// moved: as bright (mean of the channels), but channels differ by `asphalt_chroma` of the mean at most.
[[nodiscard]] LinearColor as_asphalt(const LinearColor& color);
constexpr float asphalt_chroma = 0.35F;

using Rgb = std::array<std::uint8_t, 3>;
/// Nothing beyond the photo and where it is not valid.
[[nodiscard]] std::optional<Rgb> pixel_at(const Photo& photo, Vec2 p);
/// That of the pixel of median brightness; a dark grey without any.
[[nodiscard]] LinearColor median_color(std::vector<Rgb>& pixels);

/// Mean of the photo's pixels in a square of size_m around p; a dark grey where there are none.
[[nodiscard]] LinearColor photo_mean(const Photo& photo, Vec2 p, double size_m);

/// The pixel of median brightness of those at points 1 m apart inside the polygon; the dark grey where there is none.
[[nodiscard]] LinearColor photo_median(const Photo& photo, const Polygon& polygon);
/// The same of the points that count; empty where there is none.
[[nodiscard]] std::optional<LinearColor> photo_median(const Photo& photo, const Polygon& polygon,
                                                      const std::function<bool(Vec2)>& counts);

}  // namespace orthodrive::scene
