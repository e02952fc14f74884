// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/pipeline/build/site_stages.hpp"

#include <algorithm>
#include <fstream>
#include <stdexcept>

#include "orthodrive/pipeline/stages/run_drive.hpp"
#include "orthodrive/pipeline/stages/run_elevate.hpp"
#include "orthodrive/pipeline/stages/run_network.hpp"
#include "orthodrive/pipeline/stages/run_refine.hpp"
#include "orthodrive/pipeline/stages/run_scene.hpp"
#include "orthodrive/pipeline/stages/run_segment.hpp"

namespace orthodrive {
namespace fs = std::filesystem;

std::vector<BuildStage> stages_of(SiteBuild& build) {
  require_site_files(build.site);
  return {segment_stage(build), refine_stage(build), elevate_stage(build),
          network_stage(build), drive_stage(build),  scene_stage(build)};
}

StageDependencies dependencies_of(const BuildStage& stage, const WatchedSources& sources, const OutputHashes& made) {
  StageDependencies now{.version = stage.version, .options = stage.options, .sources = sources.of(stage)};
  for (const std::string& name : stage.reads) {
    const auto found = made.find(name);
    if (found == made.end()) throw std::logic_error("stage " + stage.name + " reads " + name + ", which none writes");
    now.reads[name] = found->second;
  }
  return now;
}

bool is_reported(const fs::path& out_dir, const std::vector<BuildStage>& stages, const StageCache& cache) {
  std::ifstream in(out_dir / "run.json");
  const nlohmann::json run = nlohmann::json::parse(in, nullptr, false);
  const auto tells_of = [&](const BuildStage& stage) {
    const std::string key = cache.load(stage.name).key;
    return std::ranges::any_of(run.at("stages"), [&](const nlohmann::json& told) {
      return told.at("stage") == stage.name && told.at("key") == key;
    });
  };
  try {
    return std::ranges::all_of(stages, tells_of);
  } catch (const nlohmann::json::exception&) {
    return false;
  }
}

}  // namespace orthodrive
