// SPDX-License-Identifier: Apache-2.0
#pragma once
// report.html of a built site, from what its stages left in the output folder.

#include "orthodrive/pipeline/stages/build_stage.hpp"
#include "orthodrive/pipeline/stages/stage_cache.hpp"

namespace orthodrive {

/// `scores`: of the result and of the input against the site's truth; null without truth.
StageOutcome run_report(SiteBuild& build, const std::vector<StageRecord>& stages, const nlohmann::json& scores);

}  // namespace orthodrive
