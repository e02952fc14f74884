// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/lab/methods/other_methods.hpp"

#include "orthodrive/core/error.hpp"
#include "orthodrive/io/raster/raster_io.hpp"
#include "orthodrive/io/support/read_file.hpp"
#include "orthodrive/lab/training/parts.hpp"
#include "orthodrive/roads/dense_nodes.hpp"

namespace orthodrive {
namespace {
constexpr double node_distance_m = 2.0;  // of unrefined roads, as the default method's

OtherRefinement by_nlo(const OtherRefineOptions& other) {
  return {[nlo = other.nlo](const RoadNetwork& osm, const LabelMap* labels, StageContext& context) mutable {
    if (!labels) throw OptionError("refine: --method nlo needs --labels");
    nlo.threads = context.threads;
    return refine_roads_nlo(osm, *labels, nlo, context.monitor);
  }};
}

OtherRefinement by_mrf(const OtherRefineOptions& other, const SiteFrame& site) {
  return {[other, site](const RoadNetwork& osm, const LabelMap*, StageContext& context) {
    const std::string text = io::read_file(other.forests);
    const ForestsPart& part = forests_part();
    const RoadForests forests = part.load_road_forests(text, other.forests.string());
    const PhotoSource photo = io::open_photo(other.photo, site, {.threads = context.threads});
    MrfRoadsOptions mrf = other.mrf;
    mrf.threads = context.threads;
    MrfRoadsResult result =
        part.refine_roads_mrf(osm, part.mrf_photo_evidence(photo, forests, {}), mrf, context.monitor);
    return RefinedRoads{std::move(result.roads), {result.converged, result.sweeps}, std::move(result.findings)};
  }};
}
}  // namespace

StageOutcome run_refine_by(const OtherRefineOptions& other, const RefineFiles& files, RunRefineOptions run,
                           StageContext& context) {
  switch (other.method) {
    case RefineMethod::nlo:
      run.other = by_nlo(other);
      break;
    case RefineMethod::mrf:
      if (other.photo.empty() || other.forests.empty())
        throw OptionError("refine: --method mrf needs --photo and --forests (`orthodrive forests` makes them)");
      (void)forests_part();  // missing: said before anything is read
      if (!run.site) run.site = site_of_photos({other.photo});
      run.other = by_mrf(other, *run.site);
      break;
    case RefineMethod::none:
      run.other = OtherRefinement{[](const RoadNetwork& osm, const LabelMap*, StageContext&) {
                                    return RefinedRoads{.roads = with_nodes_every(osm, node_distance_m)};
                                  },
                                  false};
      break;
  }
  return run_refine(files, run, context);
}

StageOutcome run_elevate_by(const OtherHeightOptions& other, const ElevateFiles& files, RunElevateOptions run,
                            StageContext& context) {
  run.elevate.heights.instead = [other](const RoadNetwork& roads, const NodeHeights& terrain_m) {
    return other.method == HeightMethod::reference
               ? reference_heights(roads, terrain_m, other.reference)
               : SolvedHeights{.z_m = moving_average(roads, terrain_m, other.window)};
  };
  return run_elevate(files, run, context);
}

}  // namespace orthodrive
