#pragma once
// Photo -> labels: a fully convolutional network over a mosaic of any size.

#include "orthodrive/core/finding.hpp"
#include "orthodrive/core/monitor.hpp"
#include "orthodrive/model/rasters.hpp"
#include "orthodrive/segment/segment_model.hpp"

namespace orthodrive {

struct SegmentOptions {
  int window_px = 1536;  ///< edge of the window the network sees at once; memory per worker grows with its square
  int threads = 0;       ///< 0 = all cores; the result does not depend on it
};

struct SegmentResult {
  LabelMap labels;           ///< at the model's scale
  ConfidenceMap confidence;  ///< probability of that label
  Findings findings;
};

/// The photo is brought to the model's scale, then classified window by window. Each window carries a margin of real
/// pixels at least as wide as what the network sees, so the windows leave no trace. Needs about 0.7 GB a worker at
/// the default window, plus 5 bytes a pixel.
[[nodiscard]] SegmentResult segment_mosaic(const Photo& photo, const SegmentModel& model,
                                           const SegmentOptions& options = {}, Monitor* monitor = nullptr);

}  // namespace orthodrive
