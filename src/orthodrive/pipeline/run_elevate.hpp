#pragma once
// Stage "elevate": roads, terrain models and drive logs -> roads with heights, banking and roughness.

#include "orthodrive/elevate/elevate_roads.hpp"
#include "orthodrive/pipeline/build_stage.hpp"

namespace orthodrive {

struct ElevateFiles {
  std::filesystem::path roads;                    ///< of refine
  std::vector<std::filesystem::path> dtm;         ///< best first
  std::vector<std::filesystem::path> drive_logs;  ///< may be empty
  std::filesystem::path elevated;                 ///< written; may be `roads`
  std::filesystem::path findings;                 ///< written unless empty
};

struct RunElevateOptions {
  std::optional<SiteFrame> site;  ///< none: the hull of the roads
  ElevateRoadsOptions elevate;
};

StageOutcome run_elevate(const ElevateFiles& files, const RunElevateOptions& options, StageContext& context);

[[nodiscard]] BuildStage elevate_stage(SiteBuild& build);

}  // namespace orthodrive
