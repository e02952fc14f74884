// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/elevate/elevate_roads.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

namespace orthodrive {
namespace {

void append(Findings& findings, Findings&& more) {
  findings.insert(findings.end(), std::make_move_iterator(more.begin()), std::make_move_iterator(more.end()));
}

bool shows_banking(const std::vector<HeightGrid>& dtms, const BankingOptions& options) {
  return std::any_of(dtms.begin(), dtms.end(),
                     [&](const HeightGrid& dtm) { return dtm.frame.gsd_m <= options.coarsest_gsd_m; });
}

/// `roads` with the banking of `measured`, the same roads.
RoadNetwork with_banking(RoadNetwork roads, const RoadNetwork& measured) {
  for (std::size_t p = 0; p < roads.paths.size(); ++p)
    for (std::size_t n = 0; n < roads.paths[p].nodes.size(); ++n) {
      RoadNode& node = roads.paths[p].nodes[n];
      const RoadNode& from = measured.paths[p].nodes[n];
      node.banking = from.banking, node.crown = from.crown;
      node.sigma_banking = from.sigma_banking, node.banking_source = from.banking_source;
    }
  return roads;
}

}  // namespace

ElevateRoadsResult elevate_roads(const RoadNetwork& roads, const std::vector<HeightGrid>& dtms, const DriveLog& log,
                                 const ElevateRoadsOptions& options, Monitor* monitor) {
  EstimateProfilesResult profiles = estimate_profiles(roads, dtms, options.heights, monitor);
  BankingOptions of_banking = options.banking;
  of_banking.in_junction_planes = !options.heights.instead;
  if (of_banking.in_junction_planes && shows_banking(dtms, options.banking)) {
    // The plane of a junction follows from the banking of the roads through it and the gradients of those that end
    // there. So measured banking enters the heights, and their junction planes the final banking.
    const RoadNetwork measured = estimate_banking(profiles.roads, dtms, options.banking).roads;
    profiles = estimate_profiles(with_banking(roads, measured), dtms, options.heights, monitor);
  }
  EstimateBankingResult banking = estimate_banking(profiles.roads, dtms, of_banking);
  ElevateRoadsResult result{.roads = std::move(banking.roads),
                            .before = profiles.before,
                            .after = profiles.after,
                            .solve = profiles.solve,
                            .banking_measured_share = banking.measured_share,
                            .findings = std::move(profiles.findings)};
  append(result.findings, std::move(banking.findings));
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
