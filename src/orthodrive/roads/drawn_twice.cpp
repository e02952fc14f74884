// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/roads/drawn_twice.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <map>
#include <numeric>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "orthodrive/model/roads/osm_node_id.hpp"

namespace orthodrive {
namespace {

/// A node by its id, or by its place to the centimetre where the border of the area has cut the way.
using NodeKey = std::tuple<bool, std::int64_t, std::int64_t>;
/// Between two neighbouring nodes of one level.
using StretchKey = std::tuple<NodeKey, NodeKey, int, bool, bool>;

NodeKey node_key(const RoadNode& node) {
  if (is_osm_node(node.osm_node)) return {true, node.osm_node, 0};
  return {false, std::llround(node.p.x * 100.0), std::llround(node.p.y * 100.0)};
}

struct Stretch {
  std::size_t path = 0;  ///< that draws it and stays
  bool along = true;     ///< from the lesser key to the greater one
};

/// Which stretches of a path others draw.
struct DoubledPath {
  std::vector<bool> doubled;  ///< for each stretch
  std::size_t count = 0, first = 0;
  std::size_t by = 0;         ///< path that draws the first of them
  bool by_one_alone = true;   ///< `by` draws all of them
  bool against_alone = true;  ///< and runs the other way along all of them
};

class DrawnStretches {
 public:
  explicit DrawnStretches(const RoadNetwork& roads) : roads_(roads) {}

  /// Takes what nobody has drawn yet for the path.
  DoubledPath take(std::size_t index) {
    const RoadPath& path = roads_.paths[index];
    DoubledPath result{.doubled = std::vector<bool>(path.nodes.size() - 1, false)};
    for (std::size_t i = 0; i + 1 < path.nodes.size(); ++i) {
      NodeKey a = node_key(path.nodes[i]), b = node_key(path.nodes[i + 1]);
      const bool along = a < b;
      if (!along) std::swap(a, b);
      const auto [at, is_new] =
          drawn_.try_emplace(StretchKey{a, b, path.layer, path.bridge, path.tunnel}, Stretch{index, along});
      if (is_new) continue;
      const Stretch& other = at->second;
      if (result.count == 0) result.first = i, result.by = other.path;
      result.doubled[i] = true, ++result.count;
      result.by_one_alone = result.by_one_alone && other.path == result.by;
      result.against_alone = result.against_alone && other.along != along;
    }
    return result;
  }

