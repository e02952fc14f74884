// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/elevate/terrain/chain_stations.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "orthodrive/geo/angle.hpp"
#include "orthodrive/roads/path_links.hpp"

namespace orthodrive {
namespace {

constexpr double one_spot_m = 0.05;          // nodes nearer than this are one station
constexpr double heading_window_m = 8.0;     // refined lines wiggle by centimetres from node to node
constexpr double curvature_window_m = 20.0;  // a designed curve is longer; a drawn corner of one node is not a curve

StationChain gather(const RoadNetwork& roads, const PathChain& paths, std::size_t chain_index,
                    NetworkStations& network) {
  StationChain chain{.closed = paths.closed};
  for (const ChainPath& member : paths.paths) {
    const RoadPath& path = roads.paths[member.path];
    chain.rank = std::max(chain.rank, road_rank(path.highway));
    auto& places = network.of_node[member.path];
    places.resize(path.nodes.size());
    for (std::size_t i = 0; i < path.nodes.size(); ++i) {
      const std::size_t n = member.reversed ? path.nodes.size() - 1 - i : i;
      const RoadNode& node = path.nodes[n];
      const double step = chain.stations.empty() ? 0.0 : distance(chain.stations.back().p, node.p);
      // Where ways join they are one place, whatever little the lines disagree there.
      if (chain.stations.empty() || (i > 0 && step > one_spot_m)) {
        chain.stations.push_back({.p = node.p,
                                  .s_m = chain.length_m += step,
                                  .half_width_m = 0.5 * node.width_m,
                                  .z_m = node.z_m,
                                  .gradient = member.reversed ? -node.gradient : node.gradient,
                                  .path = member.path,
                                  .against = member.reversed});
      }
      chain.stations.back().bridge = chain.stations.back().bridge || path.bridge;
      chain.stations.back().tunnel = chain.stations.back().tunnel || path.tunnel;
      places[n] = {chain_index, chain.stations.size() - 1, member.reversed ? -1.0 : 1.0};
    }
  }
  if (chain.closed && chain.stations.size() > 3) {  // the last node is the first
    const std::size_t last = chain.stations.size() - 1;
    for (const ChainPath& member : paths.paths)
      for (StationOfNode& place : network.of_node[member.path])
        if (place.station == last) place.station = 0;
    chain.stations[0].bridge = chain.stations[0].bridge || chain.stations[last].bridge;
    chain.stations[0].tunnel = chain.stations[0].tunnel || chain.stations[last].tunnel;
    chain.stations.pop_back();
  } else {
    chain.closed = false;
  }
  return chain;
}

/// Heading of the line over s, all segments in a row; closed chains are laid out with a round before and after.
struct Headings {
  std::vector<double> s_m, rad, length_m;
};

Headings lay_out(const StationChain& chain) {
  const std::size_t n = chain.stations.size(), segments = chain.closed ? n : n - 1;
  Headings one;
  double heading = 0.0;
  for (std::size_t i = 0; i < segments; ++i) {
    const Vec2 d = chain.stations[(i + 1) % n].p - chain.stations[i].p;
    const double direction = std::atan2(d.y, d.x);
    heading = i == 0 ? direction : heading + wrapped_angle(direction - heading);
    one.s_m.push_back(chain.stations[i].s_m + 0.5 * length(d)), one.rad.push_back(heading),
        one.length_m.push_back(length(d));
  }
  if (!chain.closed) return one;
  const double turn = one.rad.back() + wrapped_angle(one.rad.front() - one.rad.back()) - one.rad.front();
  Headings all;
  for (const double round : {-1.0, 0.0, 1.0})
    for (std::size_t i = 0; i < segments; ++i) {
      all.s_m.push_back(one.s_m[i] + round * chain.length_m), all.rad.push_back(one.rad[i] + round * turn);
      all.length_m.push_back(one.length_m[i]);
    }
  return all;
}

/// A line through the headings around s, weighted by Epanechnikov's kernel (local linear regression): exact on arcs.
struct LocalLine {
  double heading_rad = 0.0, curvature_1pm = 0.0;
};
LocalLine fit_locally(const Headings& headings, double s_m, double window_m) {
  const auto begin = std::lower_bound(headings.s_m.begin(), headings.s_m.end(), s_m - window_m) - headings.s_m.begin();
  double w = 0.0, wx = 0.0, wy = 0.0, wxx = 0.0, wxy = 0.0;
  const auto add = [&](std::size_t i) {
    const double x = headings.s_m[i] - s_m,
                 kernel = headings.length_m[i] * std::max(1e-6, 1.0 - x * x / (window_m * window_m));
    w += kernel, wx += kernel * x, wy += kernel * headings.rad[i], wxx += kernel * x * x,
        wxy += kernel * x * headings.rad[i];
  };
  std::size_t count = 0;
  for (auto i = static_cast<std::size_t>(begin); i < headings.s_m.size() && headings.s_m[i] <= s_m + window_m; ++i)
    add(i), ++count;
  if (count == 0) {  // in the middle of a long segment, or beside it
    const std::size_t next = std::min(static_cast<std::size_t>(begin), headings.s_m.size() - 1);
    const std::size_t nearest = next > 0 && s_m - headings.s_m[next - 1] < headings.s_m[next] - s_m ? next - 1 : next;
    return {headings.rad[nearest], 0.0};
  }
  const double det = w * wxx - wx * wx;
  if (!(det > 1e-9 * w * w * window_m * window_m)) return {wy / w, 0.0};
  const double slope = (w * wxy - wx * wy) / det;
  return {(wy - slope * wx) / w, slope};
}

}  // namespace

double step_m(const StationChain& chain, std::size_t i) {
  return i + 1 < chain.stations.size() ? chain.stations[i + 1].s_m - chain.stations[i].s_m
                                       : chain.length_m - chain.stations[i].s_m;
}

NetworkStations make_stations(const RoadNetwork& roads) {
  NetworkStations network;
  network.of_node.resize(roads.paths.size());
  for (const PathChain& paths : chain_paths(roads, link_path_ends(roads))) {
    StationChain chain = gather(roads, paths, network.chains.size(), network);
    if (chain.stations.size() >= 2) {
      if (chain.closed)
        chain.length_m = chain.stations.back().s_m + distance(chain.stations.back().p, chain.stations.front().p);
      const Headings headings = lay_out(chain);
      for (Station& station : chain.stations) {
        const double heading = fit_locally(headings, station.s_m, heading_window_m).heading_rad;
        station.along = {std::cos(heading), std::sin(heading)};
        station.curvature_1pm = fit_locally(headings, station.s_m, curvature_window_m).curvature_1pm;
      }
    } else {
      chain.stations.front().along = {1.0, 0.0};
    }
    network.chains.push_back(std::move(chain));
  }
  return network;
}

}  // namespace orthodrive
