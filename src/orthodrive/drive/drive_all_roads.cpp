#include "orthodrive/drive/drive_all_roads.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "orthodrive/core/error.hpp"
#include "orthodrive/core/parallel.hpp"
#include "orthodrive/drive/route_cover.hpp"
#include "roadquery/road_query.hpp"

namespace orthodrive {
namespace {

constexpr double same_place_m = 10.0;
constexpr double least_route_m = 12.0;  // the car has to fit on it

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
  result.finished += drive.finished ? 1 : 0;
  result.length_m += drive.length_m;
  result.driven_s += drive.driven_s, result.wall_s += drive.wall_s;
  result.max_vertical_mps2 = std::max(result.max_vertical_mps2, drive.max_vertical_mps2);
  result.max_height_step_m = std::max(result.max_height_step_m, drive.max_height_step_m);
  result.max_line_error_m = std::max(result.max_line_error_m, drive.max_line_error_m);
  result.tyre_queries += drive.tyre_queries, result.tyre_misses += drive.tyre_misses;
  add_distinct(drive.findings, result.findings);
}

}  // namespace

AllRoadsResult drive_all_roads(const roadquery::RoadMap& map, const DriveOptions& options, int threads,
                               Monitor* monitor) {
  const std::vector<Route> routes = routes_over_all_roads(map);
  if (routes.empty()) throw Error("the road network has no lane that a car can drive on");
  const roadquery::RoadQuery query(map);
  const EnvelopeTable envelope(options.car);
  DriveOptions each = options;
  each.racing = false, each.laps = 1, each.keep_samples = false;
  std::vector<std::optional<DriveResult>> drives(routes.size());
  parallel_for(
      routes.size(), threads,
      [&](std::size_t i) {
        if (routes[i].length_m >= least_route_m) drives[i] = drive_route(query, routes[i], each, envelope);
      },
      [&](std::size_t done) {
        if (monitor != nullptr)
          monitor->progress(static_cast<double>(done) / static_cast<double>(routes.size()), "drive all roads");
      });
  AllRoadsResult result;
  result.routes = static_cast<int>(routes.size());
  for (std::size_t i = 0; i < routes.size(); ++i) {
    result.routes_m += routes[i].length_m;
    if (drives[i])
      add(*drives[i], result);
    else
      ++result.too_short;
  }
  result.off_road_places = count(result.findings, "drive.off_road");
  result.jolt_places = count(result.findings, "drive.jolt");
  result.bump_places = count(result.findings, "drive.bump");
  return result;
}

}  // namespace orthodrive
