// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/elevate/logs/fuse_drive_logs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "orthodrive/core/error.hpp"
#include "orthodrive/elevate/logs/driven_samples.hpp"
#include "orthodrive/elevate/logs/fusion_problem.hpp"
#include "orthodrive/elevate/logs/solve_corrections.hpp"
#include "orthodrive/roads/path_crossings.hpp"

namespace orthodrive {
namespace {

using namespace elevate;

void check_log(const RoadNetwork& roads, const DriveLog& log, const FuseDriveLogsOptions& options) {
  if (!(log.crs == roads.crs))
    throw OptionError(fmt::format("drive logs: roads are in {} but the log in {}, need one CRS", roads.crs.definition,
                                  log.crs.definition));
  const DriveLogAccuracy& a = options.accuracy;
  for (const double value : {a.pitch_rad, a.roll_rad, a.climb_mps, a.lateral_mps2, a.height_m, a.height_drift_m,
                             a.height_drift_s, a.mounting_rad, options.terrain_error_length_m, options.banking_length_m,
                             options.unknown_sigma_banking_rad, options.unknown_sigma_z_m, options.knot_spacing_m,
                             options.suspension.pitch_sigma, options.suspension.roll_sigma})
    if (!(value > 0.0)) throw OptionError("drive logs: standard deviations, lengths and times must be positive");
  for (const RoadPath& path : roads.paths) {
    if (path.nodes.size() < 2)
      throw OptionError(fmt::format("drive logs: way {} has fewer than two nodes", path.osm_id));
    for (const RoadNode& node : path.nodes)
      if (std::isnan(node.z_m))
        throw OptionError(
            fmt::format("drive logs: way {} has no heights; run `orthodrive elevate` first", path.osm_id));
  }
}

/// Step 1: where each recording was driven.
std::vector<MatchLogResult> match_recordings(const RoadNetwork& roads, const DriveLog& log, Monitor* monitor,
                                             FuseDriveLogsResult& result) {
  const LogMatcher matcher(roads);
  std::vector<MatchLogResult> matches;
  for (std::size_t r = 0; r < log.recordings.size(); ++r) {
    const DriveRecording& recording = log.recordings[r];
    matches.push_back(matcher.match(recording, log.sources.at(recording.source)));
    const MatchLogResult& match = matches.back();
    result.length_m += match.length_m, result.matched_m += match.matched_m;
    result.findings.insert(result.findings.end(), match.findings.begin(), match.findings.end());
    if (monitor)
      monitor->progress(0.5 * static_cast<double>(r + 1) / static_cast<double>(log.recordings.size()), "drive logs");
  }
  return matches;
}

/// Step 2: means over 2 m of road.
std::vector<DrivenSample> samples_of(const LogChains& chains, const DriveLog& log,
                                     const std::vector<MatchLogResult>& matches) {
  std::vector<DrivenSample> samples;
  for (std::size_t r = 0; r < matches.size(); ++r) {
    const std::vector<DrivenSample> some = driven_samples(chains, log.recordings[r], r, matches[r].places);
    samples.insert(samples.end(), some.begin(), some.end());
  }
  return samples;
}

std::vector<RoughnessStretch> roughness_of(const RoadNetwork& roads, const DriveLog& log,
                                           const std::vector<MatchLogResult>& matches,
                                           const MeasureRoughnessOptions& options) {
  std::vector<MatchedRecording> matched;
  matched.reserve(matches.size());
  for (std::size_t r = 0; r < matches.size(); ++r) matched.push_back({&log.recordings[r], &matches[r].places});
  return measure_roughness(roads, matched, options);
}

void report_not_converged(const DriveLog& log, FuseDriveLogsResult& result) {
  if (result.solve.converged) return;
  const Vec2 start = log.recordings.front().poses.front().p;
  result.findings.push_back(
      {Severity::warning, "elevate.log_not_converged",
       fmt::format("the profile of the drive logs still moved after {} passes", result.solve.iterations), start.x,
       start.y});
}

/// Ways whose profile the logs move by more than three of its standard deviations.
void report_disagreement(const RoadNetwork& before, FuseDriveLogsResult& result) {
  struct Worst {
    double sigmas = 0.0, change_m = 0.0, count = 0.0;
    Vec2 p;
  };
  std::map<std::size_t, Worst> worst;
  for (const DrivenNode& driven : result.driven) {
    const RoadNode &old = before.paths[driven.path].nodes[driven.node],
                   &now = result.roads.paths[driven.path].nodes[driven.node];
    const double change_m = now.z_m - old.z_m, sigmas = old.sigma_z_m > 0.0 ? std::abs(change_m) / old.sigma_z_m : 0.0;
    if (sigmas <= 3.0) continue;
    Worst& w = worst[driven.path];
    w.count += 1.0;
    if (sigmas > w.sigmas) w.sigmas = sigmas, w.change_m = change_m, w.p = now.p;
  }
  for (const auto& [path, w] : worst)
    result.findings.push_back({Severity::warning, "elevate.log_disagrees",
                               fmt::format("way {}: drive logs move the profile by {:.2f} m, {:.1f} standard "
                                           "deviations of the terrain's, and by more "
                                           "than three at {:.0f} nodes",
                                           before.paths[path].osm_id, w.change_m, w.sigmas, w.count),
                               w.p.x, w.p.y});
}

/// Crossings of two levels that were high enough before.
void report_lost_clearance(const RoadNetwork& before, double clearance_m, FuseDriveLogsResult& result) {
  constexpr double tolerance_m = 0.1;
  for (const PathCrossing& crossing : find_crossings(result.roads)) {
    const auto room = [&](const RoadNetwork& roads) {
      const auto z = [](const RoadPath& path, std::size_t i, double f) {
        return path.nodes[i].z_m * (1.0 - f) + path.nodes[i + 1].z_m * f;
      };
      const RoadPath &a = roads.paths[crossing.path_a], &b = roads.paths[crossing.path_b];
      const double difference =
          z(a, crossing.segment_a, crossing.fraction_a) - z(b, crossing.segment_b, crossing.fraction_b);
      return a.layer > b.layer ? difference : -difference;
    };
    const RoadPath &a = result.roads.paths[crossing.path_a], &b = result.roads.paths[crossing.path_b];
    if (a.layer == b.layer || room(result.roads) >= clearance_m - tolerance_m ||
        room(before) < clearance_m - tolerance_m)
      continue;
    result.findings.push_back(
        {Severity::warning, "elevate.log_clearance",
         fmt::format("ways {} and {} are {:.1f} m apart in height since the drive logs count, {:.1f} m are wanted",
                     a.osm_id, b.osm_id, room(result.roads), clearance_m),
         crossing.p.x, crossing.p.y});
  }
}

}  // namespace

FuseDriveLogsResult fuse_drive_logs(const RoadNetwork& roads, const DriveLog& log, const FuseDriveLogsOptions& options,
                                    Monitor* monitor) {
  check_log(roads, log, options);
  FuseDriveLogsResult result{.roads = roads};
  const std::vector<MatchLogResult> matches = match_recordings(roads, log, monitor, result);
  const LogChains chains = make_log_chains(roads);
  const std::vector<DrivenSample> samples = samples_of(chains, log, matches);
  if (samples.empty()) return result;
  result.roughness = roughness_of(roads, log, matches, options.roughness);

  const FusionProblem problem = make_fusion_problem(roads, chains, log, samples, options);
  const Corrections corrections = solve_corrections(problem);
  result.solve = corrections.solve;
  write_corrections(problem, corrections, result);

  report_not_converged(log, result);
  report_disagreement(roads, result);
  report_lost_clearance(roads, options.clearance_m, result);
  if (monitor) monitor->progress(1.0, "drive logs");
  return result;
}

}  // namespace orthodrive
