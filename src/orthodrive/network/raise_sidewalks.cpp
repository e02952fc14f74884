#include "orthodrive/network/raise_sidewalks.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <vector>

#include "orthodrive/geo/polygon.hpp"
#include "orthodrive/geo/spatial_index.hpp"
#include "orthodrive/network/road_cover.hpp"
#include "roadquery/road_surface.hpp"

namespace orthodrive::network {
namespace {

using roadquery::Lane;
using roadquery::LaneType;
using roadquery::Road;
using roadquery::RoadMap;

constexpr double step_m = 0.5;        // between places that are asked whether something lies on the sidewalk
constexpr double same_level_m = 1.5;  // of the road query
constexpr double height_unit_m = 1e-3;

/// The sidewalk lies at most so high between two s.
struct Limit {
  double from = 0.0, to = 0.0, height_m = 0.0;
};

struct Walk {
  std::size_t road = 0;
  bool left = false;
  std::vector<Limit> limits;

  [[nodiscard]] Lane* lane(RoadMap& map) const {
    roadquery::LaneSection& section = map.roads[road].sections.front();
    for (Lane& lane : left ? section.left : section.right)
      if (lane.type == LaneType::sidewalk) return &lane;
    return nullptr;
  }
  [[nodiscard]] double height(double s) const {
    double height = kerb_m;
    for (const Limit& limit : limits) {
      const double beside = std::max({limit.from - s, s - limit.to, 0.0});
      height = std::min(height, limit.height_m + beside * (kerb_m / kerb_ramp_m));
    }
    return height;
  }
};

/// What else lies over a place: lanes of other roads, and junctions.
class Others {
 public:
  explicit Others(const RoadMap& map) : map_(map) {
    const auto& first = map.roads.front().plan.front();
    origin_ = {std::round(first.x), std::round(first.y)};
    std::vector<Box2> boxes;
    covers_.reserve(map.roads.size());
    for (const Road& road : map.roads) {
      covers_.emplace_back(road, origin_, 0.0, road.length);
      boxes.push_back(covers_.back().bounds());
    }
    road_index_ = SpatialIndex(boxes);
    boxes.clear();
    for (const roadquery::Junction& junction : map.junctions) {
      if (!junction.surface) continue;
      Ring& ring = areas_.emplace_back();
      for (const auto& [x, y] : junction.surface->boundary) ring.push_back(Vec2{x, y} - origin_);
      boxes.push_back(bounds_of(ring));
    }
    area_index_ = SpatialIndex(boxes);
  }

  [[nodiscard]] bool lie_over(const roadquery::SurfacePoint& p, std::size_t own_road) const {
    const Vec2 at = Vec2{p.x, p.y} - origin_;
    for (const std::uint32_t i : road_index_.near(at, 0.0)) {
      if (i == own_road) continue;
      const auto place = covers_[i].find(at, false);
      if (place && std::abs(covers_[i].height(*place) - p.z) < same_level_m) return true;
    }
    return std::ranges::any_of(area_index_.near(at, 0.0), [&](std::uint32_t i) {
      return contains({areas_[i], {}}, at);
    });
  }

