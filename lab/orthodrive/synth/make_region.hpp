// SPDX-License-Identifier: Apache-2.0
#pragma once
// A synthetic site of many square kilometres, made tile by tile: what grows with its area is the plan, not the
// rasters. docs/synth_region.md describes how.

#include <functional>

#include "orthodrive/geo/pixel_box.hpp"
#include "orthodrive/synth/make_site.hpp"
#include "orthodrive/synth/plan/site_plan.hpp"

namespace orthodrive {

/// Grids of the site's rasters, site CRS.
struct RegionFrames {
  GridFrame photo, dtm_1m, dtm_10m;
};
/// Throws OptionError.
[[nodiscard]] RegionFrames region_frames(const synth::SitePlan& plan, const SynthOptions& options);

/// A window of the photo and the labels.
struct RegionPicture {
  PixelBox box;
  Raster<std::uint8_t> rgb, labels;
};
/// A window of the terrain models.
struct RegionHeights {
  PixelBox box_1m, box_10m;
  Raster<float> true_1m, dtm_1m, dtm_10m;
};
/// Takes the windows, which cover the grids without overlap; called on the caller's thread, in a fixed order.
struct RegionSink {
  std::function<void(const RegionPicture&)> picture;
  std::function<void(const RegionHeights&)> heights;
};

/// Everything but the rasters, which go to the sink; theirs are empty here. The plan (its size, not the options') has
/// the surroundings of a region. Same plan and options, same bytes, for any tile_px and any number of threads. Throws
/// OptionError.
[[nodiscard]] SynthSite make_region(synth::SitePlan plan, const SynthOptions& options, const RegionSink& sink,
                                    Monitor* monitor = nullptr);

}  // namespace orthodrive
