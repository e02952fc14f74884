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

/// Source files in one role. Their content counts; of rasters that of the files beside them as well.
struct SourceRole {
  enum class Kind { file, raster };
  std::string role;  ///< key of "inputs" in run.json
  std::vector<std::filesystem::path> files;
  Kind kind = Kind::file;
};

/// Work of a stage in pieces that know nothing of each other; several processes may share them (docs/cells.md).
struct SharedWork {
  std::function<std::size_t()> count_cells;
  std::function<void(std::span<const std::size_t> cells, const CellStore& store)> make_cells;
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
  std::optional<SharedWork> shared;
  /// Runs the loops of the stage with SiteBuild::context.exchange and writes nothing. One of this and `shared`, or
  /// none: then one process does it all.
  std::function<void()> share_loops;
};

/// The area and its CRS as options of a stage that is cut to them.
[[nodiscard]] nlohmann::json frame_options(const SiteFrame& frame);

}  // namespace orthodrive
