// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/scene/roads/road_joints.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "orthodrive/geo/segment.hpp"
#include "orthodrive/scene/plan/plan_grid.hpp"
#include "orthodrive/scene/roads/lane_cuts.hpp"
#include "roadquery/surface/road_surface.hpp"

namespace orthodrive::scene {
namespace {

constexpr double most_apart_m = 0.02;   // along the road, of ends that are one joint
constexpr double same_point_m = 0.005;  // across the road
constexpr double on_edge_m = 1.5 * plan_grid_m;

Vec2 plan(const std::array<double, 3>& p) { return {p[0], p[1]}; }

}  // namespace

struct RoadJoints::Place {
  double across_m;
  Vec2 p;
};

struct RoadJoints::End {
  std::size_t road = 0;
  bool at_end = false;
  int level = 0;
  Vec2 right, left;
  std::vector<Vec2> between;  // where the surface or the lanes change
};

namespace {

std::vector<Vec2> places_between(const roadquery::Road& road, bool at_end, Vec2 reference) {
  std::vector<Vec2> places;
  const double s = at_end ? road.length : 0.0;
  for (const double t : lane_borders_at(road, at_end)) {
    const auto p = roadquery::surface_point(road, s, t);
    places.push_back({p.x, p.y});
  }
  if (!road.shape.empty()) places.push_back(reference);
  return places;
}

}  // namespace

RoadJoints::RoadJoints(const roadquery::RoadQuery& query, std::span<const int> level_of) {
  const std::vector<roadquery::Road>& roads = query.map().roads;
  std::map<int, std::size_t> by_id;
  for (std::size_t i = 0; i < roads.size(); ++i) by_id.emplace(roads[i].id, i);
  std::vector<std::size_t> first(2 * roads.size());  // of the ends that meet there; end 2 i + 1 is the last of road i
  std::iota(first.begin(), first.end(), std::size_t{0});
  const auto root = [&](std::size_t i) {
    while (first[i] != i) i = first[i];
    return i;
  };
  for (std::size_t i = 0; i < roads.size(); ++i) {
    for (const bool at_end : {false, true}) {
      const roadquery::RoadLink& link = at_end ? roads[i].successor : roads[i].predecessor;
      const auto found = link.kind == roadquery::LinkKind::road ? by_id.find(link.id) : by_id.end();
      if (found == by_id.end()) continue;
      const std::size_t other = found->second;
      if (level_of[i] < 0 || level_of[other] < 0 || level_of[i] == level_of[other]) continue;
      const std::size_t a = root(2 * i + (at_end ? 1 : 0));
      const std::size_t b = root(2 * other + (link.contact == roadquery::ContactPoint::end ? 1 : 0));
      first[std::max(a, b)] = std::min(a, b);
    }
  }
  std::map<std::size_t, std::vector<End>> meeting;
  for (std::size_t e = 0; e < first.size(); ++e) {
    const std::size_t i = e / 2;
    if (level_of[i] < 0) continue;
    const bool at_end = e % 2 == 1;
    const auto cut = query.section(i, at_end ? roads[i].length : 0.0);
    if (!cut) continue;
    meeting[root(e)].push_back({i, at_end, level_of[i], plan(cut->right), plan(cut->left),
                                places_between(roads[i], at_end, plan(cut->reference))});
  }
  for (const auto& [unused, ends] : meeting)
    if (ends.size() > 1) join(ends);
  std::vector<Box2> boxes;
  boxes.reserve(edges_.size());
  for (const Edge& edge : edges_) boxes.push_back(bounds_of({edge.a, edge.b}));
  index_ = SpatialIndex(boxes);
  boxes.clear();
  for (const Run& run : runs_) boxes.push_back(bounds_of({run.a, run.b}));
  run_index_ = SpatialIndex(boxes);
}

/// Runs of edges between places that roads of the same levels have in common. A run of one edge gets a place between.
void RoadJoints::add_runs(std::span<const End* const> joined, Vec2 across, Vec2 from, std::vector<Place>& places) {
  const auto levels_of = [&](double across_m) {
    MeetingLevels levels{std::numeric_limits<int>::max(), std::numeric_limits<int>::min()};
    for (const End* end : joined) {
      const auto [low, high] = std::minmax({dot(across, end->right - from), dot(across, end->left - from)});
      if (across_m <= low || across_m >= high) continue;
      levels = {std::min(levels.lowest, end->level), std::max(levels.highest, end->level)};
    }
    return levels;
  };
  std::vector<Place> between;
  for (std::size_t k = 1, end = 1; k < places.size(); k = end) {
    const auto of_edge = [&](std::size_t e) { return levels_of(0.5 * (places[e - 1].across_m + places[e].across_m)); };
    const MeetingLevels levels = of_edge(k);
    const auto is_same = [&](const MeetingLevels& other) {
      return other.lowest == levels.lowest && other.highest == levels.highest;
    };
    for (end = k + 1; end < places.size() && is_same(of_edge(end));) ++end;
    if (levels.lowest >= levels.highest) continue;
    const Place &a = places[k - 1], &b = places[end - 1];
    runs_.push_back({a.p, b.p, levels});
    if (end == k + 1) between.push_back({0.5 * (a.across_m + b.across_m), snap_to_grid((a.p + b.p) * 0.5)});
  }
  places.insert(places.end(), between.begin(), between.end());
  std::ranges::sort(places, {}, &Place::across_m);
}

void RoadJoints::join(std::span<const End> ends) {
  const auto width = [](const End& end) { return distance(end.left, end.right); };
  const End& widest = *std::ranges::max_element(ends, {}, width);
  const Vec2 across = normalized(widest.left - widest.right);
  std::vector<const End*> joined;
  for (const End& end : ends) {
    const auto apart_m = [&](Vec2 p) { return std::abs(cross(across, p - widest.right)); };
    if (apart_m(end.right) < most_apart_m && apart_m(end.left) < most_apart_m) joined.push_back(&end);
  }
  const auto by_level = [](const End* a, const End* b) { return a->level < b->level; };
  if (joined.size() < 2 ||
      (*std::ranges::min_element(joined, by_level))->level == (*std::ranges::max_element(joined, by_level))->level)
    return;
  std::vector<Place> places;
  const auto across_m = [&](Vec2 p) { return dot(across, p - widest.right); };
  const auto add = [&](Vec2 p) {
    const double u = across_m(p);
    if (std::ranges::none_of(places, [&](const Place& q) { return std::abs(q.across_m - u) < same_point_m; }))
      places.push_back({u, snap_to_grid(p)});
  };
  for (const End* end : joined) add(end->right), add(end->left);
  for (const End* end : joined)
    for (const Vec2 p : end->between) add(p);
  std::ranges::sort(places, {}, &Place::across_m);
  add_runs(joined, across, widest.right, places);
  const int lowest = (*std::ranges::min_element(joined, by_level))->level;
  for (std::size_t k = 1; k < places.size(); ++k) edges_.push_back({places[k - 1].p, places[k].p, lowest});
  for (const End* end : joined) {
    const double right_m = across_m(end->right), left_m = across_m(end->left);
    const double low = std::min(right_m, left_m) - same_point_m, high = std::max(right_m, left_m) + same_point_m;
    std::vector<Vec2> own;
    for (const Place& place : places)
      if (place.across_m > low && place.across_m < high) own.push_back(place.p);
    if (own.size() < 2) continue;
    if (right_m > left_m) std::ranges::reverse(own);
    across_[{end->road, end->at_end}] = std::move(own);
  }
}

std::span<const Vec2> RoadJoints::across(std::size_t road, bool at_end) const {
  const auto found = across_.find({road, at_end});
  return found == across_.end() ? std::span<const Vec2>{} : found->second;
}

std::optional<int> RoadJoints::level_at(Vec2 p) const {
  std::optional<int> lowest;
  for (const std::uint32_t i : index_.near(p, on_edge_m)) {
    const Edge& edge = edges_[i];
    if (distance_to_segment(edge.a, edge.b, p) <= on_edge_m && (!lowest || edge.level < *lowest)) lowest = edge.level;
  }
  return lowest;
}

std::optional<MeetingLevels> RoadJoints::inside_at(Vec2 p) const {
  for (const std::uint32_t i : run_index_.near(p, on_edge_m)) {
    const Run& run = runs_[i];
    if (distance_to_segment(run.a, run.b, p) <= on_edge_m && distance(p, run.a) > on_edge_m &&
        distance(p, run.b) > on_edge_m)
      return run.levels;
  }
  return std::nullopt;
}

void insert_between(Ring& ring, Vec2 from, Vec2 to, const std::vector<Vec2>& between) {
  for (std::size_t i = 0; i < ring.size(); ++i) {
    if (!(ring[i] == from && ring[(i + 1) % ring.size()] == to)) continue;
    ring.insert(ring.begin() + static_cast<std::ptrdiff_t>(i) + 1, between.begin(), between.end());
    return;
  }
}

}  // namespace orthodrive::scene
