// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/drive/drive_all_roads.hpp"

#include <algorithm>
#include <cmath>

#include "orthodrive/core/error.hpp"
#include "orthodrive/core/parallel.hpp"
#include "orthodrive/drive/line/lane_path.hpp"
#include "orthodrive/drive/routes/route_cover.hpp"
#include "roadquery/query/road_query.hpp"

namespace orthodrive {
namespace {

constexpr double same_place_m = 10.0;

/// Adds what no earlier finding of the same kind lies beside. That a route is open is no news here.
void add_distinct(const Findings& findings, Findings& out) {
  for (const Finding& finding : findings) {
    if (finding.code == "drive.open_route") continue;
    const bool known = std::any_of(out.begin(), out.end(), [&](const Finding& f) {
      return f.code == finding.code && std::hypot(f.x_m - finding.x_m, f.y_m - finding.y_m) < same_place_m;
    });
    if (!known) out.push_back(finding);
  }
}

int count(const Findings& findings, const char* code) {
  return static_cast<int>(
      std::count_if(findings.begin(), findings.end(), [&](const Finding& f) { return f.code == code; }));
}

void add(const DriveResult& drive, AllRoadsResult& result) {
  result.length_m += drive.length_m;
  result.driven_s += drive.driven_s, result.wall_s += drive.wall_s;
  result.max_vertical_mps2 = std::max(result.max_vertical_mps2, drive.max_vertical_mps2);
  result.max_height_step_m = std::max(result.max_height_step_m, drive.max_height_step_m);
  result.max_line_error_m = std::max(result.max_line_error_m, drive.max_line_error_m);
  result.tyre_queries += drive.tyre_queries, result.tyre_misses += drive.tyre_misses;
  add_distinct(drive.findings, result.findings);
}

/// What is left of a route after a step, from the next road outside junctions on.
Route rest_of(const roadquery::RoadMap& map, const Route& route, int step) {
  const auto road_of = [&](const RouteStep& s) -> const roadquery::Road& {
    return map.roads[static_cast<std::size_t>(s.road)];
  };
  auto first = route.steps.begin() + step + 1;
  while (first != route.steps.end() && road_of(*first).junction >= 0) ++first;
  Route rest{{first, route.steps.end()}, false, route.name, 0.0};
  for (const RouteStep& s : rest.steps) rest.length_m += road_of(s).length;
  return rest;
}

/// Drives a route; after a bend that the car cannot take it begins anew.
std::vector<DriveResult> drive_parts(const roadquery::RoadQuery& query, Route route, const DriveOptions& options,
                                     const EnvelopeTable& envelope) {
  std::vector<DriveResult> parts;
  do {
    parts.push_back(drive_route(query, route, options, envelope));
    if (parts.back().finished_before_step < 0) break;
    route = rest_of(query.map(), route, parts.back().finished_before_step);
  } while (route.length_m >= least_route_m);
  return parts;
}

}  // namespace

AllRoadsResult drive_all_roads(const roadquery::RoadMap& map, const DriveOptions& options, int threads,
                               Monitor* monitor) {
  const std::vector<Route> routes = routes_over_all_roads(map);
  if (routes.empty()) throw Error("the road network has no lane that a car can drive on");
  const roadquery::RoadQuery query(map);
  const EnvelopeTable envelope(options.car);
  DriveOptions each = options;
  each.style = DrivingStyle::road, each.laps = 1, each.keep_samples = false;
  std::vector<std::vector<DriveResult>> drives(routes.size());
  parallel_for(
      routes.size(), threads, [&](std::size_t i) { drives[i] = drive_parts(query, routes[i], each, envelope); },
      [&](std::size_t done) {
        if (monitor != nullptr)
          monitor->progress(static_cast<double>(done) / static_cast<double>(routes.size()), "drive all roads");
      });
  AllRoadsResult result;
  result.routes = static_cast<int>(routes.size());
  for (std::size_t i = 0; i < routes.size(); ++i) {
    result.routes_m += routes[i].length_m;
    if (drives[i].front().line.points.empty()) ++result.too_short;
    // A route that goes on behind a bend that is too tight counts as finished when its last part does.
    if (drives[i].back().finished) ++result.finished;
    for (const DriveResult& part : drives[i]) add(part, result);
  }
  result.off_road_places = count(result.findings, "drive.off_road");
  result.jolt_places = count(result.findings, "drive.jolt");
  result.too_tight_places = count(result.findings, "drive.too_tight");
  result.bump_places = count(result.findings, "drive.bump");
  return result;
}

}  // namespace orthodrive
