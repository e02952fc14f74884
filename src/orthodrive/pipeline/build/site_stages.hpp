// SPDX-License-Identifier: Apache-2.0
#pragma once
// The stages of a site in their order, and what each depends on as the files are now.

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "orthodrive/pipeline/build/watched_sources.hpp"
#include "orthodrive/pipeline/stages/build_stage.hpp"
#include "orthodrive/pipeline/stages/stage_cache.hpp"

namespace orthodrive {

/// What a build keeps for itself, below the output folder.
inline constexpr const char* private_folder = ".orthodrive";

/// All stages in their order. Throws InputError for a source that is not there. The drive comes before the scene: one
/// process drives, and those that share the build make the scene's cells meanwhile.
[[nodiscard]] std::vector<BuildStage> stages_of(SiteBuild& build);

/// Hashes of what the stages so far left behind; none for what is not made yet.
using OutputHashes = std::map<std::string, std::optional<std::string>>;

[[nodiscard]] StageDependencies dependencies_of(const BuildStage& stage, const WatchedSources& sources,
                                                const OutputHashes& made);

/// Whether run.json tells of all stages as their records are now, so that nothing is left of the build. Only where none
/// of them has changes.
[[nodiscard]] bool is_reported(const std::filesystem::path& out_dir, const std::vector<BuildStage>& stages,
                               const StageCache& cache);

}  // namespace orthodrive
