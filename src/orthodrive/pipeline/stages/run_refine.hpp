// SPDX-License-Identifier: Apache-2.0
#pragma once
// Stage "refine": OSM roads and labels -> roads moved onto the road that is seen, by the default method or a baseline.

#include "orthodrive/baselines/mrf_roads.hpp"
#include "orthodrive/baselines/nlo_roads.hpp"
#include "orthodrive/pipeline/stages/build_stage.hpp"
#include "orthodrive/refine/refine_roads.hpp"

namespace orthodrive {

struct RefineFiles {
  std::vector<std::filesystem::path> osm;
  std::filesystem::path labels;            ///< not of mrf
  std::filesystem::path road_probability;  ///< of the default method; may be empty
  std::filesystem::path alignment;         ///< likewise: of `orthodrive segment`
  std::filesystem::path weights;           ///< likewise: file of `orthodrive tune`
  std::vector<std::filesystem::path> gpx;  ///< likewise
  std::filesystem::path photo, forests;    ///< of mrf
  std::filesystem::path roads;             ///< written
};

enum class RefineMethod { standard, nlo, mrf, none };

struct RunRefineOptions {
  std::optional<SiteFrame> site;            ///< none: where the labels are (mrf: the photo)
  std::optional<DrivingSide> driving_side;  ///< none: that of the country in which the site lies
  RefineMethod method = RefineMethod::standard;
  RefineRoadsOptions standard;  ///< its weights count where files.weights is empty, its driving side is set here
  NloRoadsOptions nlo;
  MrfRoadsOptions mrf;
};

/// Throws OptionError where a file that the method needs is not named.
StageOutcome run_refine(const RefineFiles& files, const RunRefineOptions& options, StageContext& context);

/// Does with others what run_refine() does by the default method, and writes nothing but blocks of its loops.
void help_refine(const RefineFiles& files, const RunRefineOptions& options, StageContext& context);

[[nodiscard]] BuildStage refine_stage(SiteBuild& build);

}  // namespace orthodrive
