// SPDX-License-Identifier: Apache-2.0
#pragma once
// How a network sees the map beside the photo, and what it says about it. Lengths are in pixels of the network's grid.
// Zampieri et al., Multimodal image alignment through a multiscale chain of neural networks, 2018; Girard et al.,
// Aligning and updating cadaster maps with aerial images by multi-task, multi-resolution deep learning, 2018.

#include <cstdint>
#include <span>
#include <vector>

#include "orthodrive/geo/pixel_box.hpp"
#include "orthodrive/geo/polyline.hpp"
#include "orthodrive/geo/raster.hpp"

namespace orthodrive {

/// Bytes of a map raster: the vector to the nearest centre line (x to the right, y downwards: 128 + 4 per pixel), how
/// near it is (255 on it, 0 from map_reach_px on), and half the road's width (8 per pixel; 0: not known). Without a
/// line in reach 128, 128, 0, 0, which is zero to the network.
constexpr int map_raster_channels = 4;
constexpr double map_reach_px = 32.0;

/// What a network says of the road that the nearest line stands for, in units of 8 px: the vector from the pixel's
/// centre to the road's true centre line (x, y; only across the line it means something), the logarithm of its scale
/// (Laplace), half the road's width, and the logarithm of that one's scale.
constexpr int alignment_channels = 5;
constexpr double alignment_unit_px = 8.0;
constexpr double least_log_scale = -5.0, most_log_scale = 3.0;  ///< what is beyond counts as these

/// A road of a map.
struct RoadLine {
  Polyline points;
  double half_width = 0.0;  ///< in the unit of the points; 0: not known
};

/// The nearest place on the lines.
struct NearestLine {
  Vec2 to_line;            ///< from the pixel's centre
  std::int32_t line = -1;  ///< none within map_reach_px
  std::int32_t segment = 0;
  double t = 0.0;  ///< along the segment, 0 to 1
};
/// For each pixel of a box; lines in absolute pixels. A pixel is the same in every box that has it, as long as `lines`
/// holds all lines within reach of it in the same order.
[[nodiscard]] Raster<NearestLine> nearest_lines(std::span<const RoadLine> lines, const PixelBox& box);

[[nodiscard]] Raster<std::uint8_t> map_raster(std::span<const RoadLine> lines, const Raster<NearestLine>& nearest);

/// The roads of a site's map, to be seen through any window. Safe from several threads.
class MapLines {
 public:
  MapLines() = default;
  explicit MapLines(std::vector<RoadLine> lines_m);  ///< in the CRS of the frames asked for
  [[nodiscard]] bool empty() const { return lines_.empty(); }
  /// Those within that many pixels of a box of that frame, and more, in its absolute pixels.
  [[nodiscard]] std::vector<RoadLine> near(const GridFrame& frame, const PixelBox& box, double margin_px) const;
  /// The map raster of a box of that frame, also beyond it.
  [[nodiscard]] Raster<std::uint8_t> read(const GridFrame& frame, const PixelBox& box) const;

 private:
  std::vector<RoadLine> lines_;
  std::vector<Box2> boxes_;
};

/// What a network says of a place on a line of the map.
struct PlaceAlignment {
  Vec2 displacement_m;   ///< to the true centre line; along the line it means nothing
  double sigma_m = 0.0;  ///< of the displacement across the line; 0: nothing is said here
  double half_width_m = 0.0, sigma_half_width_m = 0.0;
};
/// From the alignment channels of the pixel that a place lies in; its edge is gsd_m, rows run south. `from_center_px`:
/// of the place in that pixel. Standard deviations are those of Laplace distributions, sqrt(2) times their scales.
/// Rounded to millimetres: the order of a network's sums shows nowhere.
[[nodiscard]] PlaceAlignment place_alignment(const float* channels, Vec2 from_center_px, double gsd_m);

/// Along a path every 2 m, and at its end.
struct AlignedPlace {
  double s_m = 0.0;
  PlaceAlignment alignment;
};
using RoadAlignment = std::vector<std::vector<AlignedPlace>>;  ///< one per path
/// Distances along a line at which it is asked.
[[nodiscard]] std::vector<double> places_along(double length_m);

}  // namespace orthodrive
