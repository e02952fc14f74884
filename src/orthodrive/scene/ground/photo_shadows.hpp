// SPDX-License-Identifier: Apache-2.0
#pragma once
// The photo without the shadows that lay on the ground when it was taken: a viewer's sun throws its own.

#include <array>
#include <optional>
#include <vector>

#include "orthodrive/model/rasters/raster_source.hpp"
#include "orthodrive/scene/roads/road_tint.hpp"

namespace orthodrive::scene {

/// How a photo shows ground in the sun and in the shadow, where the sky alone lights it: darker and bluer.
struct PhotoShadows {
  /// log2 of blue / red, of the luminance and of blue / green, all linear.
  using Tone = std::array<float, 3>;
  /// Of one class.
  struct Class {
    Tone sunlit{}, shaded{};
    /// Light in the sun over light in the shadow, without the haze; 1 where nothing is lifted: on water, which looks
    /// like a shadow, and on vegetation, which shades itself.
    LinearColor gain = {1.0F, 1.0F, 1.0F};
    [[nodiscard]] bool is_lifted() const { return gain != LinearColor{1.0F, 1.0F, 1.0F}; }
  };
  /// What the air adds to every pixel: the darkest of the photo (Chavez 1988, dark-object subtraction).
  LinearColor haze{};
  std::vector<Class> classes;  ///< by label
};

/// From 64 windows spread over the photo. Road pixels fall into two groups (Lloyd's algorithm) where there are shadows;
/// empty where there are not two, or the darker one is not bluer. Tones and gain of another class are of the medians of
/// its own pixels that are like roads in the sun and in the shadow; those of roads where it has few.
[[nodiscard]] std::optional<PhotoShadows> find_shadows(const PhotoSource& photo, const LabelSource& labels,
                                                       int threads = 0);

/// Lifts what is as dark and as blue as its class in the shadow to the light that it would have in the sun, by degrees
/// over the half-shadow (as the ratio method of Tsai 2006, IEEE TGRS 44(6), with gains by class). A pixel is the same
/// in every box. The sources must outlive what they are made of, as always.
[[nodiscard]] PhotoSource without_shadows(PhotoSource photo, LabelSource labels, PhotoShadows shadows);

}  // namespace orthodrive::scene
