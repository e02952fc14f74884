// SPDX-License-Identifier: Apache-2.0
#pragma once
// A stage as an entry of `orthodrive build`: what its result depends on, what it leaves behind, how it runs.

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "orthodrive/pipeline/sources/site.hpp"
#include "orthodrive/pipeline/stages/stage_context.hpp"
#include "orthodrive/pipeline/stages/stage_outcome.hpp"

namespace orthodrive {

/// What all stages of a build share. Outlives them.
struct SiteBuild {
  const Site& site;
  std::filesystem::path out_dir;
  StageContext context;
};

/// Source files in one role. Their content counts; of rasters that of the files beside them as well.
struct SourceRole {
  enum class Kind { file, raster };
  std::string role;  ///< key of "inputs" in run.json
  std::vector<std::filesystem::path> files;
  Kind kind = Kind::file;
};

/// The result of a stage depends on its version, sources, options and what it reads of earlier stages, and on nothing
/// else: these four are its key.
struct BuildStage {
  std::string name;
  int version = 1;  ///< raise it when the same inputs give other outputs, numbers or findings (docs/build.md)
  std::vector<SourceRole> sources;
  nlohmann::json options;            ///< by name: everything of the site that is no file and changes the result
  std::vector<std::string> reads;    ///< outputs of earlier stages that it opens
  std::vector<std::string> outputs;  ///< files and folders below out_dir
  std::function<void()> check;       ///< opens the sources, before anything is written; may be empty
  std::function<StageOutcome()> run;
  /// Helps another process that runs the stage: makes cells or blocks of loops through StageContext::exchange, and
  /// writes nothing else. Empty: one process does it all (docs/cells.md).
  std::function<void()> help;
};

/// The area and its CRS as options of a stage that is cut to them.
[[nodiscard]] nlohmann::json frame_options(const SiteFrame& frame);

}  // namespace orthodrive
