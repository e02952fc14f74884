#pragma once
// The main job: all stages in order, from site.toml to a driven lap.

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "orthodrive/core/monitor.hpp"
#include "orthodrive/pipeline/site.hpp"
#include "orthodrive/pipeline/stage_cache.hpp"

namespace orthodrive {

struct BuildOptions {
  int threads = 0;                                           ///< 0 = all cores; the result does not depend on it
  std::string version;                                       ///< of the tool, for run.json
  std::function<void(const std::string& stage)> at_stage{};  ///< called as a stage begins; "" at the end
  bool leave_cells = false;                                  ///< end before a stage of which cells are missing
};

/// A stage whose cells other processes may make (docs/cells.md).
struct CellsToMake {
  std::string stage;
  std::size_t all = 0;
  std::vector<std::size_t> missing;  ///< that nobody has made
};

struct BuildResult {
  std::vector<StageRecord> stages;
  std::optional<CellsToMake> waits_for;  ///< only with BuildOptions::leave_cells; nothing: the build is complete
};

/// Builds the site into out_dir: labels.tif confidence.tif roads.gpkg road_graph.geojson roads.xodr scene/ drive/
/// report.html findings.geojson run.json. Stages whose version, options, sources and what they read of earlier stages
/// are unchanged are taken over from out_dir. All sources are opened before anything is written, so that bad input
/// leaves an earlier result as it was; a source that changes under way is an error of the stage that read it. Throws
/// InputError, OptionError or Error with one line that says what to do, also when another process builds there.
BuildResult build_site(const Site& site, const std::filesystem::path& out_dir, const BuildOptions& options = {},
                       Monitor* monitor = nullptr);

/// What a build would do with a stage.
struct StageForecast {
  enum class Fate {
    taken_over,  ///< nothing changed
    runs,        ///< for the reasons of `changes`
    depends      ///< runs unless what it reads comes out as it was
  };
  std::string stage;
  Fate fate = Fate::runs;
  StageChanges changes;
};

/// What build_site would do and why, without running or writing anything. Reads the sources' content.
[[nodiscard]] std::vector<StageForecast> explain_build(const Site& site, const std::filesystem::path& out_dir);

/// The first stage that must run and whose cells other processes may make; nothing when there is none before a stage
/// that one process must run, or when nothing is left to do. Writes nothing.
[[nodiscard]] std::optional<CellsToMake> cells_to_make(const Site& site, const std::filesystem::path& out_dir,
                                                       const BuildOptions& options = {});

/// Some of the cells: those with index % chunks == chunk. Of loops that processes share: where this one begins.
struct CellChunk {
  std::size_t chunk = 0, chunks = 1;
};
/// Makes the missing cells of a chunk, of the stage that cells_to_make() names, and leaves them below
/// out_dir/.orthodrive/cells. Takes no lock: any number of processes on any number of machines may do so at once.
/// Returns how many it made. Throws as build_site() does.
std::size_t make_cells(const Site& site, const std::filesystem::path& out_dir, const CellChunk& chunk,
                       const BuildOptions& options = {}, Monitor* monitor = nullptr);

}  // namespace orthodrive
