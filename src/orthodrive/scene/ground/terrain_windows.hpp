// SPDX-License-Identifier: Apache-2.0
#pragma once
// The terrain model window by window, without holes.

#include "orthodrive/core/finding.hpp"
#include "orthodrive/model/rasters/raster_source.hpp"
#include "orthodrive/scene/plan/outline.hpp"

namespace orthodrive::scene {

/// Holes (NaN) are filled from their surroundings: means over ever larger squares, then down again (pull-push, Gortler
/// et al., The Lumigraph, 1996, sec. 3.4). All NaN stays so.
void fill_holes(Raster<float>& heights);

/// Fills holes as fill_holes() does, by means of squares that are the same whatever window is asked for: those of up to
/// 32 pixels come from the window and its surroundings, larger ones from a coarse terrain that is kept whole.
class TerrainWindows {
 public:
  /// Reads the terrain once. Findings tell of holes inside the area: "scene.terrain_hole". Throws InputError when there
  /// is no height anywhere.
  TerrainWindows(HeightSource source, const Outline& area, Findings& findings);

  /// Heights over the box, as far as the terrain reaches; those at its border where the box lies beside it.
  [[nodiscard]] HeightGrid window(const Box2& box) const;
  /// Bilinear; beyond the terrain's border the border value goes on.
  [[nodiscard]] double height_m(Vec2 p) const;

 private:
  HeightSource source_;
  Raster<float> coarse_;  ///< means of squares of 64 pixels, holes filled
};

}  // namespace orthodrive::scene
