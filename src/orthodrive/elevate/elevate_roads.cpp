#include "orthodrive/elevate/elevate_roads.hpp"

#include <iterator>
#include <utility>

namespace orthodrive {
namespace {

void append(Findings& findings, Findings&& more) {
  findings.insert(findings.end(), std::make_move_iterator(more.begin()), std::make_move_iterator(more.end()));
}

}  // namespace

ElevateRoadsResult elevate_roads(const RoadNetwork& roads, const std::vector<HeightGrid>& dtms, const DriveLog& log,
                                 const ElevateRoadsOptions& options, Monitor* monitor) {
  EstimateProfilesResult profiles = estimate_profiles(roads, dtms, options.heights, monitor);
  EstimateCrossFallResult cross_fall = estimate_cross_fall(profiles.roads, dtms, options.cross_fall);
  ElevateRoadsResult result{.roads = std::move(cross_fall.roads),
                            .before = profiles.before,
                            .after = profiles.after,
                            .solve = profiles.solve,
                            .cross_fall_measured_share = cross_fall.measured_share,
                            .findings = std::move(profiles.findings)};
  append(result.findings, std::move(cross_fall.findings));
  if (log.recordings.empty()) return result;
  FuseDriveLogsOptions of_logs = options.logs;
  of_logs.clearance_m = options.heights.clearance_m;
  FuseDriveLogsResult fused = fuse_drive_logs(result.roads, log, of_logs, monitor);
  result.roads = std::move(fused.roads), result.roughness = std::move(fused.roughness);
  result.logged_m = fused.length_m, result.logged_on_roads_m = fused.matched_m;
  append(result.findings, std::move(fused.findings));
  return result;
}

}  // namespace orthodrive
