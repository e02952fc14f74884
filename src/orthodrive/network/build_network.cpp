// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/network/build_network.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "orthodrive/geo/geo_reference.hpp"
#include "orthodrive/network/junctions/archived_network.hpp"
#include "orthodrive/network/junctions/fit_junction_surfaces.hpp"
#include "orthodrive/network/lanes/lanes.hpp"
#include "orthodrive/network/line/ease_arms.hpp"
#include "orthodrive/network/line/leave_room.hpp"
#include "orthodrive/network/line/level_beside.hpp"
#include "orthodrive/network/line/raise_humps.hpp"
#include "orthodrive/network/line/road_cuts.hpp"
#include "orthodrive/network/paint/crosswalks.hpp"
#include "orthodrive/network/paint/follow_mark_rule.hpp"
#include "orthodrive/network/paint/gores.hpp"
#include "orthodrive/network/paint/hindrances.hpp"
#include "orthodrive/network/paint/lane_arrows.hpp"
#include "orthodrive/network/paint/mini_roundabout_marks.hpp"
#include "orthodrive/network/paint/narrow_sidewalks.hpp"
#include "orthodrive/network/paint/race_kerbs.hpp"
#include "orthodrive/network/paint/raise_sidewalks.hpp"
#include "orthodrive/network/paint/waiting_lines.hpp"
#include "orthodrive/network/roads/road_parts.hpp"
#include "orthodrive/network/topology/carriageways.hpp"
#include "orthodrive/network/topology/crossing_nodes.hpp"
#include "orthodrive/network/topology/mini_roundabouts.hpp"
#include "orthodrive/network/topology/rings.hpp"
#include "orthodrive/network/topology/roundabouts.hpp"

