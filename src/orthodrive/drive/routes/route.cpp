// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/drive/routes/route.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <set>

#include "orthodrive/core/error.hpp"
#include "orthodrive/drive/routes/road_graph.hpp"
#include "orthodrive/geo/polygon.hpp"
#include "orthodrive/model/roads/highway_class.hpp"
#include "orthodrive/model/roads/road_network.hpp"
#include "roadquery/surface/road_surface.hpp"
#include "roadquery/text/text.hpp"

namespace orthodrive {
namespace {

using roadquery::Road;
using roadquery::RoadMap;
using Nodes = std::vector<int>;

constexpr double min_loop_m = 500.0, good_loop_m = 2000.0, max_loop_m = 5000.0;
constexpr std::size_t max_seeds = 24;  // roads from which loops are tried; the most important ones come first
constexpr std::size_t max_wanted_seeds = 200;
constexpr std::size_t compass_sectors = 16;
constexpr double min_end_m = 250.0, max_end_m = 1500.0;  // the far roads of a loop lie so far from where it starts
constexpr double detour_factor = 30.0;  // a metre off the roads that were asked for costs as much as so many on them
constexpr double repeat_factor = 8.0;   // the same for a metre on a road that was driven already
constexpr double max_detour_cost = 10.0 * max_loop_m;
constexpr double max_snap_m = 100.0;  // a via point has to be this near to a road

bool is_connecting(const Road& road) { return road.junction >= 0; }

double length_of(const RoadGraph& graph, const Nodes& nodes) {
  return std::accumulate(nodes.begin(), nodes.end(), 0.0,
                         [&](double sum, int n) { return sum + graph.road(n).length; });
}

/// Importance 0.1 .. 1; connecting roads count as much as their length, which is little.
double importance(const Road& road) { return (1.0 + road_rank(road.highway)) / 10.0; }

/// Length of the distinct roads of a way, each weighted.
double distinct_length(const RoadGraph& graph, const Nodes& nodes, const std::function<double(const Road&)>& weight) {
  std::set<int> seen;
  double sum = 0.0;
  for (const int n : nodes) {
    if (seen.insert(n / 2).second) sum += weight(graph.road(n)) * graph.road(n).length;
  }
  return sum;
}

/// Open nodes of roads (not of connecting roads) that pass the filter: important and long ones first.
Nodes seeds(const RoadGraph& graph, const std::function<bool(const Road&)>& filter) {
  Nodes result;
  for (int n = 0; n < graph.node_count(); ++n) {
    if (graph.is_open(n) && !is_connecting(graph.road(n)) && filter(graph.road(n))) result.push_back(n);
  }
  std::stable_sort(result.begin(), result.end(), [&](int a, int b) {
    const Road &p = graph.road(a), &q = graph.road(b);
    const int rank_p = road_rank(p.highway), rank_q = road_rank(q.highway);
    return rank_p != rank_q ? rank_p > rank_q : p.length > q.length;
  });
  return result;
}

NodeCosts costs_of(const RoadGraph& graph, const std::function<double(const Road&)>& cost) {
  NodeCosts costs(static_cast<std::size_t>(graph.node_count()));
  for (int n = 0; n < graph.node_count(); ++n) costs[static_cast<std::size_t>(n)] = cost(graph.road(n));
  return costs;
}

/// A way through the graph and how much it is liked.
struct Choice {
  Nodes nodes;
  bool closed = false;
  double score = -1.0;
  void take_better(Choice other) {
    if (other.score > score) *this = std::move(other);
  }
};

/// The loop, or else the open way, with most of the wanted roads.
Choice along_wanted(const RoadGraph& graph, const std::function<bool(const Road&)>& wanted, double detour) {
  const NodeCosts cost = costs_of(
      graph, [&](const Road& road) { return road.length * (is_connecting(road) || wanted(road) ? 1.0 : detour); });
  const auto weight = [&](const Road& road) { return wanted(road) ? 1.0 : 0.0; };
  Nodes tried = seeds(graph, wanted);
  if (tried.size() > max_wanted_seeds) tried.resize(max_wanted_seeds);
  Choice best;
  for (const int seed : tried) {
    const PathTree tree = shortest_paths(graph, seed, cost);
    if (const auto loop = tree.path_to(seed)) {
      const double want = distinct_length(graph, *loop, weight), all = length_of(graph, *loop);
      // A loop that is mostly detour is no answer to "drive this way".
      if (want >= 0.5 * all) best.take_better({*loop, true, want * want / std::max(all, 1e-9)});
    }
  }
  if (best.closed) return best;
  const NodeCosts strict = costs_of(
      graph, [&](const Road& road) { return is_connecting(road) || wanted(road) ? road.length : PathTree::unreached; });
  for (const int seed : tried) {
    const PathTree tree = shortest_paths(graph, seed, strict);
    for (int n = 0; n < graph.node_count(); ++n) {
      if (n / 2 == seed / 2 || is_connecting(graph.road(n))) continue;
      if (tree.cost[static_cast<std::size_t>(n)] == PathTree::unreached) continue;
      const double length_m = tree.cost[static_cast<std::size_t>(n)] + graph.road(seed).length;
      if (length_m <= best.score) continue;
      std::optional<Nodes> nodes = tree.path_to(n);
      if (!nodes) continue;
      nodes->insert(nodes->begin(), seed);
      best.take_better({std::move(*nodes), false, length_m});
    }
    best.take_better({{seed}, false, graph.road(seed).length});
  }
  return best;
}

Vec2 place(const Road& road) { return {road.plan.front().x, road.plan.front().y}; }

/// 1 for a circle, towards 0 for a loop that comes back beside the way it went: 4 pi area / length^2.
double roundness(const RoadGraph& graph, const Nodes& loop, double length_m) {
  Ring corners;
  for (const int n : loop) corners.push_back(place(graph.road(n)));
  return std::min(4.0 * std::numbers::pi * std::abs(signed_area_m2(corners)) / (length_m * length_m), 1.0);
}

/// 0 .. 1: important roads, a length in the wanted range, each road once, and an area that is driven around.
double loop_score(const RoadGraph& graph, const Nodes& loop) {
  const double all = length_of(graph, loop);
  const double distinct = distinct_length(graph, loop, [](const Road&) { return 1.0; });
  const double important = distinct_length(graph, loop, importance) / distinct;
  const double size = all < min_loop_m   ? 0.25 * all / min_loop_m
                      : all > max_loop_m ? 0.25 * max_loop_m / all
                                         : std::min(1.0, 0.5 + 0.5 * all / good_loop_m);
  const double once = distinct / all;
  const double round = loop.size() > 2 ? 0.2 + 0.8 * std::sqrt(roundness(graph, loop, all)) : 1.0;
  return important * size * once * once * round;
}

/// Goes on from the end of a way to `to`, on other roads where there are any. False when no way leads there.
bool go_on(const RoadGraph& graph, Nodes& way, int to, NodeCosts costs) {
  for (const int n : way) {
    for (const int used : {n, n ^ 1}) costs[static_cast<std::size_t>(used)] *= repeat_factor;
  }
  const auto more = shortest_paths(graph, way.back(), costs, max_detour_cost).path_to(to);
  if (more) way.insert(way.end(), more->begin(), more->end());
  return more.has_value();
}

/// Tries loops from important roads: out to a far road in each direction of the compass, on to another one a quarter
/// turn further (or not), and back.
Choice best_loop(const RoadGraph& graph) {
  const NodeCosts costs = costs_of(graph, [](const Road& road) { return road.length / importance(road); });
  Nodes tried = seeds(graph, [](const Road&) { return true; });
  if (tried.size() > max_seeds) tried.resize(max_seeds);

  Choice best;
  for (const int seed : tried) {
    const PathTree out = shortest_paths(graph, seed, costs, max_detour_cost);
    if (const auto loop = out.path_to(seed)) best.take_better({*loop, true, loop_score(graph, *loop)});
    // In each compass sector the cheapest road to reach that lies far enough for a good loop.
    std::array<int, compass_sectors> ends;
    ends.fill(-1);
    for (int n = 0; n < graph.node_count(); ++n) {
      const double there = out.cost[static_cast<std::size_t>(n)];
      const Vec2 d = place(graph.road(n)) - place(graph.road(seed));
      if (there == PathTree::unreached || is_connecting(graph.road(n)) || length(d) < min_end_m ||
          length(d) > max_end_m) {
        continue;
      }
      const double turn = std::atan2(d.y, d.x) / (2.0 * std::numbers::pi) + 0.5;
      int& end = ends[std::min(static_cast<std::size_t>(turn * compass_sectors), compass_sectors - 1)];
      if (end < 0 || there < out.cost[static_cast<std::size_t>(end)]) end = n;
    }
    for (std::size_t i = 0; i < ends.size(); ++i) {
      const int quarter = ends[(i + compass_sectors / 4) % compass_sectors];
      for (const int corner : {-1, quarter}) {
        if (ends[i] < 0) continue;
        std::optional<Nodes> loop = out.path_to(ends[i]);
        if (!loop || (corner >= 0 && !go_on(graph, *loop, corner, costs))) continue;
        if (!go_on(graph, *loop, seed, costs)) continue;
        const double score = loop_score(graph, *loop);
        best.take_better({std::move(*loop), true, score});
      }
    }
  }
  return best;
}

/// The longest of the shortest ways, for a map without any loop.
Choice best_open_way(const RoadGraph& graph) {
  return along_wanted(
      graph, [](const Road&) { return true; }, 1.0);
}

/// The roads with one of the names or OSM ids.
std::set<int> roads_called(const RoadMap& map, const std::string& route) {
  const auto matching = [&](const std::string& wanted) {
    std::set<int> ids;
    for (const Road& road : map.roads) {
      if (!is_connecting(road) &&
          (roadquery::lowered(road.name) == roadquery::lowered(wanted) || road.osm_id == wanted))
        ids.insert(road.id);
    }
    return ids;
  };
  std::set<int> ids = matching(route);  // a name may have a comma in it
  if (!ids.empty()) return ids;
  for (std::size_t begin = 0; begin <= route.size();) {
    const std::size_t end = std::min(route.find(',', begin), route.size());
    const std::size_t first = route.find_first_not_of(' ', begin),
                      last = route.find_last_not_of(' ', end == 0 ? 0 : end - 1);
    const std::string name = first < end ? route.substr(first, last - first + 1) : "";
    const std::set<int> more = matching(name);
    if (more.empty()) {
      std::set<std::string> names;
      for (const Road& road : map.roads) {
        if (!road.name.empty() && names.size() < 8) names.insert(road.name);
      }
      throw OptionError(fmt::format("no road is called '{}'{}", name,
                                    names.empty()
                                        ? "; the roads have no names, give the OSM id of a way"
                                        : fmt::format("; there are for example: {}", fmt::join(names, ", "))));
    }
    ids.insert(more.begin(), more.end());
    begin = end + 1;
  }
  return ids;
}

/// The road whose reference line passes nearest, in the directions that may be driven.
Nodes nodes_near(const RoadGraph& graph, Vec2 p) {
  constexpr double step_m = 2.0;
  double best = PathTree::unreached;
  int best_road = -1;
  for (int n = 0; n < graph.node_count(); n += 2) {
    const Road& road = graph.road(n);
    if (is_connecting(road) || (!graph.is_open(n) && !graph.is_open(n + 1))) continue;
    const int steps = 1 + static_cast<int>(road.length / step_m);
    for (int k = 0; k <= steps; ++k) {
      const auto q = roadquery::reference_point(road, road.length * k / steps);
      const double d = distance(p, {q.x, q.y});
      if (d < best) best = d, best_road = n / 2;
    }
  }
  if (best > max_snap_m) {
    throw OptionError(fmt::format(
        "--via {:.1f},{:.1f}: the nearest road is {:.0f} m away, need one within {:.0f} m; give metres of the site CRS",
        p.x, p.y, best, max_snap_m));
  }
  Nodes nodes;
  for (const int n : {2 * best_road, 2 * best_road + 1}) {
    if (graph.is_open(n)) nodes.push_back(n);
  }
  return nodes;
}

/// Shortest way past all points and back to the first: for each direction on the first road, the cheapest directions on
/// the others (dynamic programming).
Choice along_points(const RoadGraph& graph, const std::vector<Vec2>& via) {
  const NodeCosts cost = costs_of(graph, [](const Road& road) { return road.length; });
  std::vector<Nodes> stops;
  for (const Vec2 p : via) {
    Nodes nodes = nodes_near(graph, p);
    if (stops.empty() || stops.back() != nodes) stops.push_back(std::move(nodes));
  }
  if (stops.size() > 1 && stops.front() == stops.back()) stops.pop_back();
  const Nodes starts = stops.front();

  Choice best;
  std::size_t farthest = 0;
  for (const int start : starts) {
    std::map<int, Nodes> ways = {{start, {}}};  // cheapest way from start to each direction of the present stop
    for (std::size_t k = 1; k <= stops.size() && !ways.empty(); ++k) {
      const Nodes targets = k < stops.size() ? stops[k] : Nodes{start};
      std::map<int, Nodes> further;
      for (const auto& [from, way] : ways) {
        const PathTree tree = shortest_paths(graph, from, cost);
        for (const int to : targets) {
          const auto more = tree.path_to(to);
          if (!more) continue;
          Nodes longer = way;
          longer.insert(longer.end(), more->begin(), more->end());
          const auto known = further.find(to);
          if (known == further.end() || length_of(graph, longer) < length_of(graph, known->second))
            further[to] = std::move(longer);
        }
      }
      ways = std::move(further);
      if (!ways.empty()) farthest = std::max(farthest, k);
    }
    for (const auto& [to, way] : ways) best.take_better({way, true, 1.0 / length_of(graph, way)});
  }
  if (best.nodes.empty()) {
    const Vec2 lost = via[std::min(farthest + 1, via.size() - 1)];
    throw OptionError(
        farthest + 1 < stops.size()
            ? fmt::format("--via {:.1f},{:.1f}: no way leads there from the point before in the lanes' directions",
                          lost.x, lost.y)
            : "--via: no way leads back from the last point to the first in the lanes' directions");
  }
  return best;
}

std::string name_of(const RoadGraph& graph, const Nodes& nodes) {
  std::map<std::string, double> length_by_name;
  for (const int n : nodes) {
    const Road& road = graph.road(n);
    if (is_connecting(road)) continue;
    length_by_name[!road.name.empty()     ? road.name
                   : !road.osm_id.empty() ? "way " + road.osm_id
                                          : fmt::format("road {}", road.id)] += road.length;
  }
  std::vector<std::pair<double, std::string>> names;
  names.reserve(length_by_name.size());
  for (const auto& [name, length_m] : length_by_name) names.emplace_back(-length_m, name);
  std::sort(names.begin(), names.end());
  std::string text;
  for (std::size_t i = 0; i < std::min<std::size_t>(names.size(), 3); ++i)
    text += (i > 0 ? ", " : "") + names[i].second;
  return text + (names.size() > 3 ? ", ..." : "");
}

}  // namespace

Route find_route(const RoadMap& map, const RouteOptions& options) {
  const RoadGraph graph(map);
  Choice choice;
  if (!options.via.empty()) {
    choice = along_points(graph, options.via);
  } else if (options.route != "auto") {
    const std::set<int> ids = roads_called(map, options.route);
    choice = along_wanted(
        graph, [&](const Road& road) { return ids.contains(road.id); }, detour_factor);
  } else {
    choice = along_wanted(
        graph, [](const Road& road) { return is_raceway(road.highway); }, detour_factor);
    if (!choice.closed) choice = best_loop(graph);
    if (!choice.closed) choice = best_open_way(graph);
  }
  if (choice.nodes.empty()) throw Error("the road network has no lane that a car can drive on");

  // A loop starts on its longest road, where the start mark of a track would be; a way past points at the first of
  // them.
  if (choice.closed && options.via.empty()) {
    const auto longest = std::max_element(choice.nodes.begin(), choice.nodes.end(), [&](int a, int b) {
      const Road &p = graph.road(a), &q = graph.road(b);
      return p.length != q.length ? p.length < q.length : p.id > q.id;
    });
    std::rotate(choice.nodes.begin(), longest, choice.nodes.end());
  } else if (choice.closed) {
    std::rotate(choice.nodes.begin(), choice.nodes.end() - 1,
                choice.nodes.end());  // path_to() ends with the first road
  }
  Route route;
  route.closed = choice.closed;
  route.name = name_of(graph, choice.nodes);
  route.length_m = length_of(graph, choice.nodes);
  for (const int n : choice.nodes) route.steps.push_back(RoadGraph::step_of(n));
  return route;
}

}  // namespace orthodrive
