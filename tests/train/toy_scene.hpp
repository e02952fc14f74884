// SPDX-License-Identifier: Apache-2.0
#pragma once
// The smallest scene that something can be learned from.

#include "orthodrive/train/training_scene.hpp"

namespace orthodrive {

/// A bright square (class 1) on dark ground (class 0), with a strip where either may be.
inline TrainingScene toy_scene() {
  TrainingScene scene{
      .name = "toy", .rgb = Raster<std::uint8_t>(96, 96, 3, 60), .allowed = Raster<ClassSet>(96, 96, 1, only(0))};
  for (int row = 30; row < 66; ++row) {
    for (int col = 30; col < 66; ++col) {
      for (int c = 0; c < 3; ++c) scene.rgb.at(col, row, c) = 200;
      scene.allowed.at(col, row) = only(1);
    }
    scene.allowed.at(29, row) = only(0) | only(1);
  }
  return scene;
}

}  // namespace orthodrive
