#pragma once
// A stage as an entry of `orthodrive build`: what its result depends on, what it leaves behind, how it runs.

#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "orthodrive/pipeline/cell_store.hpp"
#include "orthodrive/pipeline/site.hpp"
#include "orthodrive/pipeline/stage_context.hpp"
#include "orthodrive/pipeline/stage_outcome.hpp"

namespace orthodrive {

/// What all stages of a build share. Outlives them.
struct SiteBuild {
  const Site& site;
  std::filesystem::path out_dir;
  StageContext context;
  const CellStore* cells = nullptr;  ///< of the stage that runs: what other processes have made of it
};

/// Source files in one role. Their content counts; of rasters the outline as well, which may stand in a file beside
/// them.
struct SourceRole {
  enum class Kind { file, raster };
  std::string role;  ///< key of "inputs" in run.json
  std::vector<std::filesystem::path> files;
  Kind kind = Kind::file;
};

/// Work of a stage that several processes may share (docs/cells.md).
struct SharedWork {
  std::function<std::size_t()> count_cells;
  std::function<void(std::span<const std::size_t> cells, const CellStore& store)> make_cells;
};

struct BuildStage {
  std::string name;
  std::vector<SourceRole> sources;
  nlohmann::json options;            ///< everything of the site that is no file and changes the result of this stage
  std::vector<std::string> outputs;  ///< files and folders below out_dir
  std::function<void()> check;       ///< opens the sources, before anything is written; may be empty
  std::function<StageOutcome()> run;
  std::optional<SharedWork> shared;  ///< none: one process does it all
};

}  // namespace orthodrive
