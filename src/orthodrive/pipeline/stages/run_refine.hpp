// SPDX-License-Identifier: Apache-2.0
#pragma once
// Stage "refine": OSM roads and labels -> roads moved onto the road that is seen.

#include <functional>

#include "orthodrive/pipeline/stages/build_stage.hpp"
#include "orthodrive/refine/refine_roads.hpp"

namespace orthodrive {

struct RefineFiles {
  std::vector<std::filesystem::path> osm;
  std::filesystem::path labels;            ///< empty: only for another method, which does not read them
  std::filesystem::path road_probability;  ///< may be empty
  std::filesystem::path alignment;         ///< likewise: of `orthodrive segment`
  std::filesystem::path weights;           ///< likewise: file of `orthodrive tune`
  std::vector<std::filesystem::path> gpx;  ///< likewise
  std::filesystem::path roads;             ///< written
};

/// Another method, to compare with.
struct OtherRefinement {
  /// `labels` is null where no file of them is named.
  std::function<RefinedRoads(const RoadNetwork& osm, const LabelMap* labels, StageContext& context)> refine;
  bool moves = true;  ///< the roads lie in the middle of their carriageways then, wherever the map has drawn them
};

struct RunRefineOptions {
  std::optional<SiteFrame> site;            ///< none: where the labels are
  std::optional<DrivingSide> driving_side;  ///< none: that of the country in which the site lies
  RefineRoadsOptions standard;  ///< its weights count where files.weights is empty, its driving side is set here
  std::optional<OtherRefinement> other;
};

/// Throws OptionError where labels are needed and not named.
StageOutcome run_refine(const RefineFiles& files, const RunRefineOptions& options, StageContext& context);

/// Does with others what run_refine() does by its own method, and writes nothing but blocks of its loops.
void help_refine(const RefineFiles& files, const RunRefineOptions& options, StageContext& context);

[[nodiscard]] BuildStage refine_stage(SiteBuild& build);

}  // namespace orthodrive