namespace orthodrive {
namespace {

using namespace network;

void set_bounds(roadquery::RoadMap& map) {
  constexpr double margin_m = 20.0;  // the carriageway beside the reference line, and the bulge of arcs between samples
  if (map.roads.empty()) return;
  map.south = map.west = INFINITY, map.north = map.east = -INFINITY;
  for (const roadquery::Road& road : map.roads)
    for (double s = 0.0; s <= road.length; s += margin_m) {
      const Vec2 p = pose_at(road.plan, s).p;
      map.west = std::min(map.west, std::floor(p.x - margin_m)),
      map.east = std::max(map.east, std::ceil(p.x + margin_m));
      map.south = std::min(map.south, std::floor(p.y - margin_m)),
      map.north = std::max(map.north, std::ceil(p.y + margin_m));
    }
}

/// Ways so short that the junctions at their ends took all of them, or the next road did.
void report_lost_ways(const RoadNetwork& roads, const roadquery::RoadMap& map, Findings& findings) {
  std::set<std::string> kept;
  for (const roadquery::Road& road : map.roads)
    if (road.junction < 0) kept.insert(road.osm_id);
  for (const RoadPath& path : roads.paths)
    if (!path.nodes.empty() && kept.count(std::to_string(path.osm_id)) == 0)
      findings.push_back(
          {Severity::info, "network.way_in_junction",
           fmt::format("way {} ({}) is so short that it has no road of its own: it lies inside a junction, or has the "
                       "lanes of the road that it goes on to",
                       path.osm_id, path.highway),
           path.nodes.front().p.x, path.nodes.front().p.y});
}

/// Junctions that are drivable but rarely are what they seem: a square drawn as one point, or an error of the map.
void report_many_roads(const std::vector<std::vector<JunctionEnd>>& ends, const roadquery::RoadMap& map,
                       Findings& findings) {
  constexpr std::size_t usual_roads = 6;
  for (const std::vector<JunctionEnd>& junction : ends) {
    if (junction.size() <= usual_roads) continue;
    Vec2 middle;
    for (const JunctionEnd& end : junction) {
      const roadquery::Road& road = map.roads[static_cast<std::size_t>(end.road)];
      middle =
          middle + pose_at(road.plan, end.at_end ? road.length : 0.0).p * (1.0 / static_cast<double>(junction.size()));
    }
    findings.push_back(
        {Severity::info, "network.many_roads",
         fmt::format("{} roads meet in one junction, every allowed movement crosses it straight", junction.size()),
         middle.x, middle.y});
  }
}

/// How well the chains follow their nodes, and what was found about them.
void add_up(const ChainGeometries& geometry, NetworkResult& result) {
  for (const ChainGeometry& chain : geometry) {
    result.max_plan_deviation_m = std::max(result.max_plan_deviation_m, chain.max_plan_deviation_m);
    result.max_elevation_error_m = std::max(result.max_elevation_error_m, chain.max_elevation_error_m);
    result.eased_nodes += chain.eased_nodes;
    result.chain_length_m += chain.length_m;
    result.chain_elements += chain.plan.size() / (chain.closed ? 2 : 1);  // closed chains go round twice
    result.findings.insert(result.findings.end(), chain.findings.begin(), chain.findings.end());
  }
}

/// The roads as they are built: what the map lacks or has twice is mended, every road has heights, room and a limit.
RoadNetwork prepared_roads(const RoadNetwork& input, const BuildNetworkOptions& options,
                           std::vector<MiniRoundaboutDisc>& discs, Findings& findings) {
  RoadNetwork roads = join_crossings(with_heights(input, findings), findings);
  roads = lay_mini_roundabouts(std::move(roads), options.driving_side, discs, findings);
  roads = close_roundabouts(std::move(roads), findings);
  report_turned_roundabouts(roads, options.driving_side, findings);
  roads = assume_roundabouts(std::move(roads), options.driving_side, findings);
  if (!has_oneway_tags(input)) roads = assume_carriageways(std::move(roads), options.driving_side, findings);
  roads = with_lane_room(std::move(roads), findings);
  settle_speeds(options.speed_laws, roads, findings);
  return roads;
}

}  // namespace

NetworkResult build_network(const RoadNetwork& input, const BuildNetworkOptions& options, Monitor* monitor) {
  NetworkResult result;
  const auto progress = [&](double fraction) {
    if (monitor) monitor->progress(fraction, "network");
  };
  progress(0.0);
  std::vector<MiniRoundaboutDisc> discs;
  RoadNetwork roads = prepared_roads(input, options, discs, result.findings);
  Topology topology = build_topology(roads, options.driving_side, result.findings);
  smooth_rings(topology.ring_of_piece, roads, topology);
  const PieceLines pieces = join_pieces(roads, topology, result.findings);

  ChainGeometries geometry(topology.chains.size());
  const FitChainOptions fit{options.plan_tolerance_m, options.elevation_tolerance_m, options.banking_tolerance_rad};
  shared_for(
      options.exchange, "chains", geometry.size(), options.threads,
      [&](std::size_t i) { geometry[ChainIndex(i)] = fit_chain(topology.chains[ChainIndex(i)], pieces, fit); },
      [&](auto& archive, std::size_t i) { archive(geometry[ChainIndex(i)]); },
      [&](std::size_t done) { progress(0.7 * static_cast<double>(done) / static_cast<double>(geometry.size())); });
  add_up(geometry, result);

  const JunctionPlan junctions = plan_junctions(roads, topology, geometry);
  std::vector<std::vector<double>> cuts = cut_roads(roads, topology, geometry, junctions, options.driving_side);
  ease_arms(roads, topology, junctions, cuts, geometry);
  end_before_roads(roads, topology, junctions, geometry, cuts);
  level_beside(roads, topology, junctions, cuts, geometry);
  leave_room_beside(roads, topology, junctions, cuts, geometry);
  const std::vector<RaisedHump> humps = raise_humps(roads, topology, junctions, cuts, geometry, result.findings);
  progress(0.9);
  result.map.name = options.name;
  if (!roads.crs.definition.empty()) result.map.geo_reference = geo_reference(roads.crs, bounds_of_roads(roads));
  const NetworkPlan plan{input, roads, topology, geometry, junctions, cuts, options};
  const std::vector<std::vector<JunctionEnd>> ends = add_roads(plan, result.map, result.findings);
  const JunctionParts parts = add_junctions(plan, ends, result.map, result.findings);
  narrow_sidewalks(result.map);
  add_race_kerbs(result.map, options.weather);
  add_gores(plan, ends, result.map);
  follow_mark_rule(rule_here(options.road_marks), result.map);
  if (options.junction_surfaces)
    result.junction_surfaces = add_junction_surfaces(result.map, parts.straight,
                                                     {.threads = options.threads,
                                                      .exchange = options.exchange,
                                                      .kerb_radius_m = parts.kerb_radius_m,
                                                      .paved = paved_middles(discs, result.map)});
  add_crosswalks(plan, parts.straight, result.map);
  add_waiting_lines(plan, ends, result.map);
  add_lane_arrows(plan, ends, result.map);
  add_mini_roundabout_marks(discs, result.map);
  add_hump_objects(humps, result.map);
  add_barriers(plan, result.map, result.findings);
  raise_sidewalks(result.map);
  report_many_roads(ends, result.map, result.findings);
  set_bounds(result.map);
  report_lost_ways(roads, result.map, result.findings);
  progress(1.0);
  return result;
}

}  // namespace orthodrive
