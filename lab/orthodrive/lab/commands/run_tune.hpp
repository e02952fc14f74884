// SPDX-License-Identifier: Apache-2.0
#pragma once
// `orthodrive tune`: sites with truth -> weights of the road refinement and a report on them.

#include "orthodrive/pipeline/stages/stage_context.hpp"
#include "orthodrive/pipeline/stages/stage_outcome.hpp"
#include "orthodrive/refine/search_weights.hpp"

namespace orthodrive {

struct TuneFiles {
  std::filesystem::path sites;   ///< as read_tune_sites reads it
  std::filesystem::path folder;  ///< written: weights.toml and report.json
};

/// The summary is the table of losses and weights.
StageOutcome run_tune(const TuneFiles& files, const SearchWeightsOptions& options, StageContext& context);

}  // namespace orthodrive
