// SPDX-License-Identifier: Apache-2.0
#pragma once
// What a network is trained on, and random crops of it.

#include <cstdint>
#include <string>
#include <vector>

#include "orthodrive/geo/raster.hpp"
#include "orthodrive/model/rasters/allowed_classes.hpp"
#include "orthodrive/model/rasters/map_alignment.hpp"

namespace orthodrive {

struct TrainingScene {
  std::string name;
  Raster<std::uint8_t> rgb;  ///< no_photo_value where there is no photo
  Raster<ClassSet> allowed;  ///< of the same size
  double gsd_m = 0.5;
  double weight = 1.0;                     ///< relative frequency of its crops
  double min_zoom = 0.8, max_zoom = 1.25;  ///< crops look as if photographed at gsd / zoom
  std::int64_t from_step = 0;              ///< not used before
  bool crf_only = false;                   ///< only the CRF learns from it, the network does not
  std::vector<RoadLine> map;               ///< roads of a real map, in the photo's pixels; none: made out of `allowed`
};

/// How crops are varied.
struct Augmentation {
  enum class Turn {
    any,
    quarters,
    none
  } turn = Turn::any;  ///< quarters: with mirroring the eight copies of the reference
  bool mirror = true, zoom = true, colors = true, blur = true, noise = true;
  double domain = 0.0;  ///< strength of disturb_domain (disturb_photo.hpp); above 0 it stands for `colors`
};

struct CropOptions {
  int size_px = 384;
  double gsd_m = 0.5;  ///< of the crop
  Augmentation augmentation;
};

/// A crop at a random place, turned by any angle, mirrored, zoomed; colours, contrast and sharpness disturbed.
struct Crop {
  Raster<std::uint8_t> rgb;
  Raster<ClassSet> allowed;
  std::vector<RoadLine> map;  ///< that of the scene, in the crop's pixels
};
[[nodiscard]] Crop draw_crop(const TrainingScene& scene, const CropOptions& options, std::uint64_t seed);

/// Index of a scene by weight among those in use at that step. Throws OptionError when there is none.
[[nodiscard]] std::size_t draw_scene(const std::vector<TrainingScene>& scenes, std::int64_t step, std::uint64_t seed);

}  // namespace orthodrive