 private:
  const RoadNetwork& roads_;
  std::map<StretchKey, Stretch> drawn_;
};

/// Higher classes first, roads for both directions before one-way roads, then as they come.
std::vector<std::size_t> by_importance(const std::vector<RoadPath>& paths) {
  std::vector<std::size_t> order(paths.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, [&](std::size_t a, std::size_t b) {
    const int rank_a = road_rank(paths[a].highway), rank_b = road_rank(paths[b].highway);
    if (rank_a != rank_b) return rank_a > rank_b;
    return paths[a].oneway == Oneway::no && paths[b].oneway != Oneway::no;
  });
  return order;
}

/// Who may use the lanes of a one-way road, lane by lane.
std::string lane_uses_of(const RoadPath& path) {
  if (!path.use_forward.empty() || path.use.empty()) return path.use_forward;
  std::string uses = path.use;
  for (int i = 1; i < path.lanes; ++i) uses += "|" + path.use;
  return uses;
}

std::string speeds_of(const RoadPath& path) {
  if (!path.speeds_forward.empty() || path.speed_limit_kmh == 0.0) return path.speeds_forward;
  return fmt::format("{:g}", path.speed_limit_kmh);
}

/// Makes one road for both directions of two one-way ones; `back` runs against `path`.
void take_direction(RoadPath& path, const RoadPath& back) {
  const bool is_told = path.lanes > 0 || back.lanes > 0 || path.use != back.use;
  path.oneway = Oneway::no;
  path.use_backward = path.use != back.use ? lane_uses_of(back) : back.use_forward;
  if (path.use != back.use) path.use_forward = lane_uses_of(path), path.use.clear();
  path.turn_backward = back.turn_forward, path.widths_backward = back.widths_forward;
  path.speeds_forward = speeds_of(path), path.speeds_backward = speeds_of(back);
  path.speed_limit_kmh = std::max(path.speed_limit_kmh, back.speed_limit_kmh);
  path.lanes_forward = is_told ? std::max(1, path.lanes) : 0;
  path.lanes_backward = is_told ? std::max(1, back.lanes) : 0;
  path.lanes = path.lanes_forward + path.lanes_backward;
  path.placement = {};
  if (path.width_source == WidthSource::tag) return;
  const double width_m = default_width_m(path.highway, path.lanes, path.oneway);
  for (RoadNode& node : path.nodes) node.width_m = width_m;
}

/// The pieces of a path that nobody else draws.
std::vector<RoadPath> rest_of(const RoadPath& path, const std::vector<bool>& doubled, int& next_part) {
  std::vector<RoadPath> pieces;
  for (std::size_t i = 0; i < doubled.size(); ++i) {
    if (doubled[i]) continue;
    if (i == 0 || doubled[i - 1]) {
      RoadPath piece = path;
      piece.part = pieces.empty() ? path.part : next_part++;
      piece.nodes = {path.nodes[i]};
      piece.nodes.front().s_m = 0.0;
      pieces.push_back(std::move(piece));
    }
    std::vector<RoadNode>& nodes = pieces.back().nodes;
    const double length_m = path.nodes[i + 1].s_m - path.nodes[i].s_m;
    nodes.push_back(path.nodes[i + 1]);
    nodes.back().s_m = nodes[nodes.size() - 2].s_m + length_m;
  }
  return pieces;
}

void report(const RoadPath& path, const DoubledPath& twice, const RoadPath& by, const char* what, Findings& findings) {
  double length_m = 0.0;
  for (std::size_t i = 0; i < twice.doubled.size(); ++i)
    if (twice.doubled[i]) length_m += path.nodes[i + 1].s_m - path.nodes[i].s_m;
  const Vec2 where = (path.nodes[twice.first].p + path.nodes[twice.first + 1].p) * 0.5;
  findings.push_back({Severity::warning, "osm.drawn_twice",
                      fmt::format("way {}: {:.0f} m of it run over the nodes of {}: {}", path.osm_id, length_m,
                                  &by == &path ? "its own other part" : fmt::format("way {}", by.osm_id), what),
                      where.x, where.y});
}

/// Ways that are gone, by the one that stays in their place.
void rename_ways(RoadNetwork& roads, const std::map<std::int64_t, std::int64_t>& stays) {
  const auto rename = [&](std::int64_t& way) {
    if (const auto at = stays.find(way); at != stays.end()) way = at->second;
  };
  for (TurnRestriction& restriction : roads.restrictions) {
    rename(restriction.from_way), rename(restriction.to_way);
    for (std::int64_t& way : restriction.via_ways) rename(way);
  }
}

}  // namespace

void draw_once(RoadNetwork& roads, Findings& findings) {
  DrawnStretches drawn(roads);
  std::vector<RoadPath>& paths = roads.paths;
  std::map<std::size_t, std::vector<RoadPath>> rest;  // of the paths that others draw, too
  std::map<std::int64_t, int> next_part;
  for (const RoadPath& path : paths) next_part[path.osm_id] = std::max(next_part[path.osm_id], path.part + 1);
  std::map<std::int64_t, std::int64_t> stays;
  for (const std::size_t index : by_importance(paths)) {
    const RoadPath& path = paths[index];
    if (path.nodes.size() < 2) continue;
    const DoubledPath twice = drawn.take(index);
    if (twice.count == 0) continue;
    RoadPath& by = paths[twice.by];
    const bool whole = twice.by_one_alone && twice.count == twice.doubled.size();
    const bool is_pair = whole && twice.against_alone && path.oneway == Oneway::forward &&
                         by.oneway == Oneway::forward && path.nodes.size() == by.nodes.size();
    report(path, twice, by,
           is_pair ? "both are one-way against each other, taken for one road of both directions"
                   : "that is left out here; delete it in the map",
           findings);
    if (is_pair) take_direction(by, path);
    if (whole && next_part[path.osm_id] == 1) stays[path.osm_id] = by.osm_id;
    rest.emplace(index, rest_of(path, twice.doubled, next_part[path.osm_id]));
  }
  if (rest.empty()) return;
  std::vector<RoadPath> kept;
  for (std::size_t i = 0; i < paths.size(); ++i) {
    if (const auto at = rest.find(i); at == rest.end())
      kept.push_back(std::move(paths[i]));
    else
      std::ranges::move(at->second, std::back_inserter(kept));
  }
  paths = std::move(kept);
  rename_ways(roads, stays);
}

}  // namespace orthodrive