 private:
  const RoadMap& map_;
  Vec2 origin_;
  std::vector<RoadCover> covers_;
  std::vector<Ring> areas_;
  SpatialIndex road_index_, area_index_;
};

/// t of the inner and outer border of a sidewalk.
std::array<double, 2> borders_of(const Road& road, const Walk& walk, double s) {
  const roadquery::LaneSection& section = road.sections.front();
  const double sign = walk.left ? 1.0 : -1.0;
  double t = roadquery::evaluate(road.lane_offset, s);
  for (const Lane& lane : walk.left ? section.left : section.right) {
    const double outer = t + sign * roadquery::lane_width(lane, s - section.s);
    if (lane.type == LaneType::sidewalk) return {t, outer};
    t = outer;
  }
  return {t, t};
}

void add_own_limits(const Road& road, const Lane& lane, Walk& walk) {
  if (!lane.predecessor) walk.limits.push_back({0.0, 0.0, 0.0});
  if (!lane.successor) walk.limits.push_back({road.length, road.length, 0.0});
  for (const roadquery::RoadObject& object : road.objects)
    if (object.type == "crosswalk")
      walk.limits.push_back({object.s - 0.5 * object.length, object.s + 0.5 * object.length, lowered_kerb_m});
}

void add_limits_of_others(const Others& others, const Road& road, Walk& walk) {
  const int steps = std::max(1, static_cast<int>(std::ceil(road.length / step_m)));
  std::optional<Limit> open;
  for (int i = 0; i <= steps + 1; ++i) {
    const double s = road.length * std::min(i, steps) / steps;
    bool covered = false;
    if (i <= steps) {
      const auto [inner, outer] = borders_of(road, walk, s);
      for (const double share : {0.02, 0.5, 0.98})
        covered =
            covered || others.lie_over(roadquery::surface_point(road, s, inner + share * (outer - inner)), walk.road);
    }
    if (covered && !open) open = Limit{s - step_m, s + step_m, 0.0};
    if (covered) open->to = s + step_m;
    if (!covered && open) walk.limits.push_back(*open), open.reset();
  }
}

/// Joints of two roads: both sides as high as the lower one.
bool level_joints(const RoadMap& map, const std::map<std::pair<int, bool>, std::size_t>& walk_of,
                  std::vector<Walk>& walks) {
  bool changed = false;
  for (Walk& walk : walks) {
    const Road& road = map.roads[walk.road];
    for (const bool at_end : {false, true}) {
      const roadquery::RoadLink& link = at_end ? road.successor : road.predecessor;
      if (link.kind != roadquery::LinkKind::road) continue;
      const bool to_end = link.contact == roadquery::ContactPoint::end;
      const auto other = walk_of.find({link.id, walk.left == (at_end != to_end)});
      const double here = at_end ? road.length : 0.0;
      double there_m = 0.0;
      if (other != walk_of.end()) {
        const Walk& next = walks[other->second];
        there_m = next.height(to_end ? map.roads[next.road].length : 0.0);
      }
      if (there_m >= walk.height(here) - 1e-9) continue;
      walk.limits.push_back({here, here, there_m});
      changed = true;
    }
  }
  return changed;
}

std::vector<roadquery::LaneHeight> entries_of(const Walk& walk, double length) {
  std::vector<double> places = {0.0, length};
  const auto add = [&](double s) {
    if (s > 0.0 && s < length) places.push_back(s);
  };
  for (const Limit& a : walk.limits) {
    const double ramp = (kerb_m - a.height_m) * (kerb_ramp_m / kerb_m);
    for (const double s : {a.from - ramp, a.from, a.to, a.to + ramp}) add(s);
    for (const Limit& b : walk.limits)  // where the ramp up from a is as high as that down to b
      if (b.from > a.to) add(0.5 * (a.to + b.from + (b.height_m - a.height_m) * (kerb_ramp_m / kerb_m)));
  }
  std::ranges::sort(places);
  std::vector<roadquery::LaneHeight> entries;
  constexpr double apart_m = 1e-3;
  for (const double s : places) {
    if (!entries.empty() && s - entries.back().s_offset < apart_m) continue;
    const double height = std::round(walk.height(s) / height_unit_m) * height_unit_m;
    const std::size_t n = entries.size();
    if (n > 1 && entries[n - 1].inner == height && entries[n - 2].inner == height) entries.pop_back();
    entries.push_back({s, height, height});
  }
  return entries;
}

}  // namespace

void raise_sidewalks(RoadMap& map) {
  std::vector<Walk> walks;
  std::map<std::pair<int, bool>, std::size_t> walk_of;  // by id of the road and side
  for (std::size_t i = 0; i < map.roads.size(); ++i) {
    if (map.roads[i].junction >= 0 || map.roads[i].sections.size() != 1) continue;
    for (const bool left : {true, false}) {
      Walk walk{i, left, {}};
      if (walk.lane(map) == nullptr) continue;
      walk_of[{map.roads[i].id, left}] = walks.size();
      walks.push_back(std::move(walk));
    }
  }
  if (walks.empty()) return;
  const Others others(map);
  for (Walk& walk : walks) {
    const Road& road = map.roads[walk.road];
    add_own_limits(road, *walk.lane(map), walk);
    add_limits_of_others(others, road, walk);
  }
  constexpr int most_rounds = 8;
  for (int round = 0; round < most_rounds && level_joints(map, walk_of, walks); ++round) {
  }
  for (const Walk& walk : walks) walk.lane(map)->heights = entries_of(walk, map.roads[walk.road].length);
}

}  // namespace orthodrive::network
