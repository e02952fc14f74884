// SPDX-License-Identifier: Apache-2.0
#pragma once
// Stage "segment": photo and model -> labels, confidence, probability of road. Photo and rasters stream.

#include "orthodrive/pipeline/stages/build_stage.hpp"
#include "orthodrive/segment/segment_mosaic.hpp"

namespace orthodrive {

struct SegmentFiles {
  Sources::Files photos;                               ///< best first
  std::string model = "default";                       ///< name in a models folder, or a file
  Sources::Files osm;                                  ///< the map, for models that see one and to adapt with
  Sources::Files buildings, surroundings;              ///< to adapt with; empty: those of `osm`
  std::filesystem::path labels;                        ///< written
  std::filesystem::path confidence, road_probability;  ///< written unless empty
  std::filesystem::path alignment;                     ///< likewise, by models that see the map (alignment_io.hpp)
};

enum class CrfUse {
  none,
  trained,              ///< the model's; InputError when it has none
  trained_or_reference  ///< with that of the reference's grid search for models that have none
};

struct RunSegmentOptions {
  /// Without an area: all that the photos show, in their UTM zone. With one: InputError where no photo has data in it.
  std::optional<SiteFrame> site;
  CrfUse crf = CrfUse::none;
  std::string crf_set;     ///< for parse_crf_set: in place of the model's; empty: the model's
  int crf_iterations = 0;  ///< 0: as trained
  int window_px = 0;       ///< as SegmentOptions
  bool adapt = false;      ///< the network first learns from the photo and its map (train/adapt_model)
};

StageOutcome run_segment(const SegmentFiles& files, const RunSegmentOptions& options, StageContext& context);

/// Makes windows for the process that runs run_segment() with the same files and options, through the context's
/// exchange; without adapting.
void help_segment(const SegmentFiles& files, const RunSegmentOptions& options, StageContext& context);

[[nodiscard]] BuildStage segment_stage(SiteBuild& build);

}  // namespace orthodrive
