// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/roads/dead_one_ways.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>
#include <string>
#include <tuple>

#include "orthodrive/model/roads/osm_node_id.hpp"

namespace orthodrive {
namespace {
constexpr double degree_rad = std::numbers::pi / 180.0;
constexpr double look_m = 15.0;  // over which a road has its direction at a node
// Roads that a map holds although a node lies beyond its border come from inside: all of them on one side of the node.
constexpr double one_side_rad = 210.0 * degree_rad;
constexpr double around_m = 300.0, widest_gap_rad = 60.0 * degree_rad;

/// A node where roads begin or end.
struct MeetingPlace {
  Vec2 p;
  std::vector<std::size_t> paths;
  std::vector<double> headings_rad;  ///< in which the roads lie
  int in = 0, out = 0;               ///< roads on which one comes there and drives away
};

/// The widest angle that holds none of the headings.
double widest_gap_of(std::vector<double> headings_rad) {
  constexpr double turn = 2.0 * std::numbers::pi;
  if (headings_rad.size() < 2) return turn;
  std::ranges::sort(headings_rad);
  double widest = headings_rad.front() + turn - headings_rad.back();
  for (std::size_t i = 1; i < headings_rad.size(); ++i)
    widest = std::max(widest, headings_rad[i] - headings_rad[i - 1]);
  return widest;
}

double heading_of(Vec2 d) { return std::atan2(d.y, d.x); }

/// In which a path lies, seen from its begin or end.
double heading_at(const RoadPath& path, bool at_end) {
  const Vec2 from = (at_end ? path.nodes.back() : path.nodes.front()).p;
  Vec2 to = from;
  for (std::size_t i = 1; i < path.nodes.size() && distance(from, to) < look_m; ++i)
    to = path.nodes[at_end ? path.nodes.size() - 1 - i : i].p;
  return heading_of(to - from);
}

bool is_for_one_direction(const RoadPath& path) { return path.oneway == Oneway::forward && path.lanes_backward == 0; }

/// By their nodes.
std::map<std::int64_t, MeetingPlace> meeting_places(const std::vector<RoadPath>& paths) {
  std::map<std::int64_t, MeetingPlace> places;
  for (std::size_t k = 0; k < paths.size(); ++k)
    for (const bool at_end : {false, true}) {
      if (paths[k].nodes.size() < 2) continue;
      const RoadNode& node = at_end ? paths[k].nodes.back() : paths[k].nodes.front();
      if (!is_osm_node(node.osm_node)) continue;
      MeetingPlace& place = places[node.osm_node];
      place.p = node.p;
      place.paths.push_back(k);
      place.headings_rad.push_back(heading_at(paths[k], at_end));
      if (at_end || !is_for_one_direction(paths[k])) ++place.in;
      if (!at_end || !is_for_one_direction(paths[k])) ++place.out;
    }
  for (const RoadPath& path : paths)
    for (std::size_t i = 1; i + 1 < path.nodes.size(); ++i)
      if (const auto place = places.find(path.nodes[i].osm_node); place != places.end())
        ++place->second.in, ++place->second.out;
  return places;
}

/// Whether other roads lie around a place.
bool lies_among_roads(const std::vector<RoadPath>& paths, const MeetingPlace& place) {
  std::vector<double> headings_rad;
  for (std::size_t k = 0; k < paths.size(); ++k) {
    if (std::ranges::find(place.paths, k) != place.paths.end()) continue;
    for (const RoadNode& node : paths[k].nodes)
      if (const Vec2 d = node.p - place.p; std::hypot(d.x, d.y) < around_m) headings_rad.push_back(heading_of(d));
  }
  return widest_gap_of(std::move(headings_rad)) <= widest_gap_rad;
}

std::string ids_of(const std::vector<RoadPath>& paths, const MeetingPlace& place) {
  std::set<std::int64_t> ids;
  for (const std::size_t k : place.paths) ids.insert(paths[k].osm_id);
  return fmt::format("{}", fmt::join(ids, ", "));
}
}  // namespace

void report_dead_one_ways(const RoadNetwork& roads, Findings& findings) {
  Findings found;
  for (const auto& [node, place] : meeting_places(roads.paths)) {
    if ((place.in > 0 && place.out > 0) || place.paths.size() < 2) continue;
    if (widest_gap_of(place.headings_rad) > one_side_rad && !lies_among_roads(roads.paths, place)) continue;
    const bool no_way_in = place.in == 0;
    found.push_back(
        {Severity::warning, no_way_in ? "osm.no_way_in" : "osm.no_way_out",
         fmt::format("one-way ways {} {} at node {}, and no road leads {} there: nobody can {} them here; turn one "
                     "round in the map or draw the road that is missing",
                     ids_of(roads.paths, place), no_way_in ? "begin" : "end", node, no_way_in ? "in" : "on",
                     no_way_in ? "enter" : "leave"),
         place.p.x, place.p.y});
  }
  std::ranges::sort(found, {}, [](const Finding& f) { return std::tie(f.x_m, f.y_m, f.code); });
  findings.insert(findings.end(), found.begin(), found.end());
}

}  // namespace orthodrive
