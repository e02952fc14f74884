// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/elevate/profiles/estimate_profiles.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

#include "orthodrive/core/error.hpp"
#include "orthodrive/elevate/profiles/network_profiles.hpp"
#include "orthodrive/elevate/terrain/grade_separations.hpp"

namespace orthodrive {
namespace {

using namespace elevate;

constexpr double clearance_tolerance_m = 0.01;
// Above what is asked: the network stage may differ by 2 cm at the nodes of both roads, and cubics between them.
constexpr double clearance_aim_m = 0.06;

void check(const RoadNetwork& roads, const std::vector<HeightGrid>& dtms, const ElevateOptions& options) {
  if (dtms.empty()) throw OptionError("elevate: no terrain model given");
  if (dtms.size() > 255)
    throw OptionError(fmt::format("elevate: {} terrain models given, at most 255 are taken", dtms.size()));
  for (const HeightGrid& dtm : dtms)
    if (!(dtm.crs == roads.crs))
      throw OptionError(fmt::format("elevate: roads are in {} but terrain in {}, need one CRS", roads.crs.definition,
                                    dtm.crs.definition));
  if (options.instead && !options.control_points.empty())
    throw OptionError("elevate: height control points are the default method's; leave them out, or --method");
  if (options.max_iterations < 1) throw OptionError("elevate: need at least one iteration");
  for (const RoadPath& path : roads.paths)
    if (path.nodes.size() < 2) throw OptionError(fmt::format("elevate: way {} has fewer than two nodes", path.osm_id));
}

void report(Findings& findings, Severity severity, const char* code, const RoadNode& node, std::string message) {
  findings.push_back({severity, code, std::move(message), node.p.x, node.p.y});
}

/// Ways tagged as bridge and as tunnel: below ground by a negative layer, else bridges.
RoadNetwork without_contradictions(RoadNetwork roads, Findings& findings) {
  for (RoadPath& path : roads.paths) {
    if (!path.bridge || !path.tunnel) continue;
    (path.layer < 0 ? path.bridge : path.tunnel) = false;
    report(findings, Severity::warning, "elevate.contradicting_tags", path.nodes[path.nodes.size() / 2],
           fmt::format("way {} is tagged as bridge and as tunnel, with layer {}: taken for a {}", path.osm_id,
                       path.layer, path.bridge ? "bridge" : "tunnel"));
  }
  return roads;
}

ProfileEnergy energy(const RoadNetwork& roads, const TerrainSamples& terrain, const NodeHeights& z_m) {
  double gradients = 0.0, errors = 0.0;
  std::size_t segments = 0, nodes = 0;
  for (std::size_t k = 0; k < roads.paths.size(); ++k) {
    const auto& samples = terrain.of_node[k];
    for (std::size_t n = 0; n < samples.size(); ++n) {
      if (!samples[n].is_road) continue;
      errors += std::pow(z_m[k][n] - samples[n].z_m, 2), ++nodes;
      if (n + 1 == samples.size() || !samples[n + 1].is_road) continue;
      const double run = distance(roads.paths[k].nodes[n].p, roads.paths[k].nodes[n + 1].p);
      if (run > 0.0) gradients += std::pow((z_m[k][n + 1] - z_m[k][n]) / run, 2), ++segments;
    }
  }
  return {segments > 0 ? gradients / static_cast<double>(segments) : 0.0,
          nodes > 0 ? errors / static_cast<double>(nodes) : 0.0};
}

// ---- methods to compare with

/// Heights, and gradients between the middles of the segments at both sides (eq. 3.14 has one for each segment).
void write_way_profiles(const NodeHeights& z_m, RoadNetwork& roads) {
  for (std::size_t k = 0; k < roads.paths.size(); ++k) {
    auto& nodes = roads.paths[k].nodes;
    for (std::size_t n = 0; n < nodes.size(); ++n) nodes[n].z_m = z_m[k][n], nodes[n].sigma_z_m = 0.0;
    for (std::size_t n = 0; n < nodes.size(); ++n) {
      const RoadNode &a = nodes[n > 0 ? n - 1 : 0], &b = nodes[std::min(n + 1, nodes.size() - 1)];
      const double run_m =
          (n > 0 ? distance(a.p, nodes[n].p) : 0.0) + (n + 1 < nodes.size() ? distance(nodes[n].p, b.p) : 0.0);
      nodes[n].gradient = run_m > 0.0 ? (b.z_m - a.z_m) / run_m : 0.0;
    }
  }
}

// ---- the network method

/// The road that gives way is held at the clearance from the present height of the other.
std::vector<HeightLimit> clearance_limits(const std::vector<GradeSeparation>& levels, const std::vector<bool>& tight,
                                          const NetworkProfiles& profiles, double clearance_m) {
  std::vector<HeightLimit> limits;
  for (std::size_t i = 0; i < levels.size(); ++i) {
    if (!tight[i]) continue;
    const PathCrossing& c = levels[i].crossing;
    const double z_a = profiles.height_m(c.path_a, c.segment_a, c.fraction_a),
                 z_b = profiles.height_m(c.path_b, c.segment_b, c.fraction_b);
    const bool a_moves = levels[i].a_is_above == levels[i].raise;
    HeightLimit limit{a_moves ? c.path_a : c.path_b, a_moves ? c.segment_a : c.segment_b,
                      a_moves ? c.fraction_a : c.fraction_b};
    const double other_m = a_moves ? z_b : z_a, wanted_m = clearance_m + clearance_aim_m;
    (levels[i].raise ? limit.low_m : limit.high_m) = other_m + (levels[i].raise ? wanted_m : -wanted_m);
    limits.push_back(limit);
  }
  return limits;
}

double room_m(const GradeSeparation& level, const NetworkProfiles& profiles) {
  const PathCrossing& c = level.crossing;
  const double rise_m =
      profiles.height_m(c.path_a, c.segment_a, c.fraction_a) - profiles.height_m(c.path_b, c.segment_b, c.fraction_b);
  return level.a_is_above ? rise_m : -rise_m;
}

void report_breaches(const RoadNetwork& roads, const NetworkProfiles& profiles, Findings& findings) {
  for (const LimitBreach& b : profiles.gradient_breaches())
    report(
        findings, Severity::info, "elevate.gradient_over_limit", roads.paths[b.path].nodes[b.node],
        fmt::format("way {} ({}): {:.1f} % steep along {:.0f} m, its class allows {:.0f} %", roads.paths[b.path].osm_id,
                    roads.paths[b.path].highway, 100.0 * b.worst, b.length_m, 100.0 * b.limit));
  for (const LimitBreach& b : profiles.curvature_breaches())
    report(
        findings, Severity::info, "elevate.curvature_over_limit", roads.paths[b.path].nodes[b.node],
        fmt::format("way {} ({}): vertical radius of {:.0f} m along {:.0f} m, its class asks for {:.0f} m",
                    roads.paths[b.path].osm_id, roads.paths[b.path].highway, 1.0 / b.worst, b.length_m, 1.0 / b.limit));
}

/// Stretches whose terrain the loss rejects: an untagged bridge or tunnel, or an error of the terrain model.
void report_off_terrain(const RoadNetwork& roads, const TerrainSamples& terrain, const std::vector<double>& sigma_m,
                        Findings& findings) {
  constexpr double least_m = 1.0, least_sigmas = 4.0, least_length_m = 10.0, least_spike_m = 5.0;
  for (std::size_t k = 0; k < roads.paths.size(); ++k) {
    const auto& nodes = roads.paths[k].nodes;
    std::size_t spikes = 0, worst_spike = 0;
    double worst_spike_m = 0.0;
    for (std::size_t n = 0; n < nodes.size(); ++n) {
      double worst_m = 0.0, length_m = 0.0;
      std::size_t worst = n, end = n;
      for (; end < nodes.size(); ++end) {
        const TerrainSample& sample = terrain.of_node[k][end];
        const double off_m = nodes[end].z_m - sample.z_m;
        if (!sample.is_road || std::abs(off_m) < std::max(least_m, least_sigmas * sigma_m[sample.source])) break;
        if (end > n) length_m += distance(nodes[end - 1].p, nodes[end].p);
        if (std::abs(off_m) > std::abs(worst_m)) worst_m = off_m, worst = end;
      }
      if (length_m >= least_length_m)
        report(findings, Severity::warning, "elevate.off_terrain", nodes[worst],
               fmt::format("way {} ({}) lies up to {:.1f} m {} the terrain along {:.0f} m: a {} without a tag, or an "
                           "error of the terrain model",
                           roads.paths[k].osm_id, roads.paths[k].highway, std::abs(worst_m),
                           worst_m > 0.0 ? "above" : "below", length_m, worst_m > 0.0 ? "bridge" : "tunnel"));
      else if (std::abs(worst_m) >= least_spike_m) {
        ++spikes;
        if (std::abs(worst_m) > std::abs(worst_spike_m)) worst_spike_m = worst_m, worst_spike = worst;
      }
      n = std::max(n, end);
    }
    if (spikes > 0)
      report(findings, Severity::info, "elevate.terrain_spikes", nodes[worst_spike],
             fmt::format(
                 "way {} ({}): the terrain is up to {:.1f} m {} the road at {} places shorter than {:.0f} m, taken for "
                 "errors of the terrain model",
                 roads.paths[k].osm_id, roads.paths[k].highway, std::abs(worst_spike_m),
                 worst_spike_m > 0.0 ? "below" : "above", spikes, least_length_m));
  }
}

/// Graduated non-convexity (network_profiles.hpp), then rounds that hold crossing roads apart. Returns the limits that
/// hold them.
std::vector<HeightLimit> solve_network(const std::vector<GradeSeparation>& levels, const ElevateOptions& options,
                                       Monitor* monitor, NetworkProfiles& profiles, SolveSummary& summary) {
  constexpr std::array loosenings{8.0, 3.0, 1.0, 1.0};  // noise and curvature are seen after the third and the fourth
  constexpr int clearance_passes = 5;  // one per level of a stack of bridges, and one for what they move
  int passes = 0;
  const auto solve = [&](const std::vector<HeightLimit>& limits, double loosening) {
    if (monitor)
      monitor->progress(static_cast<double>(passes++) / (loosenings.size() + clearance_passes + 2.0), "elevate");
    const RobustFit::Summary fit = profiles.solve(limits, options.max_iterations, loosening);
    if (summary.iterations == 0) summary.cost_before = fit.cost_before;
    summary.iterations += fit.iterations;
    summary.converged = fit.converged;
    summary.cost_after = fit.cost_after;
  };
  for (const double loosening : loosenings) {
    solve({}, loosening);
    if (loosening == 1.0) profiles.estimate_scales();
  }
  std::vector<HeightLimit> limits;
  std::vector<bool> tight(levels.size(), false);
  for (int pass = 0; pass < clearance_passes; ++pass) {
    solve(limits, 1.0);
    bool changed = false;
    for (std::size_t i = 0; i < levels.size(); ++i)
      if (levels[i].has_room && !levels[i].is_measured && room_m(levels[i], profiles) < options.clearance_m - 1e-6)
        changed = true, tight[i] = true;
    if (!changed) break;
    limits = clearance_limits(levels, tight, profiles, options.clearance_m);
  }
  return limits;
}

void report_clearance(const RoadNetwork& roads, const std::vector<GradeSeparation>& levels,
                      const NetworkProfiles& profiles, double clearance_m, Findings& findings) {
  const auto tell = [&](const GradeSeparation& level, double room) {
    findings.push_back(
        {Severity::warning, "elevate.low_clearance",
         fmt::format("way {} passes {:.1f} m over way {}{}, {:.1f} m are wanted", roads.paths[level.upper()].osm_id,
                     room, roads.paths[level.lower()].osm_id, level.is_along ? " along its length" : "", clearance_m),
         level.crossing.p.x, level.crossing.p.y});
  };
  std::map<std::pair<std::size_t, std::size_t>, std::pair<double, const GradeSeparation*>> lowest;  // along both ways
  for (const GradeSeparation& level : levels) {
    const double room = room_m(level, profiles);
    if (room >= clearance_m - clearance_tolerance_m) continue;
    if (!level.is_along) {
      tell(level, room);
      continue;
    }
    const auto at = lowest.try_emplace({level.upper(), level.lower()}, room, &level).first;
    if (room < at->second.first) at->second = {room, &level};
  }
  for (const auto& [ways, place] : lowest) tell(*place.second, place.first);
}

void estimate_network(const RoadNetwork& roads, TerrainSamples& terrain, const ElevateOptions& options,
                      Monitor* monitor, EstimateProfilesResult& result) {
  std::vector<GradeSeparation> levels = find_grade_separations(roads, terrain, result.findings);
  const ControlHeights control = match_control_points(roads, options.control_points, levels, result.findings);
  leave_out_structures(roads, untagged_spans(roads, levels), terrain);
  const NodeHeights start = start_heights(roads, terrain);
  const PathLinks links = link_path_ends(roads);
  const ProfileChains chains = make_profile_chains(roads, links);
  const std::vector<PathJunction> junctions = find_junctions(roads, links);
  NetworkProfiles profiles(roads, chains, junctions, terrain, control, start);
  const std::vector<HeightLimit> limits = solve_network(levels, options, monitor, profiles, result.solve);
  profiles.write(limits, result.roads);
  result.terrain_sigma_m = profiles.terrain_sigma_m();
  if (!result.solve.converged)
    report(result.findings, Severity::info, "elevate.not_converged", roads.paths.front().nodes.front(),
           fmt::format("no convergence after {} iterations", result.solve.iterations));
  report_breaches(roads, profiles, result.findings);
  report_off_terrain(result.roads, terrain, result.terrain_sigma_m, result.findings);
  report_clearance(roads, levels, profiles, options.clearance_m, result.findings);
  report_control_points(result.roads, control, terrain, result.terrain_sigma_m, result.findings);
}

NodeHeights heights_of(const RoadNetwork& roads) {
  NodeHeights z_m;
  for (const RoadPath& path : roads.paths) {
    auto& z = z_m.emplace_back();
    for (const RoadNode& node : path.nodes) z.push_back(node.z_m);
  }
  return z_m;
}

/// A node with a height has a banking: 0 until something else is known.
void set_banking_source(RoadNetwork& roads) {
  for (RoadPath& path : roads.paths)
    for (RoadNode& node : path.nodes)
      if (node.banking_source == BankingSource::unset) node.banking_source = BankingSource::none;
}

}  // namespace

EstimateProfilesResult estimate_profiles(const RoadNetwork& input, const std::vector<HeightGrid>& dtms,
                                         const ElevateOptions& options, Monitor* monitor) {
  check(input, dtms, options);
  EstimateProfilesResult result{.roads = input};
  if (input.paths.empty()) return result;
  const RoadNetwork roads = without_contradictions(input, result.findings);
  result.roads = roads;  // with the tags that its heights follow
  TerrainSamples terrain = sample_terrain(roads, dtms, options.sampling, options.threads);
  report_terrain(roads, terrain, result.findings);
  const NodeHeights as_sampled = start_heights(roads, terrain);
  if (options.instead) {
    leave_out_structures(roads, {}, terrain);
    const SolvedHeights profiles = options.instead(roads, as_sampled);
    result.solve = profiles.solve;
    write_way_profiles(profiles.z_m, result.roads);
  } else {
    estimate_network(roads, terrain, options, monitor, result);
  }
  set_banking_source(result.roads);
  result.before = energy(roads, terrain, as_sampled);
  result.after = energy(roads, terrain, heights_of(result.roads));
  return result;
}

}  // namespace orthodrive
