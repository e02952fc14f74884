// SPDX-License-Identifier: Apache-2.0
#pragma once
// Photo -> labels: a fully convolutional network over a mosaic of any size, in memory that does not grow with it.

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "orthodrive/core/finding.hpp"
#include "orthodrive/core/monitor.hpp"
#include "orthodrive/core/shared_loop.hpp"
#include "orthodrive/model/rasters/map_alignment.hpp"
#include "orthodrive/model/rasters/photo_source.hpp"
#include "orthodrive/model/rasters/rasters.hpp"
#include "orthodrive/segment/segment_model.hpp"

namespace orthodrive {

struct SegmentOptions {
  int window_px =
      0;  ///< edge of what is decided at once, in the network's pixels; margins come on top; 0: as suits memory
  int threads = 0;                ///< 0 = all cores; the result does not depend on it
  const MapLines* map = nullptr;  ///< the roads of the photo's map, to networks that see one; none: the photo alone
  std::span<const Vec2>
      places;                   ///< on the map's lines, in the photo's CRS: where a model that sees it tells alignments
  std::optional<CrfModel> crf;  ///< refines the probabilities before they are decided; none: the network alone
  /// What segment_windows() left of a window, perhaps on another machine; nothing: it is made now. Safe from any
  /// thread. None: all are made now.
  std::function<std::optional<std::string>(std::size_t window)> made;
};

/// What is decided about the pixels of a box; probabilities are 0..255 = 0..1.
struct LabelledPixels {
  Raster<std::uint8_t> labels;            ///< label_nodata without photo
  Raster<std::uint8_t> confidence;        ///< probability of the label
  Raster<std::uint8_t> road_probability;  ///< of all classes with the role road
};
/// Takes one box after the other: row by row, west to east, they cover the frame once, and are handed over one at a
/// time, from changing threads.
using LabelSink = std::function<void(const PixelBox& box, const LabelledPixels& pixels)>;

struct SegmentSummary {
  GridFrame frame;                         ///< of the labels
  std::int64_t labelled_pixels = 0;        ///< those with photo
  std::vector<PlaceAlignment> alignments;  ///< one per place asked for
  Findings findings;
};

/// The frame of a photo at the scale that the model sees it at.
[[nodiscard]] GridFrame network_frame(const GridFrame& photo, const SegmentModel& model);

/// The frame of the labels of a photo: its own where it has the model's scale, else the covering grid at that scale. A
/// photo of 0.6 of the model's GSD or less is classified at the model's finest scale and gets labels twice as fine as
/// that, so that edges are not those of the model's pixels.
[[nodiscard]] GridFrame label_frame(const GridFrame& photo, const SegmentModel& model);

/// The photo is brought to the model's scale, then classified window by window. Each window carries a margin of real
/// pixels at least as wide as what the network sees, so the windows leave no trace. Holds the windows being worked on
/// and a few finished ones: some 0.8 GB a worker at the default window, whatever the mosaic.
[[nodiscard]] SegmentSummary segment_mosaic(const PhotoSource& photo, const SegmentModel& model, const LabelSink& sink,
                                            const SegmentOptions& options = {}, Monitor* monitor = nullptr);

/// Makes those windows of segment_mosaic() that `next` gives, with the same options, and hands each to `keep` as bytes
/// for SegmentOptions::made, from changing threads.
void segment_windows(const PhotoSource& photo, const SegmentModel& model, const NextItem& next,
                     const std::function<void(std::size_t window, const std::string& bytes)>& keep,
                     const SegmentOptions& options, Monitor* monitor = nullptr);

struct SegmentResult {
  LabelMap labels;           ///< on label_frame()
  ConfidenceMap confidence;  ///< probability of that label
  ConfidenceMap road_probability;
  Findings findings;
};

/// The same, photo and labels in memory.
[[nodiscard]] SegmentResult segment_mosaic(const Photo& photo, const SegmentModel& model,
                                           const SegmentOptions& options = {}, Monitor* monitor = nullptr);

}  // namespace orthodrive
