// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/baselines/nlo_roads.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "orthodrive/baselines/nlo_fit.hpp"
#include "orthodrive/core/error.hpp"
#include "orthodrive/core/parallel.hpp"
#include "orthodrive/roads/join_junctions.hpp"

namespace orthodrive {
namespace {

using namespace baselines;

void check_nlo(const RoadNetwork& osm, const LabelMap& labels, const NloRoadsOptions& options) {
  if (!(osm.crs == labels.crs))
    throw OptionError(fmt::format("refine: roads are in {} but labels in {}, need one CRS", osm.crs.definition,
                                  labels.crs.definition));
  if (!(options.spacing_m > 0.0) || !(options.strip_m > 0.0) || !(options.difference_step_m > 0.0))
    throw OptionError("refine: spacing, strip and difference step must be positive");
  if (!(options.max_offset_m >= 0.0)) throw OptionError("refine: the largest offset must not be negative");
  if (!(options.min_width_factor > 0.0 && options.min_width_factor <= 1.0 && options.max_width_factor >= 1.0))
    throw OptionError(fmt::format("refine: widths from {} to {} times the input's leave the input's out",
                                  options.min_width_factor, options.max_width_factor));
  if (!(options.unlabelled_cost >= 0.0 && options.unlabelled_cost <= 1.0))
    throw OptionError("refine: the cost of a pixel without a label is 0 to 1");
  if (options.passes.empty()) throw OptionError("refine: need at least one pass");
  for (const NloPass& pass : options.passes)
    if (!(pass.weight_class >= 0.0) || !(pass.weight_angle >= 0.0) || !(pass.weight_width >= 0.0) ||
        !(pass.weight_offset >= 0.0) || pass.max_iterations < 0)
      throw OptionError("refine: weights and iterations must not be negative");
  for (const RoadPath& path : osm.paths) {
    if (path.nodes.size() < 2) throw OptionError(fmt::format("refine: way {} has fewer than two nodes", path.osm_id));
    for (const RoadNode& node : path.nodes)
      if (!(node.width_m > 0.0))
        throw OptionError(fmt::format("refine: way {} has no width, set default_width_m", path.osm_id));
  }
}

Polyline line_of(const NloPath& path, const std::vector<double>& offset_m) {
  Polyline line;
  for (std::size_t i = 0; i < path.nodes.size(); ++i)
    line.push_back(path.nodes[i].base + path.nodes[i].normal * offset_m[i]);
  return line;
}

/// What joining junctions needs of a path: a chain of one piece.
RoadChain chain_of(const NloPath& path, const RoadPath& way, std::size_t index) {
  RoadChain chain{.closed = path.closed,
                  .rank = road_rank(way.highway),
                  .pieces = {{.path = index, .last = path.nodes.size() - 1}}};
  double s_m = 0.0;
  for (std::size_t i = 0; i < path.nodes.size(); ++i) {
    const NloNode& node = path.nodes[i];
    if (i > 0) s_m += distance(path.nodes[i - 1].base, node.base);
    chain.nodes.push_back({.base = node.base,
                           .normal = node.normal,
                           .osm_node = node.osm_node,
                           .s_m = s_m,
                           .input_width_m = node.width_m});
  }
  return chain;
}

RoadPath pack_nlo_path(const RoadPath& input, const NloPath& path, const NloFit& fit, const Polyline& line) {
  RoadPath result = input;
  result.nodes.clear();
  const std::vector<double> s = arc_lengths_m(line);
  for (std::size_t i = 0; i < line.size(); ++i)
    result.nodes.push_back({.p = line[i],
                            .osm_node = path.nodes[i].osm_node,
                            .s_m = s[i],
                            .offset_m = dot(line[i] - path.nodes[i].base, path.nodes[i].normal),
                            .width_m = fit.width_m[i]});
  return result;
}

void report(const RoadPath& way, const NloPath& path, const NloFit& fit, Findings& findings) {
  const Vec2 middle = path.nodes[path.nodes.size() / 2].base;
  const auto add = [&](const char* code, const std::string& message) {
    findings.push_back({Severity::warning, code, fmt::format("way {}: {}", way.osm_id, message), middle.x, middle.y});
  };
  if (std::all_of(path.nodes.begin(), path.nodes.end(), [](const NloNode& node) { return node.own == 0; }))
    add("refine.no_length", "all of its nodes lie in one place, kept as it is");
  else if (fit.outside_labels)
    add("refine.outside_labels", "has no labels beside it, kept the OSM line and width");
  if (fit.failed) add("refine.solver_failed", "the solver could not go on, kept what it had");
}

}  // namespace

RefinedRoads refine_roads_nlo(const RoadNetwork& osm, const LabelMap& labels, const NloRoadsOptions& options,
                              Monitor* monitor) {
  check_nlo(osm, labels, options);
  const std::size_t count = osm.paths.size();
  std::vector<NloPath> paths(count);
  std::vector<NloFit> fits(count);
  parallel_for(
      count, options.threads,
      [&](std::size_t p) {
        paths[p] = resample_for_nlo(osm.paths[p], options.spacing_m);
        fits[p] = fit_nlo(paths[p], labels, options);
        if (options.filter_and_join && !fits[p].outside_labels) filter_curvature(paths[p], fits[p].offset_m);
      },
      [&](std::size_t done) {
        if (monitor) monitor->progress(static_cast<double>(done) / static_cast<double>(count), "refine");
      });

  std::vector<Polyline> lines;
  lines.reserve(count);
  for (std::size_t p = 0; p < count; ++p) lines.push_back(line_of(paths[p], fits[p].offset_m));
  if (options.filter_and_join) {
    std::vector<RoadChain> chains;
    chains.reserve(count);
    for (std::size_t p = 0; p < count; ++p) chains.push_back(chain_of(paths[p], osm.paths[p], p));
    bend_to_junctions(chains, place_junctions(chains, lines), lines);
  }

  RefinedRoads result{.roads = {.crs = osm.crs}};
  for (std::size_t p = 0; p < count; ++p) {
    const SolveSummary& solve = fits[p].solve;
    result.solve.converged = result.solve.converged && solve.converged;
    result.solve.iterations = std::max(result.solve.iterations, solve.iterations);
    result.solve.cost_before += solve.cost_before;
    result.solve.cost_after += solve.cost_after;
    report(osm.paths[p], paths[p], fits[p], result.findings);
    result.roads.paths.push_back(pack_nlo_path(osm.paths[p], paths[p], fits[p], lines[p]));
  }
  return result;
}

}  // namespace orthodrive
