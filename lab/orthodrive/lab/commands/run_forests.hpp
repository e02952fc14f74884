// SPDX-License-Identifier: Apache-2.0
#pragma once
// `orthodrive forests`: labelled photos -> the two random forests of the MRF baseline.

#include "orthodrive/baselines/road_forest.hpp"
#include "orthodrive/pipeline/stages/stage_context.hpp"
#include "orthodrive/pipeline/stages/stage_outcome.hpp"

namespace orthodrive {

struct ForestsFiles {
  std::vector<std::filesystem::path> photos, labels;  ///< in pairs; labels are a label map or painted polygons
  std::filesystem::path forests;                      ///< written
};

/// Throws OptionError when there are not as many labels as photos.
StageOutcome run_forests(const ForestsFiles& files, const RoadForestOptions& options, StageContext& context);

}  // namespace orthodrive
