#include "orthodrive/network/junction_surface.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "orthodrive/core/parallel.hpp"
#include "orthodrive/geo/spatial_index.hpp"
#include "orthodrive/model/road_network.hpp"
#include "orthodrive/network/junction_area.hpp"
#include "orthodrive/network/junction_field.hpp"
#include "orthodrive/network/refit_profile.hpp"
#include "roadquery/junction_surface.hpp"

namespace orthodrive::network {
namespace {

using roadquery::JunctionSurface;
using roadquery::LinkKind;
using roadquery::Road;
using roadquery::RoadMap;

constexpr double fine_m = 0.5;            // of the grid that is solved
constexpr double wide_m = 50.0;           // wider junctions are solved at twice that
constexpr double margin_m = 2.5;          // of the grid around the area: two nodes of 1 m
constexpr double coarse_error_m = 0.005;  // of a coarser grid from the one that was solved
constexpr double same_height_m = 0.01;    // ways straight on that differ by more where they cross: one gives way
constexpr double same_level_m = 2.5;      // other roads nearer in height share the ground
constexpr double unchanged_m = 0.005;     // ways straight on that lie so near to the surface stay as they are
constexpr double millimetre = 1e-3, height_step_m = 1e-4;

double rounded(double v, double step) { return std::round(v / step) * step; }

/// The junction's roads by index of the map.
struct Members {
  std::vector<std::size_t> connecting, arms, others;
  std::vector<bool> at_end;
};

Vec2 origin_of(const Road& road) { return {std::round(road.plan.front().x), std::round(road.plan.front().y)}; }

Box2 box_of(const Road& road) { return RoadCover(road, {}, 0.0, road.length).bounds(); }

std::map<int, std::size_t> junction_places(const RoadMap& map) {
  std::map<int, std::size_t> place;
  for (std::size_t j = 0; j < map.junctions.size(); ++j) place[map.junctions[j].id] = j;
  return place;
}

std::vector<Members> members_of(const RoadMap& map) {
  const std::map<int, std::size_t> place = junction_places(map);
  std::vector<Members> members(map.junctions.size());
  const auto junction_at = [&](const roadquery::RoadLink& link) {
    const auto found = link.kind == LinkKind::junction ? place.find(link.id) : place.end();
    return found != place.end() ? &members[found->second] : nullptr;
  };
  for (std::size_t i = 0; i < map.roads.size(); ++i) {
    const Road& road = map.roads[i];
    if (road.junction >= 0) {
      if (const auto found = place.find(road.junction); found != place.end() && road.length > 0.0)
        members[found->second].connecting.push_back(i);
      continue;
    }
    if (Members* m = junction_at(road.predecessor)) m->arms.push_back(i), m->at_end.push_back(false);
    if (Members* m = junction_at(road.successor)) m->arms.push_back(i), m->at_end.push_back(true);
  }
  return members;
}

double middle_height(const Road& road) { return roadquery::elevation(road, 0.5 * road.length); }

/// Roads near the junction that it must leave alone: on its level, neither its arms nor its connecting roads.
void find_others(const RoadMap& map, std::vector<Members>& members, int threads) {
  std::vector<Box2> boxes(map.roads.size());
  parallel_for(map.roads.size(), threads, [&](std::size_t i) { boxes[i] = box_of(map.roads[i]); });
  const SpatialIndex index(boxes);
  constexpr double reach_m = 12.0;  // the largest kerb radius
  for (Members& m : members) {
    if (m.connecting.empty()) continue;
    Box2 box = boxes[m.connecting.front()];
    double z = 0.0;
    for (const std::size_t i : m.connecting) {
      box = {std::min(box.min_x, boxes[i].min_x), std::min(box.min_y, boxes[i].min_y),
             std::max(box.max_x, boxes[i].max_x), std::max(box.max_y, boxes[i].max_y)};
      z += middle_height(map.roads[i]) / static_cast<double>(m.connecting.size());
    }
    for (const std::size_t i : index.touching(box.grown(reach_m))) {
      const auto among = [i](const std::vector<std::size_t>& list) {
        return std::find(list.begin(), list.end(), i) != list.end();
      };
      const Road& road = map.roads[i];
      const double low =
          std::min({middle_height(road), roadquery::elevation(road, 0.0), roadquery::elevation(road, road.length)});
      const double high =
          std::max({middle_height(road), roadquery::elevation(road, 0.0), roadquery::elevation(road, road.length)});
      if (among(m.connecting) || among(m.arms) || low > z + same_level_m || high < z - same_level_m) continue;
      m.others.push_back(i);
    }
  }
}

JunctionRoads roads_of(const RoadMap& map, const Members& members) {
  JunctionRoads roads;
  for (const std::size_t i : members.connecting) roads.connecting.push_back(&map.roads[i]);
  for (const std::size_t i : members.arms) roads.arms.push_back(&map.roads[i]);
  for (const std::size_t i : members.others) roads.others.push_back(&map.roads[i]);
  roads.at_end = members.at_end;
  return roads;
}

FieldGrid grid_over(const Ring& boundary) {
  const Box2 box = bounds_of(boundary).grown(margin_m);
  FieldGrid grid;
  grid.spacing_m = std::max(box.width(), box.height()) > wide_m ? 2.0 * fine_m : fine_m;
  grid.origin = {std::floor(box.min_x / millimetre) * millimetre, std::floor(box.min_y / millimetre) * millimetre};
  const auto nodes = [&](double size) { return 4 * static_cast<int>(std::ceil(size / (4.0 * grid.spacing_m))) + 1; };
  grid.columns = nodes(box.width()), grid.rows = nodes(box.height());
  return grid;
}

/// The arms' ends, relative to the origin.
std::vector<roadquery::JunctionArm> entries_of(const RoadMap& map, const Members& members, Vec2 origin) {
  std::vector<roadquery::JunctionArm> entries;
  for (std::size_t k = 0; k < members.arms.size(); ++k) {
    entries.push_back(roadquery::junction_arm(
        map.roads[members.arms[k]], members.at_end[k] ? roadquery::ContactPoint::end : roadquery::ContactPoint::start));
    entries.back().x -= origin.x, entries.back().y -= origin.y;
  }
  return entries;
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

bool disagree(const FieldRoad& a, const FieldRoad& b) {
  for (std::size_t i = 0; i < a.z.size(); ++i)
    if (std::abs(a.z[i] - b.z[i]) > same_height_m) return true;  // false for NaN: not on both
  return false;
}

/// Roads with their roles: of the ways straight on, the first by class, then width, then id keep their shape; those
/// that they cross give way.
std::vector<FieldRoad> field_roads(const RoadMap& map, const Members& members, const std::vector<int>& straight,
                                   const FieldGrid& grid, Vec2 origin) {
  std::vector<FieldRoad> roads;
  constexpr double reach_m = 20.0;
  for (std::size_t k = 0; k < members.arms.size(); ++k) {
    const Road& road = map.roads[members.arms[k]];
    const double reach = std::min(reach_m, road.length), s0 = members.at_end[k] ? road.length - reach : 0.0;
    roads.push_back(over_grid(grid, RoadCover(road, origin, s0, s0 + reach), RoadRole::arm));
  }
  std::vector<const Road*> ways;
  for (const std::size_t i : members.connecting) ways.push_back(&map.roads[i]);
  const auto is_straight = [&](const Road& road) {
    return std::binary_search(straight.begin(), straight.end(), road.id);
  };
  std::stable_sort(ways.begin(), ways.end(), [&](const Road* a, const Road* b) {
    if (is_straight(*a) != is_straight(*b)) return is_straight(*a);
    return straight_before(*a, *b);
  });
  std::vector<std::size_t> main;
  for (const Road* way : ways) {
    FieldRoad road = over_grid(grid, RoadCover(*way, origin, 0.0, way->length), RoadRole::turning);
    if (is_straight(*way)) {
      const bool crosses =
          std::any_of(main.begin(), main.end(), [&](std::size_t m) { return disagree(roads[m], road); });
      road.role = crosses ? RoadRole::straight : RoadRole::main;
      if (!crosses) main.push_back(roads.size());
    }
    roads.push_back(std::move(road));
  }
  return roads;
}

/// Largest difference of two connecting roads over one node.
double disagreement_m(const std::vector<FieldRoad>& roads) {
  double largest = 0.0;
  for (std::size_t i = 0; !roads.empty() && i < roads.front().z.size(); ++i) {
    double low = INFINITY, high = -INFINITY;
    for (const FieldRoad& road : roads) {
      if (road.role == RoadRole::arm || std::isnan(road.z[i])) continue;
      low = std::min(low, road.z[i]), high = std::max(high, road.z[i]);
    }
    if (high > low) largest = std::max(largest, high - low);
  }
  return largest;
}

/// Every `step`-th node of a surface.
JunctionSurface thinned(const JunctionSurface& fine, int step) {
  JunctionSurface coarse = fine;
  coarse.spacing_m = fine.spacing_m * step;
  coarse.columns = (fine.columns - 1) / step + 1, coarse.rows = (fine.rows - 1) / step + 1;
  coarse.z.clear();
  for (int r = 0; r < fine.rows; r += step)
    for (int c = 0; c < fine.columns; c += step)
      coarse.z.push_back(
          fine.z[static_cast<std::size_t>(r) * static_cast<std::size_t>(fine.columns) + static_cast<std::size_t>(c)]);
  return coarse;
}

/// Whether a coarser grid has the heights of the fine one at its nodes inside the boundary, and nodes all round.
bool reproduces(const JunctionSurface& coarse, const JunctionSurface& fine) {
  const double reach = 1.0 * coarse.spacing_m;
  for (const auto& [x, y] : fine.boundary)
    if (x - coarse.x < reach || y - coarse.y < reach ||
        coarse.x + (coarse.columns - 1) * coarse.spacing_m - x < reach ||
        coarse.y + (coarse.rows - 1) * coarse.spacing_m - y < reach)
      return false;
  for (int r = 0; r < fine.rows; ++r)
    for (int c = 0; c < fine.columns; ++c) {
      const double x = fine.x + c * fine.spacing_m, y = fine.y + r * fine.spacing_m;
      const double z =
          fine.z[static_cast<std::size_t>(r) * static_cast<std::size_t>(fine.columns) + static_cast<std::size_t>(c)];
      if (roadquery::contains(fine, x, y) && std::abs(roadquery::evaluate(coarse, x, y).z - z) > coarse_error_m)
        return false;
    }
  return true;
}

struct Built {
  std::optional<JunctionSurface> surface;
  double area_m2 = 0.0, disagreement_m = 0.0;
};

Built build_surface(const RoadMap& map, const Members& members, const std::vector<int>& straight,
                    std::optional<double> seen_radius_m) {
  Built built;
  if (members.connecting.empty()) return built;
  const Vec2 origin = origin_of(map.roads[members.connecting.front()]);
  std::vector<std::string> classes;
  for (const std::size_t i : members.arms) classes.push_back(map.roads[i].highway);
  const MultiPolygon area =
      junction_area(roads_of(map, members), seen_radius_m.value_or(kerb_radius_m(classes)), origin);
  const Ring boundary = woven_ring(area);
  if (boundary.size() < 3) return built;
  for (const Polygon& part : area) built.area_m2 += area_m2(part);
  const FieldGrid grid = grid_over(boundary);
  const std::vector<FieldRoad> roads = field_roads(map, members, straight, grid, origin);
  built.disagreement_m = disagreement_m(roads);
  JunctionSurface surface;
  for (const Vec2 p : boundary)
    surface.boundary.push_back({origin.x + rounded(p.x, millimetre), origin.y + rounded(p.y, millimetre)});
  surface.x = origin.x + grid.origin.x, surface.y = origin.y + grid.origin.y;
  surface.spacing_m = grid.spacing_m, surface.columns = grid.columns, surface.rows = grid.rows;
  surface.z = bend_least(grid, field_targets(grid, roads, entries_of(map, members, origin)));
  for (double& z : surface.z) z = rounded(z, height_step_m);
  for (const int step : {4, 2}) {
    JunctionSurface coarse = thinned(surface, step);
    if (coarse.spacing_m > 2.0 || !reproduces(coarse, surface)) continue;
    surface = std::move(coarse);
    break;
  }
  built.surface = std::move(surface);
  return built;
}

}  // namespace

JunctionSurfaceSummary add_junction_surfaces(RoadMap& map, const std::vector<int>& straight,
                                             const JunctionSurfaceOptions& options) {
  JunctionSurfaceSummary summary;
  std::vector<Members> members = members_of(map);
  find_others(map, members, options.threads);
  std::vector<Built> built(members.size());
  parallel_for(members.size(), options.threads, [&](std::size_t j) {
    const auto seen = options.kerb_radius_m.find(map.junctions[j].id);
    built[j] = build_surface(map, members[j], straight,
                             seen == options.kerb_radius_m.end() ? std::nullopt : std::optional(seen->second));
  });
  for (std::size_t j = 0; j < built.size(); ++j) {
    if (!built[j].surface) continue;
    summary.junctions += 1, summary.area_m2 += built[j].area_m2, summary.grid_nodes += built[j].surface->z.size();
    summary.max_disagreement_m = std::max(summary.max_disagreement_m, built[j].disagreement_m);
    map.junctions[j].surface = std::move(built[j].surface);
  }
  roadquery::join_arms(map);
  struct Off {
    double before_m = 0.0, after_m = 0.0;
  };
  std::vector<Off> off(members.size());
  parallel_for(members.size(), options.threads, [&](std::size_t j) {
    if (!map.junctions[j].surface) return;
    const JunctionSurface& surface = *map.junctions[j].surface;
    for (const std::size_t i : members[j].connecting) {
      Road& road = map.roads[i];
      const double before = distance_from_surface_m(road, surface);
      const bool stays = std::binary_search(straight.begin(), straight.end(), road.id) && before <= unchanged_m;
      double after = before;
      if (!stays) {
        Road fitted = refitted(road, surface);
        after = distance_from_surface_m(fitted, surface);
        if (after <= before) road = std::move(fitted);
        after = std::min(after, before);
      }
      off[j] = {std::max(off[j].before_m, before), std::max(off[j].after_m, after)};
    }
  });
  for (const Off& o : off) {
    summary.max_road_off_before_m = std::max(summary.max_road_off_before_m, o.before_m);
    summary.max_road_off_after_m = std::max(summary.max_road_off_after_m, o.after_m);
  }
  return summary;
}

}  // namespace orthodrive::network
