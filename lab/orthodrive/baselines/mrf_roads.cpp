// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/baselines/mrf_roads.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "orthodrive/baselines/infer_mrf.hpp"
#include "orthodrive/baselines/mrf_surfaces.hpp"
#include "orthodrive/core/error.hpp"
#include "orthodrive/roads/join_junctions.hpp"

namespace orthodrive {
namespace {

constexpr double mrf_context_m = 2.0;  // width of the context strips
constexpr double least_mrf_width_m = 2.0;

using namespace baselines;

constexpr double min_seen = 0.5;           // share of a site's strip with a photo, below which it has no evidence
constexpr double unseen_finding_m = 20.0;  // shorter stretches without a photo are not worth a finding

void check_mrf(const RoadNetwork& osm, const MrfEvidenceSource& evidence, const MrfRoadsOptions& options) {
  if (!(osm.crs == evidence.crs))
    throw OptionError(fmt::format("mrf: roads are in {} but the photo in {}, need one CRS", osm.crs.definition,
                                  evidence.crs.definition));
  if (!(options.segment_m > 0.0) || !(options.search_radius_m >= 0.0) || !(options.step_m > 0.0) ||
      !(options.min_width_factor > 0.0) || !(options.max_width_factor >= options.min_width_factor))
    throw OptionError(
        "mrf: segment, step and width bounds must be positive, search radius and context not negative, "
        "the largest width factor not below the smallest");
  if (options.search_radius_m > 1000.0 * options.step_m)
    throw OptionError(fmt::format("mrf: {} offsets of {} m are too many, search less far or in larger steps",
                                  options.search_radius_m / options.step_m, options.step_m));
  for (const RoadPath& path : osm.paths) {
    if (path.nodes.size() < 2) throw OptionError(fmt::format("mrf: way {} has fewer than two nodes", path.osm_id));
    for (const RoadNode& node : path.nodes)
      if (!(node.width_m > 0.0))
        throw OptionError(fmt::format("mrf: way {} has no width, set default_width_m", path.osm_id));
  }
}

void check_mrf(const MrfWeights& w) {
  for (const double weight :
       {w.road, w.context, w.edge, w.smooth_offset, w.smooth_width, w.prior_offset, w.prior_width})
    if (!(weight >= 0.0)) throw OptionError("mrf: weights must not be negative");
}

MrfSite make_site(const ChainNode& a, const ChainNode& b, int layer, const MrfRoadsOptions& options) {
  MrfSite site{.a = a.base, .b = b.base, .layer = layer};
  site.length_m = distance(a.base, b.base);
  site.normal = site.length_m > 0.0 ? left_normal((b.base - a.base) * (1.0 / site.length_m)) : a.normal;
  site.along = left_normal(site.normal) * -1.0;
  site.share = a.evidence.both() * site.length_m / options.segment_m;
  const auto level = [&](double width_m) { return static_cast<int>(std::lround(width_m / (2.0 * options.step_m))); };
  site.input_width = std::max(1, level(a.input_width_m));
  const int narrowest = std::max(1, level(std::max(least_mrf_width_m, options.min_width_factor * a.input_width_m)));
  site.min_width = std::min(site.input_width, narrowest);
  site.max_width = std::max(site.input_width, level(options.max_width_factor * a.input_width_m));
  return site;
}

/// Stretches of a path that the photo does not show, and ways without any length.
void report_unseen(const RoadPath& path, const RoadChain& chain, const ChainPiece& piece,
                   std::span<const MrfSite> sites, Findings& findings) {
  if (chain.nodes[piece.last].s_m - chain.nodes[piece.first].s_m <= 0.0)
    findings.push_back({Severity::warning, "refine.no_length",
                        fmt::format("way {} has no length, left as it is", path.osm_id),
                        chain.nodes[piece.first].base.x, chain.nodes[piece.first].base.y});
  if (path.tunnel) return;
  const auto unseen = [&](std::size_t i) {
    return chain.nodes[i].evidence.both() > 0.0 && sites[i].sums.seen < min_seen;
  };
  for (std::size_t begin = piece.first; begin < piece.last;) {
    std::size_t end = begin;
    while (end < piece.last && unseen(end)) ++end;
    const double length = chain.nodes[end].s_m - chain.nodes[begin].s_m;
    const Vec2 middle = chain.nodes[(begin + end) / 2].base;
    if (length >= unseen_finding_m)
      findings.push_back(
          {Severity::warning, "refine.no_photo",
           fmt::format("way {}: no photo over {:.0f} m, kept near the OSM line with its width", path.osm_id, length),
           middle.x, middle.y});
    begin = std::max(end, begin + 1);
  }
}

std::vector<SegmentRectangle> rectangles_of(const MrfProblem& problem, const MrfChain& chain,
                                            const std::vector<MrfState>& states) {
  std::vector<SegmentRectangle> rectangles;
  for (std::size_t i = chain.first; i < chain.last; ++i) {
    const MrfSite& site = problem.sites[i];
    const Vec2 move = site.normal * problem.offset_m(states[i]);
    rectangles.push_back({site.a + move, site.b + move, site.normal, problem.width_m(states[i])});
  }
  return rectangles;
}

/// The path of a piece of a chain, in the path's own direction.
RoadPath pack_path(const RoadPath& input, const RoadChain& chain, const ChainPiece& piece, const NodeSurface& surface) {
  RoadPath path = input;
  path.nodes.clear();
  for (std::size_t i = piece.first; i <= piece.last; ++i) {
    const ChainNode& node = chain.nodes[i];
    path.nodes.push_back({.p = surface.line[i],
                          .osm_node = node.osm_node,
                          .offset_m = dot(surface.line[i] - node.base, node.normal) * (piece.reversed ? -1.0 : 1.0),
                          .width_m = surface.width_m[i]});
  }
  if (piece.reversed) std::reverse(path.nodes.begin(), path.nodes.end());
  const std::vector<double> s = arc_lengths_m(centerline(path));
  for (std::size_t i = 0; i < s.size(); ++i) path.nodes[i].s_m = s[i];
  return path;
}

MultiPolygon surface_of(const RoadPath& path, std::span<const SegmentRectangle> rectangles,
                        const MrfRoadsOptions& options) {
  MultiPolygon surface;
  if (options.polygons == RoadPolygons::smooth)
    for (Ring& cell : surface_cells(path)) surface.push_back({std::move(cell), {}});
  else if (!rectangles.empty())
    surface.push_back({simplified_outline(rectangles, options.simplify_m), {}});
  return surface;
}

}  // namespace

MrfRoadsProblem prepare_mrf_roads(const RoadNetwork& osm, const MrfEvidenceSource& evidence,
                                  const MrfRoadsOptions& options, Monitor* monitor) {
  check_mrf(osm, evidence, options);
  MrfRoadsProblem problem{
      .osm = osm, .chains = build_chains(osm, {.spacing_m = options.segment_m, .normal_window_m = options.segment_m})};
  mask_evidence(problem.chains, osm);
  MrfProblem& mrf = problem.mrf;
  mrf.step_m = options.step_m;
  mrf.max_offset = static_cast<int>(std::floor(options.search_radius_m / options.step_m + 1e-9));
  mrf.context = static_cast<int>(std::lround(mrf_context_m / options.step_m));

  std::vector<ProfileStrip> strips;
  for (const RoadChain& chain : problem.chains) {
    const std::size_t first = mrf.sites.size();
    for (const ChainPiece& piece : chain.pieces)
      for (std::size_t i = piece.first; i < piece.last; ++i)
        mrf.sites.push_back(make_site(chain.nodes[i], chain.nodes[i + 1], osm.paths[piece.path].layer, options));
    mrf.chains.push_back({first, mrf.sites.size(), chain.closed, chain.rank});
  }
  strips.reserve(mrf.sites.size());
  for (const MrfSite& site : mrf.sites)
    strips.push_back({site.a, site.b, site.normal, mrf.max_offset + site.max_width + mrf.context, site.share > 0.0});
  std::vector<CrossSums> sums =
      sum_across(strips, evidence, {.step_m = options.step_m, .threads = options.threads}, monitor);
  for (std::size_t i = 0; i < mrf.sites.size(); ++i) mrf.sites[i].sums = std::move(sums[i]);
  for (std::size_t c = 0; c < problem.chains.size(); ++c)
    for (const ChainPiece& piece : problem.chains[c].pieces)
      report_unseen(osm.paths[piece.path], problem.chains[c], piece, std::span(mrf.sites).subspan(mrf.chains[c].first),
                    problem.findings);
  for (MrfSite& site : mrf.sites)
    if (site.sums.seen < min_seen) site.share = 0.0;
  mrf.conflicts = find_conflicts(mrf, {.max_angle_deg = options.no_overlap_angle_deg});
  return problem;
}

MrfRoadsResult solve_mrf_roads(const MrfRoadsProblem& problem, const MrfRoadsOptions& options, Monitor* monitor) {
  check_mrf(options.weights);
  MrfProblem mrf = problem.mrf;
  mrf.weights = options.weights;
  InferMrfResult inferred = infer_mrf(mrf, {.max_sweeps = options.max_sweeps, .threads = options.threads}, monitor);

  const std::size_t count = problem.chains.size();
  std::vector<std::vector<SegmentRectangle>> rectangles(count);
  std::vector<NodeSurface> surfaces(count);
  std::vector<Polyline> lines(count);
  for (std::size_t c = 0; c < count; ++c) {
    rectangles[c] = rectangles_of(mrf, mrf.chains[c], inferred.states);
    const bool closed = problem.chains[c].closed;
    surfaces[c] = options.polygons == RoadPolygons::smooth
                      ? smooth_surface(rectangles[c], closed)
                      : simplified_surface(rectangles[c], closed, options.simplify_m);
    lines[c] = surfaces[c].line;
  }
  // The MRF does not tie roads together where they meet; only the segments next to a junction bend to it.
  bend_to_junctions(problem.chains, place_junctions(problem.chains, lines), lines, options.segment_m);

  MrfRoadsResult result{.roads = {.crs = problem.osm.crs, .paths = std::vector<RoadPath>(problem.osm.paths.size())},
                        .surfaces = std::vector<MultiPolygon>(problem.osm.paths.size()),
                        .energy_before = inferred.energies.front(),
                        .energy_after = inferred.energies.back(),
                        .energies = inferred.energies,
                        .sweeps = inferred.sweeps,
                        .converged = inferred.converged,
                        .findings = problem.findings};
  for (std::size_t c = 0; c < count; ++c)
    for (const ChainPiece& piece : problem.chains[c].pieces) {
      const RoadPath& input = problem.osm.paths[piece.path];
      const auto own = std::span(rectangles[c]).subspan(piece.first, piece.last - piece.first);
      result.surfaces[piece.path] = surface_of(pack_path(input, problem.chains[c], piece, surfaces[c]), own, options);
      result.roads.paths[piece.path] = pack_path(input, problem.chains[c], piece, {lines[c], surfaces[c].width_m});
    }
  if (!inferred.converged) {
    const Vec2 at = problem.chains.front().nodes.front().base;
    result.findings.push_back({Severity::info, "refine.not_converged",
                               fmt::format("roads still moved after {} sweeps of the MRF", inferred.sweeps), at.x,
                               at.y});
  }
  return result;
}

MrfRoadsResult refine_roads_mrf(const RoadNetwork& osm, const MrfEvidenceSource& evidence,
                                const MrfRoadsOptions& options, Monitor* monitor) {
  check_mrf(options.weights);
  return solve_mrf_roads(prepare_mrf_roads(osm, evidence, options, monitor), options, monitor);
}

}  // namespace orthodrive
