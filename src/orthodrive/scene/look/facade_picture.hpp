// SPDX-License-Identifier: Apache-2.0
#pragma once
// Where the pictures of facades and openings have what. Places in sides of the picture, v downwards.

#include "orthodrive/geo/vec.hpp"

namespace orthodrive::scene {

/// Bays and storeys of the materials facade and balconies: no two windows of them are the same.
constexpr int facade_bays = 4;

/// A part of the picture of the material openings. Strips go on across the picture's sides.
struct OpeningPicture {
  Vec2 from, to;
};
constexpr double opening_rim = 1.0 / 128.0;  ///< of a strip's edges: what smaller mipmaps mix
constexpr double opening_strip = 0.25;
constexpr int opening_cells = 8;  ///< side by side in the last strip

constexpr OpeningPicture strip_picture(int strip, double from_u, double to_u) {
  return {{from_u, opening_strip * strip + opening_rim}, {to_u, opening_strip * (strip + 1) - opening_rim}};
}
constexpr OpeningPicture cell_picture(int cell) {
  return {{(cell + 0.04) / opening_cells, 3.0 * opening_strip + opening_rim},
          {(cell + 0.96) / opening_cells, 1.0 - opening_rim}};
}

/// Windows side by side, eight in a picture's width.
constexpr OpeningPicture ribbon_picture(int widths) { return strip_picture(0, 0.0, widths); }
/// Panes on a low wall below a sign, four in a picture's width.
constexpr OpeningPicture shop_picture(int widths) { return strip_picture(1, 0.0, widths); }
/// Gates of garages, four in a picture's width.
constexpr OpeningPicture garage_picture(int gates) { return strip_picture(2, 0.0, 0.25 * gates); }
constexpr OpeningPicture door_picture(int kind) { return cell_picture(kind == 0 ? 0 : 1); }
constexpr OpeningPicture entrance_picture = cell_picture(2);
constexpr OpeningPicture gate_picture = cell_picture(3);
constexpr OpeningPicture church_picture = cell_picture(4);

}  // namespace orthodrive::scene
