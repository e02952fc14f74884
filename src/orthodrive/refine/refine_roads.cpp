#include "orthodrive/refine/refine_roads.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "orthodrive/core/error.hpp"
#include "orthodrive/core/parallel.hpp"
#include "orthodrive/refine/cross_profiles.hpp"
#include "orthodrive/refine/fit_chain.hpp"
#include "orthodrive/refine/join_junctions.hpp"
#include "orthodrive/refine/road_chains.hpp"
#include "orthodrive/refine/search_offsets.hpp"

namespace orthodrive {
namespace {

constexpr double unseen_finding_m = 20.0;  // shorter stretches without a road in the labels are not worth a finding

struct RefinedChain {
  ChainFit fit;
  std::vector<bool> road_near;  // one a segment
};

void check(const RoadNetwork& osm, const LabelMap& labels, const RefineRoadsOptions& options) {
  if (!(osm.crs == labels.crs))
    throw OptionError(fmt::format("refine: roads are in {} but labels in {}, need one CRS", osm.crs.definition, labels.crs.definition));
  if (!(options.spacing_m > 0.0) || !(options.search_radius_m > 0.0) || !(options.strip_m > 0.0) ||
      !(options.min_width_factor > 0.0) || !(options.max_width_factor > options.min_width_factor))
    throw OptionError("refine: spacing, search radius, strip and width factors must be positive, the largest factor above the smallest");
  for (const RoadPath& path : osm.paths) {
    if (path.nodes.size() < 2) throw OptionError(fmt::format("refine: way {} has fewer than two nodes", path.osm_id));
    for (const RoadNode& node : path.nodes)
      if (!(node.width_m > 0.0)) throw OptionError(fmt::format("refine: way {} has no width, set default_width_m", path.osm_id));
  }
}

RefinedChain refine_chain(const RoadChain& chain, const LabelMap& labels, const RefineRoadsOptions& options) {
  double widest_m = 0.0;
  for (const ChainNode& node : chain.nodes) widest_m = std::max(widest_m, node.input_width_m);
  // The search looks at strips wider than those of the fit.
  const double half_m = options.search_radius_m + 0.5 * options.max_width_factor * widest_m + 2.0 * options.strip_m;
  const CrossProfiles profiles = sample_cross_profiles(chain, labels, half_m);
  RefinedChain refined{.fit = fit_chain(chain, profiles, search_offsets(chain, profiles, options), options)};
  for (std::size_t row = 0; row < profiles.road_near.size(); row += rows_per_segment)
    refined.road_near.push_back(profiles.road_near[row] || profiles.road_near[row + rows_per_segment - 1]);
  return refined;
}

/// Long stretches where the labels show no road although they should: tunnels are not expected to be seen.
void report_unseen(const RoadChain& chain, const RefinedChain& refined, const RoadNetwork& osm, Findings& findings) {
  for (const ChainPiece& piece : chain.pieces) {
    if (osm.paths[piece.path].tunnel) continue;
    for (std::size_t begin = piece.first; begin < piece.last; ++begin) {
      if (refined.road_near[begin]) continue;
      std::size_t end = begin;
      while (end < piece.last && !refined.road_near[end]) ++end;
      const double length = chain.nodes[end].s_m - chain.nodes[begin].s_m;
      const Vec2 middle = chain.nodes[(begin + end) / 2].base;
      if (length >= unseen_finding_m)
        findings.push_back({Severity::warning, "refine.no_road_seen",
                            fmt::format("way {}: the labels show no road over {:.0f} m, kept near the OSM line with the default width",
                                        osm.paths[piece.path].osm_id, length),
                            middle.x, middle.y});
      begin = end;
    }
  }
}

/// The path of a piece of a chain, in the path's own direction.
RoadPath pack_path(const RoadPath& input, const RoadChain& chain, const ChainPiece& piece, const ChainFit& fit, const Polyline& line) {
  RoadPath path = input;
  path.nodes.clear();
  for (std::size_t i = piece.first; i <= piece.last; ++i) {
    const ChainNode& node = chain.nodes[i];
    path.nodes.push_back({.p = line[i],
                          .osm_node = node.osm_node,
                          .offset_m = dot(line[i] - node.base, node.normal) * (piece.reversed ? -1.0 : 1.0),
                          .width_m = fit.shape.width_m[i],
                          .sigma_offset_m = fit.sigma_offset_m[i],
                          .sigma_width_m = fit.sigma_width_m[i]});
  }
  if (piece.reversed) std::reverse(path.nodes.begin(), path.nodes.end());
  const std::vector<double> s = arc_lengths_m(centerline(path));
  for (std::size_t i = 0; i < s.size(); ++i) path.nodes[i].s_m = s[i];
  return path;
}

}  // namespace

RefineRoadsResult refine_roads(const RoadNetwork& osm, const LabelMap& labels, const RefineRoadsOptions& options, Monitor* monitor) {
  check(osm, labels, options);
  std::vector<RoadChain> chains = build_chains(osm, {.spacing_m = options.spacing_m});
  mask_evidence(chains, osm);

  std::vector<RefinedChain> refined(chains.size());
  parallel_for(
      chains.size(), options.threads, [&](std::size_t c) { refined[c] = refine_chain(chains[c], labels, options); },
      [&](std::size_t done) {
        if (monitor) monitor->progress(static_cast<double>(done) / static_cast<double>(chains.size()), "refine");
      });

  std::vector<Polyline> lines(chains.size());
  for (std::size_t c = 0; c < chains.size(); ++c)
    for (std::size_t i = 0; i < chains[c].nodes.size(); ++i)
      lines[c].push_back(chains[c].nodes[i].base + chains[c].nodes[i].normal * refined[c].fit.shape.offset_m[i]);
  join_junctions(chains, lines);

  RefineRoadsResult result{.roads = {.crs = osm.crs, .paths = std::vector<RoadPath>(osm.paths.size())}};
  for (std::size_t c = 0; c < chains.size(); ++c) {
    const ChainFit& fit = refined[c].fit;
    result.solve.converged = result.solve.converged && fit.solve.converged;
    result.solve.iterations = std::max(result.solve.iterations, fit.solve.iterations);
    result.solve.cost_before += fit.solve.cost_before;
    result.solve.cost_after += fit.solve.cost_after;
    report_unseen(chains[c], refined[c], osm, result.findings);
    if (!fit.solve.converged) {
      const ChainPiece& piece = chains[c].pieces.front();
      const Vec2 middle = lines[c][lines[c].size() / 2];
      result.findings.push_back({Severity::info, "refine.not_converged",
                                 fmt::format("way {}: no convergence after {} iterations", osm.paths[piece.path].osm_id, fit.solve.iterations),
                                 middle.x, middle.y});
    }
    for (const ChainPiece& piece : chains[c].pieces)
      result.roads.paths[piece.path] = pack_path(osm.paths[piece.path], chains[c], piece, fit, lines[c]);
  }
  return result;
}

}  // namespace orthodrive
