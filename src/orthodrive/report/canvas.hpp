// SPDX-License-Identifier: Apache-2.0
#pragma once
// Painting lines and areas over a raster, for the pictures of the report.

#include <array>
#include <cstdint>
#include <span>

#include "orthodrive/geo/polygon.hpp"
#include "orthodrive/geo/polyline.hpp"
#include "orthodrive/model/rasters/rasters.hpp"

namespace orthodrive {

using Color = std::array<std::uint8_t, 3>;

/// An RGB picture of a piece of ground. Everything is given in the site CRS.
struct Canvas {
  GridFrame frame;
  Raster<std::uint8_t> rgb;
};

/// The photo within the box, averaged or repeated to pictures of at most `max_px` pixels in each direction.
/// Ground without photo is light grey.
[[nodiscard]] Canvas canvas_of(const Photo& photo, const Box2& box, int max_px);
/// Class colours instead of the photo.
[[nodiscard]] Canvas canvas_of(const LabelMap& labels, const Box2& box, int max_px);

/// Luma of the photo at a place (ITU-R BT.601), 0..255; an even grey where there is no photo (or none at all: null).
[[nodiscard]] double grey_at(const Photo* photo, Vec2 p);

/// Mixes `color` over what is there with weight `alpha` (0..1).
void fill(Canvas& canvas, const Polygon& polygon, Color color, double alpha);
/// A line of that width in pixels, anti-aliased.
void stroke(Canvas& canvas, std::span<const Vec2> line, double width_px, Color color, double alpha = 1.0);

/// The viridis ramp, which colour-blind readers can follow; t in 0..1.
[[nodiscard]] Color viridis(double t);

}  // namespace orthodrive
