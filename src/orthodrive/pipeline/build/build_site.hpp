// SPDX-License-Identifier: Apache-2.0
#pragma once
// The main job: all stages in order, from site.toml to a driven lap.

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "orthodrive/core/monitor.hpp"
#include "orthodrive/pipeline/sources/site.hpp"
#include "orthodrive/pipeline/stages/stage_cache.hpp"

namespace orthodrive {

/// One of the processes that make a build together.
struct BuildShare {
  std::size_t index = 0, of = 1;  ///< index from 0
  /// Where it begins in a row of things to make, as a share of the row.
  [[nodiscard]] double first() const { return static_cast<double>(index) / static_cast<double>(of); }
};

struct BuildOptions {
  int threads = 0;                                           ///< 0 = all cores; the result does not depend on it
  std::string version;                                       ///< of the tool, for run.json
  std::function<void(const std::string& stage)> at_stage{};  ///< called as a stage begins; "" at the end
  std::optional<BuildShare> share{};  ///< other processes help (work_on_site.hpp); none: they do not
};

struct BuildResult {
  std::vector<StageRecord> stages;
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

}  // namespace orthodrive
