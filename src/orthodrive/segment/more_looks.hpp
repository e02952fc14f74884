// SPDX-License-Identifier: Apache-2.0
#pragma once
// A photo finer than the network reads it pays for more looks: at other scales and mirrored, and the mean of the scores
// counts. Simonyan and Zisserman, Very deep convolutional networks for large-scale image recognition, ICLR 2015, sec.
// 3.2: flipped images and several scales in testing.

#include <vector>

#include "orthodrive/geo/pixel_box.hpp"
#include "orthodrive/geo/raster.hpp"
#include "orthodrive/model/rasters/map_alignment.hpp"
#include "orthodrive/model/rasters/photo_source.hpp"
#include "orthodrive/nets/inference_network.hpp"

namespace orthodrive {

/// What a network must see for the scores of a box.
struct NetworkWindow {
  Raster<std::uint8_t> rgb, map;
  [[nodiscard]] NetworkInput input() const { return {rgb.data.data(), map.empty() ? nullptr : map.data.data()}; }
};
/// `seen`: the box, grown by the network's margin. `rgb`: the photo in the part of it that lies in the frame; beyond it
/// is mirrored.
[[nodiscard]] NetworkWindow network_window(const InferenceNetwork& network, const MapLines* map, const GridFrame& frame,
                                           const PixelBox& seen, Raster<std::uint8_t> rgb);

/// Pixels of the network along a pixel of each further look, the finest first.
constexpr double look_scales[] = {0.75, 1.25};

/// The further looks at a photo; none where it is empty.
class MoreLooks {
 public:
  MoreLooks() = default;
  /// Of a photo that the network reads at `gsd_m`.
  MoreLooks(const PhotoSource& photo, double gsd_m);
  /// The finest pixel of all looks, in pixels of the network.
  [[nodiscard]] double finest_scale() const { return photos_.empty() ? 1.0 : look_scales[0]; }
  /// `scores` are those of `box`, in pixels of `frame`, a grid with the photo's north-western corner. Each class gets
  /// the mean of its own and those of the looks, bilinear. A pixel's does not depend on the box. `memory`: of this
  /// thread.
  void average(const InferenceNetwork& network, const MapLines* map, const GridFrame& frame, const PixelBox& box,
               Raster<float>& scores, CellMemory& memory) const;

 private:
  std::vector<PhotoSource> photos_;  ///< by look_scales; all are mirrored
};

}  // namespace orthodrive
