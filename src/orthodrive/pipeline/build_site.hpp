#pragma once
// The main job: all stages in order, from site.toml to a driven lap.

#include <filesystem>
#include <string>
#include <vector>

#include "orthodrive/core/monitor.hpp"
#include "orthodrive/pipeline/site.hpp"
#include "orthodrive/pipeline/stage_cache.hpp"

namespace orthodrive {

struct BuildOptions {
  int threads = 0;      ///< 0 = all cores; the result does not depend on it
  std::string version;  ///< of the tool, for run.json
};

struct BuildResult {
  std::vector<StageRecord> stages;
};

/// Builds the site into out_dir: labels.tif confidence.tif roads.gpkg road_graph.geojson roads.xodr scene/ drive/
/// report.html findings.geojson run.json. Stages whose tool, options, sources and earlier stages are unchanged are
/// taken over from out_dir. All sources are opened before anything is written, so that bad input leaves an earlier
/// result as it was. Throws InputError, OptionError or Error with one line that says what to do.
BuildResult build_site(const Site& site, const std::filesystem::path& out_dir, const BuildOptions& options = {},
                       Monitor* monitor = nullptr);

}  // namespace orthodrive
