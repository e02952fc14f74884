// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/pipeline/stages/run_refine.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "orthodrive/core/error.hpp"
#include "orthodrive/io/models/alignment_io.hpp"
#include "orthodrive/io/raster/raster_io.hpp"
#include "orthodrive/io/support/read_file.hpp"
#include "orthodrive/io/support/vector_io.hpp"
#include "orthodrive/pipeline/files/refine_files.hpp"
#include "orthodrive/pipeline/sources/catalogue.hpp"
#include "orthodrive/refine/kerb_radius.hpp"
#include "orthodrive/refine/photo_surface.hpp"
#include "orthodrive/roads/sign_nodes.hpp"

namespace orthodrive {
namespace fs = std::filesystem;

namespace {
/// No method changes what the map tells of turns and of nodes.
void keep_rules(const RoadNetwork& osm, RoadNetwork& refined) {
  refined.restrictions = osm.restrictions;
  keep_signs(osm, refined);
}

RefinedRoads refine_by_default(const OsmRoads& osm, const LabelMap& labels, const io::GpxTraces& gpx,
                               const RefineFiles& files, const RefineRoadsOptions& options, StageContext& context) {
  RefineRoadsOptions standard = options;
  standard.threads = context.threads;
  standard.exchange = context.exchange;
  return refine_roads(osm.roads, read_evidence(labels, files.road_probability), standard, context.monitor, gpx.traces,
                      files.alignment.empty() ? RoadAlignment{} : io::read_alignment(files.alignment, osm.roads));
}

RefinedRoads refine_it(const RefineFiles& files, const RunRefineOptions& options, StageContext& context) {
  if (files.labels.empty() && !(options.other && options.site)) throw OptionError("refine: needs --labels");
  RefineRoadsOptions standard = options.standard;
  if (!files.weights.empty()) standard.weights = read_refine_weights(files.weights);
  std::optional<LabelMap> labels;
  if (!files.labels.empty()) labels = io::read_labels(files.labels);
  const SiteFrame site = options.site ? *options.site : labelled_site(files.labels, *labels);
  const OsmRoads& osm = context.sources.osm(files.osm, site);
  const io::GpxTraces& gpx = context.sources.gpx(files.gpx, site);
  standard.driving_side = driving_side_in(options.driving_side, site.crs, bounds_of(site.area.outer));
  RefinedRoads result = options.other ? options.other->refine(osm.roads, labels ? &*labels : nullptr, context)
                                      : refine_by_default(osm, *labels, gpx, files, standard, context);
  if (labels) {
    classify_by_photo(result.roads, *labels);
    measure_kerb_radii(result.roads, *labels);
  }
  keep_rules(osm.roads, result.roads);
  Findings findings = osm.findings;
  append(findings, gpx.findings);
  append(findings, result.findings);
  result.findings = std::move(findings);
  return result;
}

/// Mean over all nodes; they lie about 2 m apart everywhere.
template <typename Value>
double mean_over_nodes(const RoadNetwork& roads, const Value& value) {
  double sum = 0.0, count = 0.0;
  for (const RoadPath& path : roads.paths)
    for (const RoadNode& node : path.nodes) sum += value(node), count += 1.0;
  return count > 0.0 ? sum / count : 0.0;
}

StageOutcome outcome_of(const RefinedRoads& refined, const RefineFiles& files) {
  const RoadNetwork& roads = refined.roads;
  std::size_t nodes = 0;
  for (const RoadPath& path : roads.paths) nodes += path.nodes.size();
  const double offset_m = mean_over_nodes(roads, [](const RoadNode& n) { return std::abs(n.offset_m); });
  return {
      .numbers = {{"ways", roads.paths.size()},
                  {"mean_abs_offset_m", offset_m},
                  {"mean_sigma_offset_m", mean_over_nodes(roads, [](const RoadNode& n) { return n.sigma_offset_m; })},
                  {"mean_sigma_width_m", mean_over_nodes(roads, [](const RoadNode& n) { return n.sigma_width_m; })},
                  {"converged", refined.solve.converged},
                  {"iterations", refined.solve.iterations}},
      .findings = refined.findings,
      .summary = {fmt::format("{}: {} ways, {} nodes, moved by {:.2f} m on average", files.roads.string(),
                              roads.paths.size(), nodes, offset_m)}};
}
}  // namespace

StageOutcome run_refine(const RefineFiles& files, const RunRefineOptions& options, StageContext& context) {
  RefinedRoads refined = refine_it(files, options, context);
  // The lines lie in the middle of the carriageways now, wherever the map has drawn them.
  if (!options.other || options.other->moves)
    for (RoadPath& path : refined.roads.paths) path.placement = {};
  io::write_roads(files.roads, refined.roads);
  return outcome_of(refined, files);
}

void help_refine(const RefineFiles& files, const RunRefineOptions& options, StageContext& context) {
  (void)refine_it(files, options, context);
}

BuildStage refine_stage(SiteBuild& build) {
  const Site& site = build.site;
  const Sources::Files weights = site.refine_weights.empty() ? Sources::Files{} : Sources::Files{site.refine_weights};
  nlohmann::json options = frame_options(site.frame);
  options["refine.driving_side"] = to_string(site.driving_side);
  const RefineFiles files{.osm = site.osm,
                          .labels = build.out_dir / "labels.tif",
                          .road_probability = build.out_dir / "road_probability.tif",
                          .alignment = build.out_dir / ".orthodrive/alignment.csv",
                          .weights = site.refine_weights,
                          .gpx = site.gpx,
                          .roads = build.out_dir / ".orthodrive/refined.gpkg"};
  const RunRefineOptions run{.site = site.frame, .driving_side = site.driving_side};
  return {.name = "refine",
          .version = 13,
          .sources = {{"osm", site.osm}, {"refine_weights", weights}, {"gpx", site.gpx}},
          .options = options,
          .reads = {"labels.tif", "road_probability.tif", ".orthodrive/alignment.csv"},
          .outputs = {".orthodrive/refined.gpkg"},
          .check =
              [&build, &site] {
                (void)build.context.sources.osm(site.osm, site.frame);
                (void)build.context.sources.gpx(site.gpx, site.frame);
                if (!site.refine_weights.empty()) (void)read_refine_weights(site.refine_weights);
              },
          .run = [=, &build] { return run_refine(files, run, build.context); },
          .help = [=, &build] { help_refine(files, run, build.context); }};
}

}  // namespace orthodrive
