// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/network/junctions/fit_junction_surfaces.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <span>

#include "orthodrive/core/parallel.hpp"
#include "orthodrive/model/roads/road_network.hpp"
#include "orthodrive/network/curves/ease_along.hpp"
#include "orthodrive/network/curves/fit_plan.hpp"
#include "orthodrive/network/junctions/archived_network.hpp"
#include "orthodrive/network/junctions/junction_field.hpp"
#include "orthodrive/network/junctions/junction_members.hpp"
#include "orthodrive/network/junctions/junction_nodes.hpp"
#include "orthodrive/network/junctions/refit_profile.hpp"
#include "roadquery/surface/junction_surface.hpp"

namespace orthodrive::network {
namespace {

using roadquery::JunctionSurface;
using roadquery::Road;
using roadquery::RoadMap;

constexpr double fine_m = 0.5;            // of the grid that is solved
constexpr double wide_m = 50.0;           // wider junctions are solved at twice that
constexpr double grid_margin_m = 2.5;     // of the grid around the area: two nodes of 1 m
constexpr double coarse_error_m = 0.005;  // of a coarser grid from the one that was solved
constexpr double same_height_m = 0.01;    // ways straight on that differ by more where they cross: one gives way
constexpr double same_ground_m = 0.5;  // roads beside the junction further off in height lie on a ground of their own
constexpr int solved_beyond = 2, kept_beyond = 1;  // nodes beyond those that places inside the boundary need
constexpr double unchanged_m = 0.005;              // ways straight on that lie so near to the surface stay as they are
constexpr double millimetre = 1e-3, height_unit_of_files_m = 1e-4;

double rounded(double v, double step) { return std::round(v / step) * step; }

Vec2 origin_of(const Road& road) { return {std::round(road.plan.front().x), std::round(road.plan.front().y)}; }

/// Junctions that share ground, in coordinates relative to one origin.
struct Group {
  std::vector<std::size_t> junctions;
  Vec2 origin;
  std::vector<Ring> boundaries;
};

Group group_of(const std::vector<std::size_t>& junctions, const std::vector<JunctionGround>& grounds) {
  Group group{junctions, grounds[junctions.front()].origin, {}};
  for (const std::size_t j : junctions) {
    Ring ring = grounds[j].boundary;
    for (Vec2& p : ring) p = p + (grounds[j].origin - group.origin);
    group.boundaries.push_back(std::move(ring));
  }
  return group;
}

FieldGrid grid_over(const std::vector<Ring>& boundaries) {
  Box2 box = bounds_of(boundaries.front());
  double size_m = 0.0;
  for (const Ring& boundary : boundaries) {
    const Box2 b = bounds_of(boundary);
    box = {std::min(box.min_x, b.min_x), std::min(box.min_y, b.min_y), std::max(box.max_x, b.max_x),
           std::max(box.max_y, b.max_y)};
    size_m = std::max({size_m, b.width(), b.height()});
  }
  box = box.grown(grid_margin_m);
  FieldGrid grid;
  grid.spacing_m = size_m + 2.0 * grid_margin_m > wide_m ? 2.0 * fine_m : fine_m;
  grid.origin = {std::floor(box.min_x / millimetre) * millimetre, std::floor(box.min_y / millimetre) * millimetre};
  const auto nodes = [&](double size) { return 4 * static_cast<int>(std::ceil(size / (4.0 * grid.spacing_m))) + 1; };
  grid.columns = nodes(box.width()), grid.rows = nodes(box.height());
  return grid;
}

/// The arms' ends, relative to the origin.
std::vector<roadquery::JunctionArm> entries_of(const RoadMap& map, const JunctionMembers& members, Vec2 origin) {
  std::vector<roadquery::JunctionArm> entries;
  entries.reserve(members.arms.size());
  for (std::size_t k = 0; k < members.arms.size(); ++k) {
    entries.push_back(roadquery::junction_arm(
        map.roads[members.arms[k]], members.at_end[k] ? roadquery::ContactPoint::end : roadquery::ContactPoint::start));
    entries.back().x -= origin.x, entries.back().y -= origin.y;
  }
  return entries;
}

/// The members of a group as those of one junction.
JunctionMembers together(const std::vector<JunctionMembers>& members, const Group& group) {
  JunctionMembers all;
  for (const std::size_t j : group.junctions) {
    const JunctionMembers& m = members[j];
    all.connecting.insert(all.connecting.end(), m.connecting.begin(), m.connecting.end());
    all.arms.insert(all.arms.end(), m.arms.begin(), m.arms.end());
    all.at_end.insert(all.at_end.end(), m.at_end.begin(), m.at_end.end());
    for (const std::size_t i : m.inner)
      if (std::find(all.inner.begin(), all.inner.end(), i) == all.inner.end()) all.inner.push_back(i);
  }
  std::set<std::size_t> own(all.connecting.begin(), all.connecting.end()), others;
  own.insert(all.arms.begin(), all.arms.end());
  own.insert(all.inner.begin(), all.inner.end());
  for (const std::size_t j : group.junctions)
    for (const std::size_t i : members[j].others)
      if (!own.contains(i)) others.insert(i);
  all.others.assign(others.begin(), others.end());
  return all;
}

bool straight_before(const Road& a, const Road& b) {
  if (road_rank(a.highway) != road_rank(b.highway)) return road_rank(a.highway) > road_rank(b.highway);
  const auto width = [](const Road& road) {
    const roadquery::Edges edges = carriageway_edges(road, 0.5 * road.length);
    return edges.left_t - edges.right_t;
  };
  if (width(a) != width(b)) return width(a) > width(b);
  return a.id < b.id;
}

/// Calls visit(z of a, z of b) for nodes of both.
template <typename Visit>
void at_common_nodes(const FieldRoad& a, const FieldRoad& b, const Visit& visit) {
  for (auto i = a.nodes.begin(), k = b.nodes.begin(); i != a.nodes.end() && k != b.nodes.end();) {
    if (i->node == k->node)
      visit(*i++, *k++);
    else if (i->node < k->node)
      ++i;
    else
      ++k;
  }
}

bool disagree(const FieldRoad& a, const FieldRoad& b) {
  bool result = false;
  at_common_nodes(a, b, [&](const FieldRoad::Node& p, const FieldRoad::Node& q) {
    result = result || std::abs(p.z - q.z) > same_height_m;
  });
  return result;
}

/// The nodes of a road beside the junction that its connecting roads cover at nearly the same height.
FieldRoad under_connecting_roads(const FieldRoad& beside, const std::vector<FieldRoad>& roads) {
  std::map<std::size_t, double> covered;
  for (const FieldRoad& road : roads)
    if (road.role > RoadRole::beside)
      at_common_nodes(beside, road, [&](const FieldRoad::Node& p, const FieldRoad::Node& q) {
        if (std::abs(p.z - q.z) <= same_ground_m) covered[p.node] = p.z;
      });
  FieldRoad result{beside.role, {}};
  for (const auto& [node, z] : covered) result.nodes.push_back({node, z});
  return result;
}

/// Roads with their roles: of the ways straight on the first by class, then width, then id keep their shape; those that
/// they cross give way. Short roads between two junctions give way to all: they are too short to turn into the main
/// road's plane.
std::vector<FieldRoad> field_roads(const RoadMap& map, const JunctionMembers& members, const std::vector<int>& straight,
                                   const FieldGrid& grid, const std::vector<char>& asked, Vec2 origin) {
  std::vector<FieldRoad> roads;
  constexpr double reach_m = arm_reach_m + 2.0 * grid_margin_m;  // nodes beyond the end of the area are asked for, too
  for (std::size_t k = 0; k < members.arms.size(); ++k) {
    const Road& road = map.roads[members.arms[k]];
    const double reach = std::min(reach_m, road.length), s0 = members.at_end[k] ? road.length - reach : 0.0;
    roads.push_back(over_grid(grid, RoadCover(road, origin, s0, s0 + reach), RoadRole::arm, asked));
  }
  std::vector<const Road*> ways;
  ways.reserve(members.connecting.size());
  for (const std::size_t i : members.connecting) ways.push_back(&map.roads[i]);
  for (const std::size_t i : members.inner) ways.push_back(&map.roads[i]);
  const auto is_straight = [&](const Road& road) {
    return std::binary_search(straight.begin(), straight.end(), road.id);
  };
  std::stable_sort(ways.begin(), ways.end(), [&](const Road* a, const Road* b) {
    if (is_straight(*a) != is_straight(*b)) return is_straight(*a);
    return straight_before(*a, *b);
  });
  std::vector<std::size_t> main;
  for (const Road* way : ways) {
    FieldRoad road = over_grid(grid, RoadCover(*way, origin, 0.0, way->length), RoadRole::turning, asked);
    if (is_straight(*way)) {
      const bool crosses =
          std::any_of(main.begin(), main.end(), [&](std::size_t m) { return disagree(roads[m], road); });
      const bool slow = road_rank(way->highway) <= road_rank("service");  // a ridge is rounded further there
      road.role = crosses || slow ? RoadRole::straight : RoadRole::main;
      if (!crosses) main.push_back(roads.size());
    }
    roads.push_back(std::move(road));
  }
  for (const std::size_t i : members.others) {
    const Road& road = map.roads[i];
    if (road.junction >= 0) continue;  // of a junction on another level
    const FieldRoad beside = over_grid(grid, RoadCover(road, origin, 0.0, road.length), RoadRole::beside, asked);
    if (FieldRoad under = under_connecting_roads(beside, roads); !under.nodes.empty())
      roads.push_back(std::move(under));
  }
  return roads;
}

/// Largest difference of two connecting roads over one node.
double disagreement_m(const FieldGrid& grid, const std::vector<FieldRoad>& roads) {
  std::vector<double> low(grid.size(), INFINITY), high(grid.size(), -INFINITY);
  double largest = 0.0;
  for (const FieldRoad& road : roads) {
    if (road.role <= RoadRole::beside) continue;
    for (const FieldRoad::Node& at : road.nodes) {
      low[at.node] = std::min(low[at.node], at.z), high[at.node] = std::max(high[at.node], at.z);
      largest = std::max(largest, high[at.node] - low[at.node]);
    }
  }
  return largest;
}

std::size_t node_of(int columns, int column, int row) {
  return static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(column);
}

/// The part of the group's surface that the boundary needs, from a node on that all coarser grids have.
JunctionSurface part_of(const FieldGrid& grid, const std::vector<double>& z, const Group& group, std::size_t member) {
  const Box2 box = bounds_of(group.boundaries[member]).grown(grid_margin_m);
  const auto first = [&](double from, double origin) {
    return 4 * std::max(0, static_cast<int>(std::floor((from - origin) / (4.0 * grid.spacing_m))));
  };
  const auto last = [&](double to, double origin, int count) {
    return std::min(count - 1, 4 * static_cast<int>(std::ceil((to - origin) / (4.0 * grid.spacing_m))));
  };
  const int column0 = first(box.min_x, grid.origin.x), row0 = first(box.min_y, grid.origin.y);
  JunctionSurface surface;
  for (const Vec2 p : group.boundaries[member])
    surface.boundary.push_back({group.origin.x + rounded(p.x, millimetre), group.origin.y + rounded(p.y, millimetre)});
  surface.x = group.origin.x + grid.origin.x + column0 * grid.spacing_m;
  surface.y = group.origin.y + grid.origin.y + row0 * grid.spacing_m;
  surface.spacing_m = grid.spacing_m;
  surface.columns = last(box.max_x, grid.origin.x, grid.columns) - column0 + 1;
  surface.rows = last(box.max_y, grid.origin.y, grid.rows) - row0 + 1;
  for (int r = 0; r < surface.rows; ++r)
    for (int c = 0; c < surface.columns; ++c) surface.z.push_back(z[node_of(grid.columns, column0 + c, row0 + r)]);
  return surface;
}

/// Every `step`-th node of a surface.
JunctionSurface thinned(const JunctionSurface& fine, int step) {
  JunctionSurface coarse = fine;
  coarse.spacing_m = fine.spacing_m * step;
  coarse.columns = (fine.columns - 1) / step + 1, coarse.rows = (fine.rows - 1) / step + 1;
  coarse.z.clear();
  for (int r = 0; r < fine.rows; r += step)
    for (int c = 0; c < fine.columns; c += step) coarse.z.push_back(fine.z[node_of(fine.columns, c, r)]);
  return coarse;
}

FieldGrid grid_of(const JunctionSurface& surface, Vec2 origin) {
  return {{surface.x - origin.x, surface.y - origin.y}, surface.spacing_m, surface.columns, surface.rows};
}

/// Whether a coarser grid has the heights of the fine one at its nodes inside the boundary, and nodes all round.
bool reproduces(const JunctionSurface& coarse, const JunctionSurface& fine, const std::vector<char>& inside) {
  const double reach = 1.0 * coarse.spacing_m;
  for (const auto& [x, y] : fine.boundary)
    if (x - coarse.x < reach || y - coarse.y < reach ||
        coarse.x + (coarse.columns - 1) * coarse.spacing_m - x < reach ||
        coarse.y + (coarse.rows - 1) * coarse.spacing_m - y < reach)
      return false;
  for (int r = 0; r < fine.rows; ++r)
    for (int c = 0; c < fine.columns; ++c) {
      const std::size_t i = node_of(fine.columns, c, r);
      if (inside[i] == 0) continue;
      const double x = fine.x + c * fine.spacing_m, y = fine.y + r * fine.spacing_m;
      if (std::abs(roadquery::evaluate(coarse, x, y).z - fine.z[i]) > coarse_error_m) return false;
    }
  return true;
}

/// The coarsest grid that has the heights of all parts: where they overlap they stay one surface.
void thin_out(std::vector<JunctionSurface>& parts, const Group& group) {
  std::vector<std::vector<char>> inside;
  inside.reserve(parts.size());
  for (std::size_t k = 0; k < parts.size(); ++k)
    inside.push_back(nodes_inside(grid_of(parts[k], group.origin), group.boundaries[k]));
  for (const int step : {4, 2}) {
    std::vector<JunctionSurface> coarse;
    coarse.reserve(parts.size());
    for (const JunctionSurface& part : parts) coarse.push_back(thinned(part, step));
    bool same = true;
    for (std::size_t k = 0; k < parts.size() && same; ++k)
      same = coarse[k].spacing_m <= 2.0 && reproduces(coarse[k], parts[k], inside[k]);
    if (!same) continue;
    parts = std::move(coarse);
    return;
  }
}

/// Nodes that no place inside the boundary needs get what the file's text predicts for them: they cost two characters.
void predict_the_rest(JunctionSurface& surface, const std::vector<char>& needed) {
  for (int r = 0; r < surface.rows; ++r)
    for (int c = 0; c < surface.columns; ++c) {
      const std::size_t i = node_of(surface.columns, c, r);
      if (needed[i] != 0) continue;
      const double west = c > 0 ? surface.z[i - 1] : NAN,
                   south = r > 0 ? surface.z[node_of(surface.columns, c, r - 1)] : NAN;
      const double z = c > 0 && r > 0 ? west + south - surface.z[node_of(surface.columns, c - 1, r - 1)]
                       : c > 0        ? west
                       : r > 0        ? south
                                      : surface.z[i];
      surface.z[i] = rounded(z, height_unit_of_files_m);
    }
}

JunctionGround ground_of(const RoadMap& map, const JunctionMembers& members, std::optional<double> seen_radius_m,
                         const Polygon* paved) {
  JunctionGround ground;
  if (members.connecting.empty()) return ground;
  ground.origin = origin_of(map.roads[members.connecting.front()]);
  std::vector<std::string> classes;
  classes.reserve(members.arms.size());
  for (const std::size_t i : members.arms) classes.push_back(map.roads[i].highway);
  for (const std::size_t i : members.inner) classes.push_back(map.roads[i].highway);
  JunctionRoads roads = roads_of(map, members);
  if (paved) {
    roads.paved.push_back(*paved);
    for (Vec2& p : roads.paved.back().outer) p = p - ground.origin;
  }
  const MultiPolygon area = junction_area(roads, seen_radius_m.value_or(kerb_radius_m(classes)), ground.origin);
  ground.boundary = woven_ring(area);
  if (ground.boundary.size() < 3) return {};
  for (const Polygon& part : area) ground.area_m2 += area_m2(part);
  return ground;
}

struct Built {
  std::optional<JunctionSurface> surface;
  double disagreement_m = 0.0;
};
template <typename Archive>
void fields(Archive& archive, Built& built) {
  archive(built.surface, built.disagreement_m);
}

/// The surfaces of a group, by its junctions.
std::vector<Built> build_surfaces(const RoadMap& map, const std::vector<JunctionMembers>& members, const Group& group,
                                  const std::vector<int>& straight) {
  const FieldGrid grid = grid_over(group.boundaries);
  std::vector<char> asked(grid.size(), 0);
  for (const Ring& boundary : group.boundaries) {
    const std::vector<char> own = grown(grid, nodes_for(grid, boundary), solved_beyond);
    for (std::size_t i = 0; i < own.size(); ++i) asked[i] = static_cast<char>(asked[i] | own[i]);
  }
  const JunctionMembers all = together(members, group);
  const std::vector<FieldRoad> roads = field_roads(map, all, straight, grid, asked, group.origin);
  std::vector<double> z = bend_least(grid, field_targets(grid, roads, entries_of(map, all, group.origin)), asked);
  extend(grid, asked, z);
  for (double& height : z) height = rounded(height, height_unit_of_files_m);
  const double disagreement = disagreement_m(grid, roads);
  std::vector<JunctionSurface> parts;
  parts.reserve(group.junctions.size());
  for (std::size_t k = 0; k < group.junctions.size(); ++k) parts.push_back(part_of(grid, z, group, k));
  thin_out(parts, group);
  std::vector<Built> built;
  for (std::size_t k = 0; k < parts.size(); ++k) {
    const FieldGrid own = grid_of(parts[k], group.origin);
    predict_the_rest(parts[k], grown(own, nodes_for(own, group.boundaries[k]), kept_beyond));
    built.push_back({std::move(parts[k]), disagreement});
  }
  return built;
}

/// Roads between two junctions that lie under the surfaces of both get the profile of the surface, ends included.
void lay_inner_roads(RoadMap& map, const std::vector<JunctionMembers>& members) {
  std::set<std::size_t> laid;
  for (std::size_t j = 0; j < members.size(); ++j) {
    const std::optional<JunctionSurface>& surface = map.junctions[j].surface;
    if (!surface) continue;
    for (const std::size_t i : members[j].inner) {
      if (!laid.insert(i).second) continue;
      Road& road = map.roads[i];
      road = refitted(road, *surface, {end_on(road, *surface, false), end_on(road, *surface, true)});
    }
  }
}

/// How far the roads of a junction lie from its surface.
struct Off {
  double before_m = 0.0, after_m = 0.0;
};

/// Borders of lanes of a road, which lie beside each other, in the order of its lanes: t to the left of the direction
/// in which roads linked to it run.
std::vector<double> borders_of(const Road& road, double s, double sign, const std::vector<int>& lanes) {
  std::vector<double> borders;
  const roadquery::LaneSection& section = roadquery::section_at(road, s);
  for (const auto* side : {&section.left, &section.right}) {
    double t = roadquery::evaluate(road.lane_offset, s);
    for (const roadquery::Lane& lane : *side) {
      const double outer = t + (lane.id > 0 ? 1.0 : -1.0) * roadquery::lane_width(lane, s - section.s);
      if (std::find(lanes.begin(), lanes.end(), lane.id) != lanes.end()) {
        if (borders.empty()) borders.push_back(sign * t);
        borders.push_back(sign * outer);
      }
      t = outer;
    }
  }
  return borders;
}

/// Gives one end of cubics along the whole line of a connecting road a value.
void set_end(std::vector<roadquery::Cubic>& cubics, std::span<const roadquery::PlanElement> plan, bool at_end,
             double value) {
  const double other = roadquery::evaluate(cubics, at_end ? 0.0 : plan_length(plan));
  cubics = ease_along(plan, at_end ? other : value, at_end ? value : other);
}

/// One end of a connecting road and the road that it is linked to there, which was laid on the surface.
struct JointWithInner {
  const Road& other;
  bool other_end = false;
  double sign = 1.0;  ///< -1 where the connecting road runs against the other
  double t = 0.0;     ///< of the connecting road's reference line on the other, to the left of where that one runs
};

/// Where the reference line was moved beside the other road's: the lanes meet again, now that the other one is banked
/// otherwise, and the profile goes on with the other's surface.
ProfileEnd meet_beside(Road& road, bool at_end, const JointWithInner& joint) {
  std::vector<roadquery::Lane>& lanes =
      road.driving_side == roadquery::DrivingSide::left ? road.sections.front().left : road.sections.front().right;
  std::vector<int> linked;
  for (const roadquery::Lane& lane : lanes)  // from the inside out
    if (const std::optional<int>& id = at_end ? lane.successor : lane.predecessor) linked.push_back(*id);
  const double other_s = joint.other_end ? joint.other.length : 0.0;
  std::vector<double> borders = borders_of(joint.other, other_s, joint.sign, linked);
  if (road.driving_side == roadquery::DrivingSide::left)
    std::ranges::sort(borders);
  else
    std::ranges::sort(borders, std::ranges::greater());
  const auto [right, left] = std::minmax(borders.front(), borders.back());
  const roadquery::Edges edges{left, right};
  const double stretch = distance_across_m(joint.other, other_s, joint.sign, edges) / (left - right);
  const ProfileEnd end = end_beside(joint.other, joint.other_end, joint.sign, joint.t, edges);
  const roadquery::PlanPoint p = roadquery::reference_point(road, at_end ? road.length : 0.0);
  const roadquery::SurfacePoint border = roadquery::surface_point(joint.other, other_s, joint.sign * borders.front());
  const double left_m = std::cos(p.hdg) * (border.y - p.y) - std::sin(p.hdg) * (border.x - p.x);
  set_end(road.lane_offset, road.plan, at_end, left_m / std::cos(end.banking));
  for (std::size_t i = 0; i + 1 < borders.size(); ++i)
    set_end(lanes[i].width, road.plan, at_end, std::abs(borders[i + 1] - borders[i]) * stretch);
  return end;
}

/// What a connecting road has at one end: its own profile, or that of the road that it is linked to where that one was
/// laid on the surface.
ProfileEnd linked_end(const RoadMap& map, const std::map<int, std::size_t>& inner, Road& road, bool at_end) {
  const double s = at_end ? road.length : 0.0;
  const roadquery::RoadLink& link = at_end ? road.successor : road.predecessor;
  const auto found = link.kind == roadquery::LinkKind::road ? inner.find(link.id) : inner.end();
  if (found == inner.end())
    return {roadquery::elevation(road, s), roadquery::gradient(road, s), roadquery::superelevation(road, s)};
  const Road& other = map.roads[found->second];
  const bool other_end = link.contact == roadquery::ContactPoint::end;
  const double at = other_end ? other.length : 0.0, sign = other_end != at_end ? 1.0 : -1.0;
  const roadquery::PlanPoint p = roadquery::reference_point(road, s), q = roadquery::reference_point(other, at);
  const double left_m = -std::sin(q.hdg) * (p.x - q.x) + std::cos(q.hdg) * (p.y - q.y);
  constexpr double moved_m = 1e-3;
  const bool same_crown = road.shape.empty() == other.shape.empty();  // moved lines have none
  if (std::abs(left_m) < moved_m && same_crown)
    return {roadquery::elevation(other, at), sign * roadquery::gradient(other, at),
            sign * roadquery::superelevation(other, at)};
  return meet_beside(road, at_end, {other, other_end, sign, sign * roadquery::t_at(other, at, left_m)});
}

std::vector<Off> lay_connecting_roads(RoadMap& map, const std::vector<JunctionMembers>& members,
                                      const std::vector<int>& straight, int threads) {
  std::map<int, std::size_t> inner;
  for (const JunctionMembers& m : members)
    for (const std::size_t i : m.inner) inner[map.roads[i].id] = i;
  std::vector<Off> off(members.size());
  parallel_for(members.size(), threads, [&](std::size_t j) {
    if (!map.junctions[j].surface) return;
    const JunctionSurface& surface = *map.junctions[j].surface;
    for (const std::size_t i : members[j].connecting) {
      Road& road = map.roads[i];
      const double before = distance_from_surface_m(road, surface);
      const bool beside_inner = inner.contains(road.predecessor.id) || inner.contains(road.successor.id);
      const bool stays =
          !beside_inner && std::binary_search(straight.begin(), straight.end(), road.id) && before <= unchanged_m;
      double after = before;
      if (!stays) {
        const ProfileEnd start = linked_end(map, inner, road, false), end = linked_end(map, inner, road, true);
        Road fitted = refitted(road, surface, {start, end});
        after = distance_from_surface_m(fitted, surface);
        if (after <= before || beside_inner) road = std::move(fitted);
        after = beside_inner ? after : std::min(after, before);
      }
      off[j] = {std::max(off[j].before_m, before), std::max(off[j].after_m, after)};
    }
  });
  return off;
}

}  // namespace

JunctionSurfaceSummary add_junction_surfaces(RoadMap& map, const std::vector<int>& straight,
                                             const JunctionSurfaceOptions& options) {
  JunctionSurfaceSummary summary;
  const std::vector<JunctionMembers> members = junction_members(map, options.threads);
  std::vector<JunctionGround> grounds(members.size());
  const auto find_ground = [&](std::size_t j) {
    const auto seen = options.kerb_radius_m.find(map.junctions[j].id);
    const auto paved = options.paved.find(map.junctions[j].id);
    grounds[j] =
        ground_of(map, members[j], seen == options.kerb_radius_m.end() ? std::nullopt : std::optional(seen->second),
                  paved == options.paved.end() ? nullptr : &paved->second);
  };
  shared_for(options.exchange, "grounds", members.size(), options.threads, find_ground,
             [&](auto& archive, std::size_t j) { archive(grounds[j]); });
  const std::vector<std::vector<std::size_t>> groups = junctions_on_one_ground(map, members, grounds);
  std::vector<std::vector<Built>> built(groups.size());
  shared_for(
      options.exchange, "surfaces", groups.size(), options.threads,
      [&](std::size_t g) { built[g] = build_surfaces(map, members, group_of(groups[g], grounds), straight); },
      [&](auto& archive, std::size_t g) { archive(built[g]); });
  for (std::size_t g = 0; g < groups.size(); ++g)
    for (std::size_t k = 0; k < groups[g].size(); ++k) {
      const std::size_t j = groups[g][k];
      summary.junctions += 1, summary.area_m2 += grounds[j].area_m2;
      Built& one = built[g][k];
      if (one.surface) summary.grid_nodes += one.surface->z.size();
      summary.max_disagreement_m = std::max(summary.max_disagreement_m, one.disagreement_m);
      map.junctions[j].surface = std::move(one.surface);
    }
  roadquery::join_arms(map);
  lay_inner_roads(map, members);
  const std::vector<Off> off = lay_connecting_roads(map, members, straight, options.threads);
  for (const Off& o : off) {
    summary.max_road_off_before_m = std::max(summary.max_road_off_before_m, o.before_m);
    summary.max_road_off_after_m = std::max(summary.max_road_off_after_m, o.after_m);
  }
  return summary;
}

}  // namespace orthodrive::network
